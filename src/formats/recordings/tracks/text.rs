//! Rows of tables in text: separated values and JSON lines, in blocks that are read at once on all cores.

use std::borrow::Cow;
use std::collections::HashSet;
use std::io::Read;

use rayon::prelude::*;
use serde_json::Value;

use super::batch::{Batch, Values, Wanted};
use super::columns::Columns;
use crate::recordings::rows;

/// A file that cannot be read.
pub fn unread(message: String) -> BadCell {
    BadCell {
        message,
        ..BadCell::default()
    }
}

/// How a table is written.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// What is between two values.
    pub form: Form,
    /// The names of the columns; their places from 1 where there is no header.
    pub names: Vec<String>,
    /// Lines before the first row.
    pub before: usize,
}

/// Between two values of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// This byte.
    Separated(u8),
    /// White space, as much as one likes.
    Spaced,
    /// A row is an object of JSON.
    JsonLines,
    /// All rows are an array of objects of JSON.
    JsonArray,
}

/// A mistake in a cell or row.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct BadCell {
    /// From 1.
    pub line: usize,
    /// The column; empty for the whole row.
    pub column: String,
    /// What is wrong.
    pub message: String,
}

/// Bytes that are split at once.
const BLOCK: usize = 2 << 20;

/// No table that is read at once has more lines, with empty ones and comments: a packed one can be of any size.
const MOST_LINES: usize = 100_000_000;

/// No line is longer, bytes.
const LONGEST_LINE: usize = 1 << 20;

impl Layout {
    /// The layout of a table that begins with `head`; nothing where that is no table. Where what is `said` of tables are
    /// places of columns, and a number stands where x is, it has no header.
    pub fn detect(head: &[u8], said: &[&Columns]) -> Option<Self> {
        let text = String::from_utf8_lossy(head);
        let text = text.trim_start_matches('\u{feff}');
        if text.contains('\0') || text.trim_start().starts_with('<') {
            return None;
        }
        if text.starts_with(['{', '[']) {
            return Self::json(text);
        }
        // Comments and empty lines may stand before the header, and the header may be a comment.
        let mut before = 0;
        let mut comment = "";
        let line = text.lines().find(|line| {
            let is_comment = line.trim().is_empty() || line.starts_with('#');
            if is_comment {
                before += 1;
                comment = line.trim_start_matches('#');
            }
            !is_comment
        })?;
        let (form, mut names) = fields(line);
        if names.len() < 3 {
            return None;
        }
        let is_number = |field: &String| rows::number(field, form.separator()).is_some();
        let (_, commented) = fields(comment);
        let is_header = commented.len() > 2 && !commented.iter().any(is_number);
        if is_header
            && names.iter().any(is_number)
            && (commented.len() == names.len() || comment.contains(','))
        {
            names = commented;
        } else if names.iter().all(is_number) || said.iter().any(|said| said.are_places(&names)) {
            names = (1..=names.len()).map(|place| place.to_string()).collect();
        } else {
            before += 1;
        }
        Some(Self {
            form,
            names,
            before,
        })
    }

    /// That of objects of JSON, in lines or in an array. The first rows may lack values: columns are those of all.
    fn json(text: &str) -> Option<Self> {
        let (form, lines) = if text.starts_with('[') {
            let mut lines = Vec::new();
            // The end of it is cut off, perhaps within a letter.
            Elements::of(&mut text.as_bytes())
                .read_to_end(&mut lines)
                .ok()?;
            (Form::JsonArray, Cow::Owned(lines))
        } else {
            (Form::JsonLines, Cow::Borrowed(text.as_bytes()))
        };
        let all = lines.split(|b| *b == b'\n');
        let mut rows = all.filter(|line| !line.trim_ascii().is_empty());
        let first: Value = serde_json::from_slice(rows.next()?).ok()?;
        let mut names = Vec::new();
        flatten(&first, "", &mut names);
        for row in rows.map_while(|row| serde_json::from_slice(row).ok()) {
            let mut more = Vec::new();
            flatten(&row, "", &mut more);
            more.retain(|name| !names.contains(name));
            names.extend(more);
        }
        first.is_object().then_some(Self {
            form,
            names,
            before: 0,
        })
    }

    /// Which times and scenarios are where in a table; `wanted` are its clock and names.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn pieces(
        &self,
        source: &mut dyn Read,
        wanted: &[Wanted],
        take: &mut dyn FnMut(Piece, Batch),
    ) -> Result<(), BadCell> {
        let places = self.places(wanted);
        self.blocks(source, &mut |some| {
            let read = some.par_iter().map(|block| {
                let rows = self.rows(block.line, &block.bytes, wanted, &places)?;
                Ok((block.piece(), rows))
            });
            let read: Vec<Result<(Piece, Batch), BadCell>> = read.collect();
            read.into_iter().try_for_each(|one| {
                let (piece, rows) = one?;
                take(piece, rows);
                Ok(())
            })
        })
    }

    /// The rows of a piece, from its bytes.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn piece(&self, piece: &Piece, bytes: &[u8], wanted: &[Wanted]) -> Result<Batch, BadCell> {
        self.rows(piece.line, bytes, wanted, &self.places(wanted))
    }

    fn places(&self, wanted: &[Wanted]) -> Vec<Option<usize>> {
        let place = |wanted: &Wanted| self.names.iter().position(|name| *name == wanted.name);
        wanted.iter().map(place).collect()
    }

    /// Reads all rows and gives those of a block at a time to `take`.
    ///
    /// # Errors
    /// The first cell that is no number where one is wanted, a line that is too long, too many lines, or what `take` says.
    pub fn read(
        &self,
        source: &mut dyn Read,
        wanted: &[Wanted],
        take: &mut dyn FnMut(Batch) -> Result<(), BadCell>,
    ) -> Result<(), BadCell> {
        let places = self.places(wanted);
        self.blocks(source, &mut |some| {
            if let Some(block) = some.iter().find(|block| block.line > MOST_LINES) {
                return Err(BadCell {
                    line: block.line,
                    ..unread(format!("more than {MOST_LINES} lines; split the table"))
                });
            }
            let read: Vec<Result<Batch, BadCell>> = some
                .par_iter()
                .map(|block| self.rows(block.line, &block.bytes, wanted, &places))
                .collect();
            read.into_iter().try_for_each(|batch| take(batch?))
        })
    }

    /// Gives the blocks of a table, as many at once as there are cores.
    fn blocks(
        &self,
        source: &mut dyn Read,
        take: &mut dyn FnMut(&[Block]) -> Result<(), BadCell>,
    ) -> Result<(), BadCell> {
        let mut elements;
        let source: &mut dyn Read = if self.form == Form::JsonArray {
            elements = Elements::of(source);
            &mut elements
        } else {
            source
        };
        let mut blocks = Blocks {
            source,
            rest: Vec::new(),
            line: 1,
            at: 0,
            ended: false,
        };
        let at_once = rayon::current_num_threads().max(1);
        loop {
            let mut some = Vec::with_capacity(at_once);
            while some.len() < at_once
                && let Some(block) = blocks.next()?
            {
                some.push(block);
            }
            if some.is_empty() {
                return Ok(());
            }
            take(&some)?;
        }
    }

    /// The rows of a block whose first line has this number.
    fn rows(
        &self,
        first: usize,
        block: &[u8],
        wanted: &[Wanted],
        places: &[Option<usize>],
    ) -> Result<Batch, BadCell> {
        match self.form {
            Form::JsonLines | Form::JsonArray => json_rows(first, block, wanted, &self.names),
            Form::Separated(separator) => self.separated(first, block, separator, wanted, places),
            Form::Spaced => {
                let mut plain = Vec::with_capacity(block.len());
                for line in block.split_inclusive(|b| *b == b'\n') {
                    let mut fields = line
                        .split(u8::is_ascii_whitespace)
                        .filter(|field| !field.is_empty());
                    if let Some(field) = fields.next() {
                        plain.extend(field);
                    }
                    for field in fields {
                        plain.push(b'\t');
                        plain.extend(field);
                    }
                    plain.push(b'\n');
                }
                self.separated(first, &plain, b'\t', wanted, places)
            }
        }
    }

    /// Whether a row is the header once more, as where files were put one behind the other.
    fn is_header(&self, record: &csv::ByteRecord) -> bool {
        let is_name = |(field, name): (&[u8], &String)| {
            let field = std::str::from_utf8(field);
            field.is_ok_and(|field| rows::bare(field.trim_start_matches('#')) == name)
        };
        record.len() == self.names.len() && record.iter().zip(&self.names).all(is_name)
    }

    fn separated(
        &self,
        first: usize,
        block: &[u8],
        separator: u8,
        wanted: &[Wanted],
        places: &[Option<usize>],
    ) -> Result<Batch, BadCell> {
        let mut batch = Batch::new(wanted);
        let skipped = self.before.saturating_sub(first - 1);
        // A text in the first column may begin as comments do, a number may not.
        let mut of = places.iter().zip(wanted);
        let begins_with_number = of.any(|(place, of)| *place == Some(0) && !of.is_text);
        let mut table = csv::ReaderBuilder::new()
            .delimiter(separator)
            .has_headers(false)
            .flexible(true)
            .from_reader(block);
        let mut record = csv::ByteRecord::new();
        loop {
            let more = table.read_byte_record(&mut record);
            let line = first + line_of(&record, block);
            let bad = |column: &str, message: String| BadCell {
                line,
                column: column.to_string(),
                message,
            };
            if !more.map_err(|error| bad("", error.to_string()))? {
                return Ok(batch);
            }
            if let Some(place) = record.iter().position(|field| field.contains(&b'\n')) {
                let column = self.names.get(place).map_or("", String::as_str);
                let message = "a quoted value over several lines; is a quote missing?";
                return Err(bad(column, message.into()));
            }
            let is_marked = record.get(0).is_some_and(|field| field.starts_with(b"#"));
            let is_row = record.len() == self.names.len() && !begins_with_number;
            let is_comment = is_marked && !is_row && !self.is_header(&record);
            if line - first < skipped || is_comment || record.iter().all(<[u8]>::is_empty) {
                continue;
            }
            if self.is_header(&record) {
                batch.headers += 1;
                continue;
            }
            if let Some(why) = rows::too_long(record.iter(), self.names.len()) {
                return Err(bad("", why));
            }
            // Between spaces no value can be empty.
            let fewest = match self.form {
                Form::Spaced => self.names.len(),
                _ => needed(places),
            };
            if record.len() < fewest {
                let message = format!(
                    "{} values for {} columns; the line is cut off, or a value is missing",
                    record.len(),
                    self.names.len()
                );
                return Err(bad("", message));
            }
            for (column, place) in places.iter().enumerate() {
                let field = place
                    .and_then(|place| record.get(place))
                    .unwrap_or_default();
                let text = std::str::from_utf8(field);
                let text = text.map_err(|_| bad(&wanted[column].name, NOT_UTF8.into()))?;
                let done = batch.push(column, text, separator);
                done.map_err(|message| bad(&wanted[column].name, message))?;
            }
            batch.lines.push(u32::try_from(line).unwrap_or(u32::MAX));
        }
    }
}

/// Said of text in another encoding.
pub const NOT_UTF8: &str = "not UTF-8 text; save the file as UTF-8";

/// How many columns a text has whose first line is mostly numbers, and so no header.
pub fn without_header(text: &str) -> Option<usize> {
    let mut lines = text.lines();
    let first = lines.find(|line| !line.trim().is_empty() && !line.starts_with('#'))?;
    let (form, row) = fields(first);
    let is_number = |field: &&String| rows::number(field, form.separator()).is_some();
    let numbers = row.iter().filter(is_number).count();
    (row.len() > 2 && numbers * 2 > row.len()).then_some(row.len())
}

/// The fields of a line, and what is between them.
fn fields(line: &str) -> (Form, Vec<String>) {
    let (separator, names) = rows::columns_of(line.as_bytes());
    let spaced: Vec<String> = line.split_whitespace().map(rows::name).collect();
    if names.len() == 1 && spaced.len() > 2 {
        return (Form::Spaced, spaced);
    }
    (Form::Separated(separator), names)
}

impl Form {
    /// What is between fields once they are split.
    fn separator(self) -> u8 {
        match self {
            Self::Separated(separator) => separator,
            Self::Spaced | Self::JsonLines | Self::JsonArray => b'\t',
        }
    }
}

/// The elements of an array of JSON as lines.
struct Elements<'r> {
    source: &'r mut dyn Read,
    /// Within so many brackets and braces.
    depth: usize,
    is_text: bool,
    is_escaped: bool,
}

impl<'r> Elements<'r> {
    fn of(source: &'r mut dyn Read) -> Self {
        Self {
            source,
            depth: 0,
            is_text: false,
            is_escaped: false,
        }
    }

    /// A byte as it is in lines.
    fn line(&mut self, byte: u8) -> u8 {
        if self.is_text {
            self.is_text = byte != b'"' || self.is_escaped;
            self.is_escaped = byte == b'\\' && !self.is_escaped;
            return byte;
        }
        let outer = self.depth;
        match byte {
            b'"' => self.is_text = true,
            b'[' | b'{' => self.depth += 1,
            b']' | b'}' => self.depth = outer.saturating_sub(1),
            b',' if outer == 1 => return b'\n',
            b'\n' | b'\r' => return b' ',
            _ => {}
        }
        // The brackets of the array itself.
        let is_outermost = outer.min(self.depth) == 0 && outer != self.depth;
        if is_outermost { b' ' } else { byte }
    }
}

impl Read for Elements<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let count = self.source.read(into)?;
        for byte in &mut into[..count] {
            *byte = self.line(*byte);
        }
        Ok(count)
    }
}

/// How many lines a record is after the first one of its block; the position of one is before the empty lines that come
/// before it.
fn line_of(record: &csv::ByteRecord, block: &[u8]) -> usize {
    let Some(position) = record.position() else {
        return 0;
    };
    let start = usize::try_from(position.byte()).unwrap_or(block.len());
    let rest = block.get(start..).unwrap_or_default();
    let empty = rest.iter().take_while(|b| matches!(b, b'\n' | b'\r'));
    let empty = empty.filter(|b| **b == b'\n').count();
    usize::try_from(position.line()).unwrap_or(1) - 1 + empty
}

/// So many fields a row has at least to have all wanted ones.
fn needed(places: &[Option<usize>]) -> usize {
    places.iter().flatten().max().map_or(0, |last| last + 1)
}

/// Where whole lines of a table are.
#[derive(Debug, Clone, Copy)]
pub struct Piece {
    /// The first byte.
    pub at: u64,
    /// Bytes.
    pub bytes: usize,
    /// The number of the first line.
    pub line: usize,
}

/// Whole lines.
struct Block {
    line: usize,
    at: u64,
    bytes: Vec<u8>,
}

impl Block {
    fn piece(&self) -> Piece {
        Piece {
            at: self.at,
            bytes: self.bytes.len(),
            line: self.line,
        }
    }
}

/// Blocks of whole lines.
struct Blocks<'r> {
    source: &'r mut dyn Read,
    /// The beginning of a line whose end has not been read.
    rest: Vec<u8>,
    /// The number of its line, and of its first byte.
    line: usize,
    at: u64,
    ended: bool,
}

impl Blocks<'_> {
    /// The next block; nothing at the end.
    fn next(&mut self) -> Result<Option<Block>, BadCell> {
        let fail = |line, message: String| BadCell {
            line,
            column: String::new(),
            message,
        };
        while !self.ended {
            let before = self.rest.len();
            if before > BLOCK + LONGEST_LINE {
                let message = format!("a line of more than {LONGEST_LINE} bytes");
                return Err(fail(self.line, message));
            }
            self.rest.resize(before + BLOCK, 0);
            let mut filled = before;
            while filled < self.rest.len() {
                match self.source.read(&mut self.rest[filled..]) {
                    Ok(0) => {
                        self.ended = true;
                        break;
                    }
                    Ok(count) => filled += count,
                    Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                    Err(error) => {
                        // What the system says has a number; what unpacks has none.
                        let instead = match error.raw_os_error() {
                            None => "; the packed file is damaged or cut off: get it again",
                            Some(_) => "",
                        };
                        let message = format!("cannot be read: {error}{instead}");
                        return Err(fail(self.line, message));
                    }
                }
            }
            self.rest.truncate(filled);
            let end = match self.rest.iter().rposition(|b| *b == b'\n') {
                Some(last) if !self.ended => last + 1,
                _ if self.ended => self.rest.len(),
                _ => continue,
            };
            let after = self.rest.split_off(end);
            let mut block = std::mem::replace(&mut self.rest, after);
            if block.is_empty() {
                return Ok(None);
            }
            let (line, mut at) = (self.line, self.at);
            self.line += block.iter().filter(|b| **b == b'\n').count();
            self.at += block.len() as u64;
            if line == 1 && block.starts_with(b"\xef\xbb\xbf") {
                block.drain(..3);
                at += 3;
            }
            return Ok(Some(Block {
                line,
                at,
                bytes: block,
            }));
        }
        Ok(None)
    }
}

fn json_rows(
    first: usize,
    block: &[u8],
    wanted: &[Wanted],
    names: &[String],
) -> Result<Batch, BadCell> {
    let mut batch = Batch::new(wanted);
    // Also those of objects within, as `position` of `position.x`.
    let known = names.iter().flat_map(|name| {
        let dots = name.match_indices('.').map(|(at, _)| at);
        dots.chain([name.len()]).map(|end| &name[..end])
    });
    let known: HashSet<&str> = known.collect();
    for (i, line) in block.split(|b| *b == b'\n').enumerate() {
        if line.trim_ascii().is_empty() {
            continue;
        }
        let bad = |column: &str, message: String| BadCell {
            line: first + i,
            column: column.to_string(),
            message,
        };
        let row: Value = serde_json::from_slice(line)
            .map_err(|error| bad("", format!("not an object of JSON ({error})")))?;
        let keys = row.as_object().into_iter().flat_map(|row| row.keys());
        batch.unknown += keys.filter(|key| !known.contains(key.as_str())).count();
        for (column, wanted) in wanted.iter().enumerate() {
            let value = at(&row, &wanted.name);
            let done = match (value, &mut batch.values[column]) {
                (Some(Value::Number(number)), Values::Numbers(all)) => {
                    all.push(number.as_f64().unwrap_or(f64::NAN));
                    Ok(())
                }
                (Some(Value::String(text)), _) => batch.push(column, text, b';'),
                (Some(Value::Null) | None, _) => batch.push(column, "", b';'),
                (Some(other), _) => batch.push(column, &other.to_string(), b';'),
            };
            done.map_err(|message| bad(&wanted.name, message))?;
        }
        batch
            .lines
            .push(u32::try_from(first + i).unwrap_or(u32::MAX));
    }
    Ok(batch)
}

/// The names of all values in an object, those within others as `position.x`, those in lists as `position.0`.
fn flatten(value: &Value, name: &str, names: &mut Vec<String>) {
    let inner = |key: &str| {
        if name.is_empty() {
            key.to_string()
        } else {
            format!("{name}.{key}")
        }
    };
    match value {
        Value::Object(fields) => {
            for (key, value) in fields {
                flatten(value, &inner(key), names);
            }
        }
        Value::Array(all) if all.len() <= 4 => {
            for (i, value) in all.iter().enumerate() {
                flatten(value, &inner(&i.to_string()), names);
            }
        }
        _ => names.push(name.to_string()),
    }
}

/// The value that [`flatten`] calls so.
fn at<'v>(row: &'v Value, name: &str) -> Option<&'v Value> {
    if let Some(value) = row.get(name) {
        return Some(value);
    }
    name.split('.').try_fold(row, |value, key| match value {
        Value::Array(all) => all.get(key.parse::<usize>().ok()?),
        value => value.get(key),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn wanted() -> Vec<Wanted> {
        let of = |name: &str, is_text| Wanted {
            name: name.into(),
            is_text,
        };
        vec![of("id", true), of("x", false)]
    }

    fn rows(text: &str) -> Result<Vec<(String, f64, u32)>, BadCell> {
        let layout = Layout::detect(text.as_bytes(), &[]).unwrap();
        let mut all = Vec::new();
        layout.read(&mut text.as_bytes(), &wanted(), &mut |batch| {
            let [Values::Texts(ids, texts), Values::Numbers(x)] = &batch.values[..] else {
                panic!()
            };
            for (i, line) in batch.lines.iter().enumerate() {
                all.push((texts.texts[ids[i] as usize].clone(), x[i], *line));
            }
            Ok(())
        })?;
        Ok(all)
    }

    #[test]
    fn rows_have_their_lines_in_every_layout() {
        let expected = [("a".to_string(), 1.5, 2), ("b".to_string(), 2.5, 4)];
        for text in [
            "id,x,t\na,1.5,0\n\nb,2.5,1\n",
            "\u{feff}id;x;t\r\na;1,5;0\r\n\r\nb;2,5;1",
            "id\tx\tt\na\t1.5\t0\n# a comment\nb\t2.5\t1\n",
            "  id   x  t\n a 1.5   0\n\n b 2.5 1\n",
        ] {
            assert_eq!(rows(text).unwrap(), expected, "{text:?}");
        }
        let array = "[{\"id\":\"a\",\"x\":1.5,\"t\":[0,1]},\n {\"id\":\"b]\\\"\",\n\"x\":2.5}]\n";
        let expected = [("a".to_string(), 1.5, 1), ("b]\"".to_string(), 2.5, 2)];
        assert_eq!(rows(array).unwrap(), expected);
        let json = "{\"id\":\"a\",\"x\":1.5,\"t\":0}\n{\"x\":\"2.5\",\"id\":\"b\",\"t\":1}\n";
        let lines: Vec<u32> = rows(json).unwrap().iter().map(|row| row.2).collect();
        assert_eq!(lines, [1, 2]);
    }

    #[test]
    fn the_header_may_come_once_more() {
        let text = "\u{feff}id,x,t\na,1,0\n\u{feff}id,\"x\",t\nb,2,0\n";
        assert_eq!(rows(text).unwrap().len(), 2);
    }

    #[test]
    fn blocks_end_with_lines() {
        let mut text = String::from("id,x,t\n");
        for i in 0..300_000 {
            text.push_str(&format!("track{},{i}.25,{i}\n", i % 7));
        }
        assert!(text.len() > 2 * BLOCK);
        let all = rows(&text).unwrap();
        assert_eq!(all.len(), 300_000);
        let right = |(i, row): (usize, &(String, f64, u32))| {
            row.0 == format!("track{}", i % 7)
                && row.1 == i as f64 + 0.25
                && row.2 as usize == i + 2
        };
        assert!(all.iter().enumerate().all(right));
    }

    #[test]
    fn mistakes_have_line_and_column() {
        let error = |text: &str| {
            let bad = rows(text).unwrap_err();
            format!("{}:{}: {}", bad.line, bad.column, bad.message)
        };
        assert_eq!(
            error("id,x,t\na,1,0\nb,one,1\n"),
            "3:x: `one` is not a number"
        );
        assert!(error("id,x,t\na,1,0,7\n").starts_with("2:: 4 fields for 3"));
        assert!(error("id,t,y,x\na,1,0,1\nb,1\n").starts_with("3:: 2 values for 4"));
        // One that is short of a value may lack it anywhere.
        assert!(error("id,t,y,x\na,1,0,1\nb,1,0\n").starts_with("3:: 3 values for 4"));
        assert!(error("id x t\na 1 0\nb 1\n").starts_with("3:: 2 values for 3"));
        assert_eq!(rows("id,x,note\na,1\n").map(|rows| rows.len()), Ok(1));
        for text in [
            "id,x,t,note\na,1,0,\nb,2,1,\"see\nc,3,2,\n",
            "id,x,t,note\na,1,0,\nb,2,1,\"see\nthis\"\nc,3,2,\n",
        ] {
            assert!(error(text).starts_with("3:note: a quoted value over several lines"));
        }
        assert_eq!(rows("id,x,t\n# a\n#7,1,0\n").unwrap()[0].0, "#7");
        assert_eq!(
            rows("x,id,t\n#7,1,0\n# a,b,c\n").map(|rows| rows.len()),
            Ok(0)
        );
        assert!(error("{\"id\":1,\"x\":2}\n{\"id\"").starts_with("2:: not an object"));
    }

    #[test]
    fn tables_without_a_header_have_numbers_as_names() {
        let layout = Layout::detect(b"1 2.5 3\n4 5 6\n", &[]).unwrap();
        assert_eq!((layout.form, layout.before), (Form::Spaced, 0));
        assert_eq!(layout.names, ["1", "2", "3"]);
        // A text, or an id of 1, makes no header where places are said.
        let said: Columns = "time=1,id=2,x=3,y=4,class=5".parse().unwrap();
        for row in ["0.0,7,3.5,4.5,car", "0.0,1,3.5,4.5,car"] {
            let layout = Layout::detect(row.as_bytes(), &[&said]).unwrap();
            assert_eq!((layout.before, layout.names.len()), (0, 5));
            assert_eq!(layout.names[4], "5");
        }
        let named = Layout::detect(b"1,2,x,y\n0,1,2,3\n", &[&said]).unwrap();
        assert_eq!(named.names[2], "x");
        // As `np.savetxt` writes names.
        for text in ["# of today\n# t id x\n0.0 1 2.5\n", "#t,id,x\n0.0,1,2.5\n"] {
            let layout = Layout::detect(text.as_bytes(), &[]).unwrap();
            assert_eq!(layout.names, ["t", "id", "x"]);
        }
        let xml = b"<?xml version='1.0' encoding='UTF-8'?>\n<commonRoad>\n";
        assert_eq!(Layout::detect(xml, &[]), None);
        assert_eq!(Layout::detect(b"a,b\n", &[]), None);
        let nested = Layout::detect(b"{\"p\":{\"x\":1,\"y\":[2,3]},\"t\":4}\n", &[]).unwrap();
        assert_eq!(nested.names, ["p.x", "p.y.0", "p.y.1", "t"]);
        // Rows may lack values.
        for text in [
            "{\"t\":1}\n{\"t\":2,\"p\":{\"x\":3}}\n{\"id\":4}\n{\"cut",
            "[{\"t\":1},\n{\"t\":2,\"p\":{\"x\":3}}, {\"id\":4}, {\"cut",
        ] {
            let layout = Layout::detect(text.as_bytes(), &[]).unwrap();
            assert_eq!(layout.names, ["t", "p.x", "id"]);
        }
        let names = ["id", "p.x"].map(String::from);
        let later = b"{\"id\":1,\"p\":{\"x\":2}}\n{\"id\":1,\"q\":3}\n";
        let batch = json_rows(1, later, &wanted(), &names).unwrap();
        assert_eq!((batch.unknown, batch.lines.len()), (1, 2));
    }
}

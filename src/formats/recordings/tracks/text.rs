//! Rows of tables in text: separated values and JSON lines, in blocks that are read at once on all cores.

use std::io::Read;

use rayon::prelude::*;
use serde_json::Value;

use super::batch::{Batch, Values, Wanted};
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

/// No line is longer, bytes.
const LONGEST_LINE: usize = 1 << 20;

impl Layout {
    /// The layout of a table that begins with `head`; nothing where that is no table.
    pub fn detect(head: &[u8]) -> Option<Self> {
        let text = String::from_utf8_lossy(head);
        let text = text.trim_start_matches('\u{feff}');
        if text.contains('\0') {
            return None;
        }
        if text.starts_with('{') {
            let first: Value = serde_json::from_str(text.lines().next()?).ok()?;
            let mut names = Vec::new();
            flatten(&first, "", &mut names);
            return Some(Self {
                form: Form::JsonLines,
                names,
                before: 0,
            });
        }
        // Comments and empty lines may stand before the header.
        let mut before = 0;
        let line = text.lines().find(|line| {
            let comment = line.trim().is_empty() || line.starts_with('#') && !line.contains(',');
            before += usize::from(comment);
            !comment
        })?;
        let plain = line.trim_start_matches("# ").trim_start_matches('#');
        let (separator, mut names) = rows::columns_of(plain.as_bytes());
        let mut form = Form::Separated(separator);
        if names.len() == 1 && plain.split_whitespace().count() > 2 {
            form = Form::Spaced;
            names = plain.split_whitespace().map(rows::name).collect();
        }
        if names.len() < 3 {
            return None;
        }
        if names.iter().all(|name| name.parse::<f64>().is_ok()) {
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

    /// Which times and scenarios are where in a table; `wanted` are its clock and, perhaps, the names of scenarios.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn pieces(
        &self,
        source: &mut dyn Read,
        wanted: &[Wanted],
        take: &mut dyn FnMut(Piece, &Batch),
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
                take(piece, &rows);
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
    /// The first cell that is no number where one is wanted, a line that is too long, or what `take` says.
    pub fn read(
        &self,
        source: &mut dyn Read,
        wanted: &[Wanted],
        take: &mut dyn FnMut(Batch) -> Result<(), BadCell>,
    ) -> Result<(), BadCell> {
        let places = self.places(wanted);
        self.blocks(source, &mut |some| {
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
            Form::JsonLines => json_rows(first, block, wanted),
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
            let is_comment = record.get(0).is_some_and(|field| field.starts_with(b"#"));
            if line - first < skipped || is_comment || record.iter().all(<[u8]>::is_empty) {
                continue;
            }
            if let Some(why) = rows::too_long(record.iter(), self.names.len()) {
                return Err(bad("", why));
            }
            if record.len() + 1 < self.names.len() && record.len() < needed(places) {
                let message = format!(
                    "{} values for {} columns; the line is cut off",
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
                let text = text.map_err(|_| bad(&wanted[column].name, "not UTF-8 text".into()))?;
                let done = batch.push(column, text, separator);
                done.map_err(|message| bad(&wanted[column].name, message))?;
            }
            batch.lines.push(u32::try_from(line).unwrap_or(u32::MAX));
        }
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
                        return Err(fail(self.line, format!("cannot be read: {error}")));
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

fn json_rows(first: usize, block: &[u8], wanted: &[Wanted]) -> Result<Batch, BadCell> {
    let mut batch = Batch::new(wanted);
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
        let layout = Layout::detect(text.as_bytes()).unwrap();
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
        let json = "{\"id\":\"a\",\"x\":1.5,\"t\":0}\n{\"x\":\"2.5\",\"id\":\"b\",\"t\":1}\n";
        let lines: Vec<u32> = rows(json).unwrap().iter().map(|row| row.2).collect();
        assert_eq!(lines, [1, 2]);
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
        assert!(error("{\"id\":1,\"x\":2}\n{\"id\"").starts_with("2:: not an object"));
    }

    #[test]
    fn tables_without_a_header_have_numbers_as_names() {
        let layout = Layout::detect(b"1 2.5 3\n4 5 6\n").unwrap();
        assert_eq!((layout.form, layout.before), (Form::Spaced, 0));
        assert_eq!(layout.names, ["1", "2", "3"]);
        assert_eq!(Layout::detect(b"<xml>"), None);
        assert_eq!(Layout::detect(b"a,b\n"), None);
        let nested = Layout::detect(b"{\"p\":{\"x\":1,\"y\":[2,3]},\"t\":4}\n").unwrap();
        assert_eq!(nested.names, ["p.x", "p.y.0", "p.y.1", "t"]);
    }
}

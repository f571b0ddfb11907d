//! Tables with a header, written by people or programs: columns by name, rows with line numbers.

use std::collections::BTreeSet;

use super::{EgoError, assumed};
use crate::commonroad::without_marks;
use nearmiss_scene::scenario::{Diagnostic, Severity};

/// A table that is being read.
pub(super) struct Table<'a> {
    reader: csv::Reader<&'a [u8]>,
    bytes: &'a [u8],
    file: &'a str,
    delimiter: u8,
    header: Vec<String>,
    /// Places of columns that were asked for.
    used: BTreeSet<usize>,
}

/// A row: its fields, trimmed, and where it is.
pub(super) struct Row {
    fields: csv::StringRecord,
    /// Line from 1.
    pub line: u64,
    /// Byte offset of its first character.
    at: usize,
    /// Byte offset behind it.
    end: usize,
}

/// A name as far as it tells columns apart: without case, spaces and punctuation.
pub(super) fn plain(name: &str) -> String {
    let letters = name.chars().filter(|c| c.is_alphanumeric());
    letters.flat_map(char::to_lowercase).collect()
}

/// Enough of a value to recognise it.
pub(super) fn shown(value: &str) -> String {
    value.chars().take(40).collect()
}

/// A finite number.
pub(super) fn finite(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|v: &f64| v.is_finite())
}

impl<'a> Table<'a> {
    /// # Errors
    /// None in practice: reading comes from memory.
    pub fn begin(bytes: &'a [u8], file: &'a str, delimiter: u8) -> Result<Self, EgoError> {
        let bytes = without_marks(bytes);
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(delimiter)
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(bytes);
        let header = reader
            .byte_headers()
            .map_err(|e| io(file, e))?
            .iter()
            .map(String::from_utf8_lossy);
        Ok(Self {
            header: header.map(std::borrow::Cow::into_owned).collect(),
            used: BTreeSet::new(),
            reader,
            bytes,
            delimiter,
            file,
        })
    }

    /// The names of the columns, as written.
    pub fn header(&self) -> &[String] {
        &self.header
    }

    /// The place of a column. One whose name differs in case, spaces and punctuation only is taken for it, with a
    /// diagnostic, if there is no other.
    ///
    /// # Errors
    /// Several columns could be it.
    pub fn column(
        &mut self,
        name: &'static str,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Result<Option<usize>, EgoError> {
        let all = |is: &dyn Fn(&str) -> bool| -> Vec<usize> {
            let places = self.header.iter().enumerate();
            places.filter(|(_, h)| is(h)).map(|(i, _)| i).collect()
        };
        let mut found = all(&|h| h == name);
        if found.is_empty() {
            let name = plain(name);
            found = all(&|h| plain(h) == name);
        }
        match found[..] {
            [] => Ok(None),
            [place] => {
                self.used.insert(place);
                let written = &self.header[place];
                if written != name {
                    let message = format!("column `{}` taken as `{name}`", shown(written));
                    diagnostics.push(assumed(Severity::Note, message));
                }
                Ok(Some(place))
            }
            [first, second, ..] => Err(EgoError::Ambiguous {
                file: self.file.to_string(),
                column: name,
                first: shown(&self.header[first]),
                second: shown(&self.header[second]),
            }),
        }
    }

    /// The columns that were not asked for, of so many rows.
    pub fn unused(&self, rows: usize) -> impl Iterator<Item = Diagnostic> {
        let columns = self.header.iter().enumerate();
        let others = columns.filter(|(place, name)| !name.is_empty() && !self.used.contains(place));
        others.map(move |(_, name)| Diagnostic {
            severity: Severity::Unused,
            line: 1,
            element: format!("column {}", shown(name)),
            message: format!("{rows} ×"),
        })
    }

    /// The next row.
    ///
    /// # Errors
    /// A field is not UTF-8, or the row ends the file in a quote that begins lines before.
    pub fn next(&mut self) -> Result<Option<Row>, EgoError> {
        let mut record = csv::ByteRecord::new();
        let more = self.reader.read_byte_record(&mut record);
        if !more.map_err(|e| io(self.file, e))? {
            return Ok(None);
        }
        let (mut line, mut at) = record
            .position()
            .map_or((0, 0), |p| (p.line(), offset(p.byte())));
        // The reader counts blank lines to the row behind them.
        for byte in self.bytes.iter().skip(at) {
            match byte {
                b'\n' => line += 1,
                b'\r' => {}
                _ => break,
            }
            at += 1;
        }
        let fields = csv::StringRecord::from_byte_record(record).map_err(|error| {
            let column = error.utf8_error().field();
            EgoError::Text {
                file: self.file.to_string(),
                line,
                column: self.name(column),
            }
        })?;
        let row = Row {
            fields,
            line,
            at,
            end: offset(self.reader.position().byte()),
        };
        let text = self.text(&row);
        if is_open(text) && text.trim_ascii_end().contains(&b'\n') {
            return Err(EgoError::Unclosed {
                file: self.file.to_string(),
                line,
            });
        }
        Ok(Some(row))
    }

    /// Whether the file ends within a row: in a quote, with fewer fields than rows have, or before the last field.
    pub fn is_cut_off(&self, row: &Row, fields: usize) -> bool {
        let rest = self.bytes.get(row.end..).unwrap_or_default();
        let text = self.text(row);
        // Rows may end like this if the last column has no name.
        let named = self.header.last().is_some_and(|name| !name.is_empty());
        let before_last = named && text.last() == Some(&self.delimiter);
        rest.trim_ascii().is_empty() && (is_open(text) || row.len() < fields || before_last)
    }

    /// That a row has a field for every column, and no more.
    ///
    /// # Errors
    /// It has fewer or more.
    pub fn check_length(&self, row: &Row) -> Result<(), EgoError> {
        let (found, expected) = (row.fields.len(), self.header.len());
        let (file, line) = (self.file.to_string(), row.line);
        match found.cmp(&expected) {
            std::cmp::Ordering::Equal => Ok(()),
            std::cmp::Ordering::Less => Err(self.short(row, found)),
            std::cmp::Ordering::Greater => Err(EgoError::Long {
                file,
                line,
                found,
                expected,
                value: shown(row.text(expected)),
            }),
        }
    }

    /// That the file ends within a row.
    pub fn cut_off(&self, row: &Row) -> EgoError {
        if row.len() < self.header.len() {
            return self.short(row, row.len());
        }
        EgoError::Unclosed {
            file: self.file.to_string(),
            line: row.line,
        }
    }

    /// That a row ends before the column at `place`.
    pub fn short(&self, row: &Row, place: usize) -> EgoError {
        EgoError::Short {
            file: self.file.to_string(),
            line: row.line,
            found: row.fields.len(),
            expected: self.header.len(),
            column: self.name(place),
        }
    }

    fn name(&self, place: usize) -> String {
        let name = self.header.get(place);
        name.map_or_else(|| format!("number {}", place + 1), |name| shown(name))
    }

    fn text(&self, row: &Row) -> &'a [u8] {
        self.bytes.get(row.at..row.end).unwrap_or_default()
    }
}

impl Row {
    /// The field in a column; empty where the row has none.
    pub fn text(&self, place: usize) -> &str {
        self.fields.get(place).unwrap_or_default()
    }

    /// How many fields it has.
    pub fn len(&self) -> usize {
        self.fields.len()
    }
}

/// Whether a text ends within quotes.
fn is_open(text: &[u8]) -> bool {
    text.iter().filter(|b| **b == b'"').count() % 2 == 1
}

fn offset(byte: u64) -> usize {
    usize::try_from(byte).unwrap_or(usize::MAX)
}

fn io(file: &str, error: csv::Error) -> EgoError {
    EgoError::Io {
        file: file.to_string(),
        source: error.into(),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn rows_have_the_lines_that_an_editor_shows() {
        let bytes = b"a,b\n1,2\n\n\r\n3,4\r\n\"5\n\",6\n7,8";
        let mut table = Table::begin(bytes, "f", b',').unwrap();
        let mut seen = Vec::new();
        while let Some(row) = table.next().unwrap() {
            seen.push((row.line, row.text(1).to_string()));
            assert!(!table.is_cut_off(&row, 2));
        }
        let expected = [(2, "2"), (5, "4"), (6, "6"), (8, "8")];
        assert_eq!(seen, expected.map(|(line, text)| (line, text.to_string())));
    }

    #[test]
    fn columns_are_found_by_any_spelling_of_which_there_is_one() {
        let column = |header: &str| {
            let mut notes = Vec::new();
            let mut table = Table::begin(header.as_bytes(), "f", b',').unwrap();
            let found = table.column("x_position", &mut notes);
            (found.map_err(|e| e.to_string()), notes.len())
        };
        assert_eq!(column("x_position,X Position"), (Ok(Some(0)), 0));
        assert_eq!(column("a, X Position "), (Ok(Some(1)), 1));
        assert_eq!(column("\u{feff}\"xPosition\""), (Ok(Some(0)), 1));
        assert_eq!(column("x_pos"), (Ok(None), 0));
        for twice in ["X Position,XPOSITION", "x_position,a,x_position"] {
            let said = column(twice).0.unwrap_err();
            assert!(said.contains("could both be `x_position`"), "{said}");
        }
    }
}

//! Imports runs from the lines of a file.

use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use super::Counts;
use crate::cli::{Failure, output};
use crate::store::{Run, Store};
use crate::system;

/// Bytes of the longest line that is read; an answer has some ten thousand.
const LONGEST: u64 = 64 << 20;

/// Runs, and bytes of lines, that are added in one transaction.
const BATCH: (usize, usize) = (200, 16 << 20);

/// Lines that are complained about one by one.
const NAMED: usize = 3;

/// Adds the runs of a file that are not in the store yet.
pub fn import(path: &Path, store: &Store, counts: &mut Counts) -> Result<(), Failure> {
    let shown = path.display();
    let wrong = |error: io::Error| Failure::system(shown.to_string(), &error);
    let mut reader = BufReader::new(system::open_file(path).map_err(wrong)?);
    let mut unreadable = 0;
    let mut complain = |number: usize, column: Option<usize>, why: &str| {
        let column = column.map_or_else(String::new, |column| format!(":{column}"));
        unreadable += 1;
        match unreadable {
            n if n <= NAMED => output::say(&format!("nearmiss: {shown}:{number}{column}: {why}")),
            n if n == NAMED + 1 => {
                output::say(&format!(
                    "nearmiss: {shown}: further errors are only counted"
                ));
            }
            _ => {}
        }
    };
    let mut waiting = Waiting::default();
    let mut line = Vec::new();
    for number in 1.. {
        line.clear();
        let read = (&mut reader).take(LONGEST).read_until(b'\n', &mut line);
        if read.map_err(wrong)? == 0 {
            break;
        }
        if line.len() as u64 == LONGEST && line.last() != Some(&b'\n') {
            complain(number, None, "the line is too long for a run");
            reader.skip_until(b'\n').map_err(wrong)?;
            continue;
        }
        let Ok(text) = std::str::from_utf8(&line) else {
            complain(number, None, "not UTF-8");
            continue;
        };
        // Some editors begin a file with byte order marks.
        let text = if number == 1 {
            text.trim_start_matches('\u{feff}')
        } else {
            text
        };
        if text.trim().is_empty() {
            continue;
        }
        match Run::from_record(text.trim_end()) {
            Ok(run) => waiting.take(run, line.len(), store, counts)?,
            Err(error) => complain(number, error.column(), &error.to_string()),
        }
    }
    waiting.add(store, counts)?;
    counts.unreadable += unreadable;
    Ok(())
}

/// Runs that are not added yet.
#[derive(Default)]
struct Waiting {
    runs: Vec<Run>,
    bytes: usize,
}

impl Waiting {
    fn take(
        &mut self,
        run: Run,
        bytes: usize,
        store: &Store,
        counts: &mut Counts,
    ) -> Result<(), Failure> {
        self.runs.push(run);
        self.bytes += bytes;
        if self.runs.len() >= BATCH.0 || self.bytes >= BATCH.1 {
            self.add(store, counts)?;
        }
        Ok(())
    }

    fn add(&mut self, store: &Store, counts: &mut Counts) -> Result<(), Failure> {
        let added = store.add(&self.runs).map_err(Failure::input)?;
        counts.imported += added;
        counts.already_there += self.runs.len() - added;
        self.runs.clear();
        self.bytes = 0;
        Ok(())
    }
}

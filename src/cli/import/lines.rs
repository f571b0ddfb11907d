//! Imports runs and batches from the lines of a file.

use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use super::Counts;
use crate::{Failure, output};
use nearmiss_base::system;
use nearmiss_store::{Record, RecordIntake, Store};

/// Bytes of the longest line that is read; an answer has some ten thousand.
const LONGEST: u64 = 64 << 20;

/// Lines that are complained about one by one.
const NAMED: usize = 3;

/// Adds the runs and batches of a file that are not in the store yet.
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
    let mut intake = RecordIntake::new(store);
    let mut line = Vec::new();
    for number in 1.. {
        line.clear();
        let read = (&mut reader).take(LONGEST).read_until(b'\n', &mut line);
        if read.map_err(wrong)? == 0 {
            break;
        }
        if line.len() as u64 == LONGEST && line.last() != Some(&b'\n') {
            complain(number, None, "the line is longer than any run");
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
        match Record::from_line(text.trim_end()) {
            Ok(record) => intake.take(record, line.len()).map_err(Failure::input)?,
            Err(error) => complain(number, error.column(), &error.to_string()),
        }
    }
    let intake = intake.finish().map_err(Failure::input)?;
    counts.unreadable += unreadable;
    super::merged(path, intake.counts(), counts);
    Ok(())
}

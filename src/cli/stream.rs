//! One table of many scenarios, written while they are worked on.

use std::io;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use nearmiss_formats::Entry;

use super::many_files::{Failed, Job};
use super::output::{self, Encoded, Format, Table, TableWriter, Target};
use super::parts::Measured;
use super::{Failure, Outcome};

/// Where the rows go, and how.
pub struct TableStream<'a> {
    /// The table.
    pub table: &'a Table,
    /// Its format.
    pub format: Format,
    /// The file; `None` for standard output.
    pub file: Option<&'a Path>,
    /// What is done with scenarios: measured.
    pub done: &'static str,
}

/// The table in the making.
struct Writing<'a> {
    stream: &'a TableStream<'a>,
    /// Until the first scenario is done, so that a table of nothing has no header either.
    target: Option<Target>,
    writer: Option<TableWriter>,
    failed: Failed,
}

impl TableStream<'_> {
    /// Works on scenarios in parallel, and writes their rows in order; `end` is called before the table is in its place,
    /// if there is one.
    ///
    /// # Errors
    /// The target cannot be written, or scenarios failed.
    pub fn write(
        &self,
        target: Target,
        entries: &[Entry],
        stop: &AtomicBool,
        rows: impl Fn(&Entry) -> Measured + Sync,
        end: impl FnOnce(),
    ) -> Outcome {
        let mut writing = Writing {
            stream: self,
            target: Some(target),
            writer: None,
            failed: Failed::of(entries.len()),
        };
        let mut written = Ok(());
        let done = Job::new("scenarios", stop)
            .writing_file(self.file.is_some())
            .run(
                entries,
                |entry| {
                    let Measured { said, rows, .. } = rows(entry);
                    Some((said, rows.map(|rows| self.table.encode(self.format, rows))))
                },
                |_, (said, rows)| {
                    said.iter().for_each(|words| output::say(words));
                    written = writing.take(rows);
                    Ok(match &written {
                        Ok(()) => ControlFlow::Continue(()),
                        Err(_) => ControlFlow::Break(()),
                    })
                },
            );
        done.end("no file was written")?;
        let is_empty = writing.failed.all();
        if !is_empty {
            end();
        }
        let done = output::written(self.file, written.and_then(|()| writing.finish()))?;
        // A file without a single scenario in it is not kept.
        if let Some(target) = done.flatten().filter(|_| !is_empty) {
            target.finish()?;
        }
        writing.failed.end(self.done)
    }
}

impl Writing<'_> {
    fn take(&mut self, rows: Result<Encoded, Failure>) -> io::Result<()> {
        let rows = match rows {
            Ok(rows) => rows,
            Err(failure) => {
                self.failed.add(failure);
                return Ok(());
            }
        };
        if let Some(target) = self.target.take() {
            let TableStream { format, table, .. } = self.stream;
            self.writer = Some(TableWriter::begin(target, *format, table)?);
        }
        match &mut self.writer {
            Some(writer) => writer.write(rows),
            None => Ok(()),
        }
    }

    /// Everything written, but not yet in its place.
    fn finish(&mut self) -> io::Result<Option<Target>> {
        self.writer.take().map(TableWriter::finish).transpose()
    }
}

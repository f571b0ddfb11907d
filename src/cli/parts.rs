//! Tables in parts: a folder of Parquet files with one schema, which a run that was killed continues.
//!
//! The layout is `FOLDER/shard=I-of-N/part-00000.parquet`: each machine writes its own folder, and DuckDB, Polars and
//! Spark read all of them as one table. A part has the rows of [`PartsRequest::per_part`] scenarios and is there whole
//! or not at all.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use nearmiss_formats::Entry;
use nearmiss_scene::scenario::ContentHash;
use nearmiss_study::evaluation::batch::Shard;
use nearmiss_workflow::journal::{EarlierRun, Journal, RunSettings, input_hash};
use serde::{Deserialize, Serialize};

use super::many_files::{Done, Failed, Job, ManyFiles, NEXT, open_journal};
use super::output::{self, Format, Row, Table, TableWriter, Target, written};
use super::{Failure, Outcome};

/// Rows that are kept in memory before they are written.
const ROW_GROUP: usize = 16_384;

/// What is written where.
pub struct PartsRequest<'a> {
    /// The command.
    pub command: &'static str,
    /// The folder of -o; it is created.
    pub folder: &'a Path,
    /// The part of the scenarios, and whether a run is continued.
    pub many: ManyFiles,
    /// Start again in a folder with an earlier run.
    pub overwrite: bool,
    /// The table.
    pub table: Table,
    /// Everything that changes the rows, apart from the scenarios.
    pub settings: RunSettings,
    /// Scenarios in a part.
    pub per_part: usize,
    /// The key of the list of notes in the metadata of a part, where scenarios have any.
    pub notes: Option<&'static str>,
}

/// The rows of a scenario.
pub struct Measured {
    /// What is said about it.
    pub said: Vec<String>,
    /// Its rows, or why there are none.
    pub rows: Result<Vec<Row>, Failure>,
    /// What its part has of it beside the rows.
    pub note: Option<serde_json::Value>,
}

/// What was done.
#[derive(Debug)]
pub struct PartsOutcome {
    /// Rows that were measured in this run.
    pub new_rows: u64,
    /// Rows of an earlier run.
    pub kept_rows: u64,
    /// Scenarios without rows.
    pub failed: Failed,
    /// How far it came.
    pub done: Done,
}

/// Whether -o names a folder for parts, not a file.
pub fn is_folder(output: &Path, format: Option<Format>, many: ManyFiles) -> bool {
    let ends_so = output.to_string_lossy().ends_with(std::path::is_separator);
    let is_named_so = output.is_dir() || ends_so || output.extension().is_none();
    let wanted = match format {
        Some(format) => format == Format::Parquet,
        None => many.resume || many.part.shard.is_some() || ends_so,
    };
    wanted && is_named_so && output != Path::new("-")
}

/// Measures scenarios in parallel, and writes their rows in parts.
///
/// # Errors
/// The folder belongs to another run, or a part cannot be written.
pub fn write(
    mut request: PartsRequest<'_>,
    entries: &[Entry],
    stop: &AtomicBool,
    measure: impl Fn(&Entry) -> Measured + Sync,
) -> Result<PartsOutcome, Failure> {
    request.table.group = ROW_GROUP;
    let (mut writer, known) = PartWriter::begin(&request, entries)?;
    let places: Vec<(usize, &Entry)> = entries.iter().enumerate().collect();
    let done = Job::new("scenarios", stop).run(
        &places,
        |(place, entry)| {
            let input = input(entry);
            let same = known.has(*place, &input);
            Some((input, (!same).then(|| measure(entry))))
        },
        |(_, entry), (input, measured)| {
            for words in measured.iter().flat_map(|measured| &measured.said) {
                output::say(words);
            }
            writer.take(entry, input, measured, &measure)?;
            NEXT
        },
    );
    writer.end(done)
}

/// The hash of a scenario's input; of one that cannot be read, that of its place.
fn input(entry: &Entry) -> String {
    let content = entry.content_hash();
    input_hash(
        &entry.display(),
        &content.unwrap_or(ContentHash::digest(b"")),
    )
}

impl PartsOutcome {
    /// How the command ends; `done` says what is done with scenarios: measured.
    pub fn end(self, done: &str) -> Outcome {
        self.done
            .end("finished parts are kept; the same command with --resume continues")?;
        self.failed.end(done)
    }
}

/// The inputs of the parts of an earlier run.
struct KnownInputs {
    per_part: usize,
    /// By part; nothing where it has to be made.
    parts: Vec<Option<Vec<String>>>,
}

impl KnownInputs {
    /// Whether an earlier run has the rows of a scenario with this input, at this place.
    fn has(&self, place: usize, input: &str) -> bool {
        let part = self.parts[place / self.per_part].as_ref();
        part.is_some_and(|inputs| inputs[place % self.per_part] == input)
    }
}

/// What a run that is continued must have had.
#[derive(Serialize)]
struct PartsSettings<'a> {
    #[serde(flatten)]
    settings: &'a RunSettings,
    /// Scenarios in a part.
    per_part: usize,
    /// The hash of the names of the columns.
    columns: String,
}

/// What is noted of a finished part.
#[derive(Default, Serialize, Deserialize)]
struct PartNotes {
    failed: usize,
    rows: u64,
}

/// The part in the making.
#[derive(Default)]
struct Part<'a> {
    inputs: Vec<String>,
    /// Scenarios whose rows are those of an earlier run, as long as none has changed.
    same: Vec<&'a Entry>,
    /// Begun where one has changed.
    table: Option<TableWriter>,
    notes: Vec<serde_json::Value>,
    failed: usize,
    rows: u64,
}

/// Writes parts.
struct PartWriter<'a> {
    request: &'a PartsRequest<'a>,
    journal: Journal,
    scenarios: usize,
    /// Place of the next scenario.
    next: usize,
    part: Part<'a>,
    new_rows: u64,
    kept_rows: u64,
    failed: Failed,
}

impl<'a> PartWriter<'a> {
    /// Opens the folder.
    fn begin(
        request: &'a PartsRequest<'a>,
        entries: &[Entry],
    ) -> Result<(Self, KnownInputs), Failure> {
        let earlier = match (request.many.resume, request.overwrite) {
            (true, false) => EarlierRun::Continue,
            (_, true) => EarlierRun::Replace,
            (false, false) => EarlierRun::Refuse,
        };
        let columns = request
            .table
            .columns
            .iter()
            .map(|column| column.name.as_bytes());
        let settings = PartsSettings {
            settings: &request.settings,
            per_part: request.per_part,
            columns: ContentHash::of_parts(columns).to_string(),
        };
        let journal = open_journal(
            request.folder,
            request.command,
            request.many.part.shard,
            &settings,
            earlier,
        )?;
        let folder = request.folder.join(shard_folder(request));
        fs::create_dir_all(&folder).map_err(|e| Failure::system(folder.display(), &e))?;
        let count = entries.len().div_ceil(request.per_part);
        let inputs = |part: usize| {
            let first = part * request.per_part;
            let length = (entries.len() - first).min(request.per_part);
            let unit = journal.finished(&name(part))?;
            (unit.inputs.len() == length).then(|| unit.inputs.clone())
        };
        let known = KnownInputs {
            per_part: request.per_part,
            parts: (0..count).map(inputs).collect(),
        };
        let writer = Self {
            request,
            journal,
            scenarios: entries.len(),
            next: 0,
            part: Part::default(),
            new_rows: 0,
            kept_rows: 0,
            failed: Failed::of(entries.len()),
        };
        Ok((writer, known))
    }

    /// Takes the next scenario; without rows it is as in the earlier run.
    fn take(
        &mut self,
        entry: &'a Entry,
        input: String,
        measured: Option<Measured>,
        measure: &impl Fn(&Entry) -> Measured,
    ) -> Outcome {
        self.part.inputs.push(input);
        match measured {
            None if self.part.table.is_none() => self.part.same.push(entry),
            None => self.rows(measure(entry))?,
            Some(measured) => {
                if self.part.table.is_none() {
                    let target = Target::begin(Some(&self.path(self.number())), true)?;
                    let table = TableWriter::begin(target, Format::Parquet, &self.request.table);
                    self.part.table = Some(self.written(table)?);
                }
                // One of the part has changed, so the others are written again with it.
                for same in std::mem::take(&mut self.part.same) {
                    self.rows(measure(same))?;
                }
                self.rows(measured)?;
            }
        }
        self.next += 1;
        if self.next.is_multiple_of(self.request.per_part) || self.next == self.scenarios {
            self.finish_part()?;
        }
        Ok(())
    }

    /// What was done; parts of an earlier run that had more scenarios are removed.
    fn end(self, done: Done) -> Result<PartsOutcome, Failure> {
        let done = done.or_failure()?;
        let mut part = self.scenarios.div_ceil(self.request.per_part);
        while !done.interrupted && self.path(part).is_file() {
            let path = self.path(part);
            fs::remove_file(&path).map_err(|e| Failure::system(path.display(), &e))?;
            part += 1;
        }
        Ok(PartsOutcome {
            new_rows: self.new_rows,
            kept_rows: self.kept_rows,
            failed: self.failed,
            done,
        })
    }

    fn rows(&mut self, measured: Measured) -> Outcome {
        self.part.notes.extend(measured.note);
        match measured.rows {
            Err(failure) => {
                self.part.failed += 1;
                self.failed.add(failure);
            }
            Ok(rows) => {
                self.part.rows += rows.len() as u64;
                let rows = self.request.table.encode(Format::Parquet, rows);
                if let Some(table) = &mut self.part.table {
                    let done = table.write(rows);
                    self.written(done)?;
                }
            }
        }
        Ok(())
    }

    fn finish_part(&mut self) -> Outcome {
        let number = (self.next - 1) / self.request.per_part;
        let part = std::mem::take(&mut self.part);
        let Some(mut table) = part.table else {
            let unit = self.journal.finished(&name(number));
            let notes = unit.and_then(|unit| PartNotes::deserialize(&unit.notes).ok());
            let PartNotes { failed, rows } = notes.unwrap_or_default();
            self.failed.count += failed;
            self.kept_rows += rows;
            return Ok(());
        };
        self.new_rows += part.rows;
        if let Some(key) = self.request.notes {
            table.note(key, serde_json::Value::Array(part.notes).to_string());
        }
        let done = table.finish();
        self.written(done)?.finish()?;
        let file = Path::new(&shard_folder(self.request)).join(name(number));
        let notes = serde_json::to_value(PartNotes {
            failed: part.failed,
            rows: part.rows,
        });
        let notes = notes.map_err(Failure::input)?;
        self.journal
            .add(&name(number), part.inputs, &[file], notes)
            .map_err(Failure::input)
    }

    fn number(&self) -> usize {
        self.next / self.request.per_part
    }

    fn path(&self, part: usize) -> PathBuf {
        let folder = self.request.folder.join(shard_folder(self.request));
        folder.join(name(part))
    }

    fn written<T>(&self, done: std::io::Result<T>) -> Result<T, Failure> {
        let path = self.path(self.number());
        written(Some(&path), done)?.ok_or_else(|| Failure::input("a part could not be written"))
    }
}

fn name(part: usize) -> String {
    format!("part-{part:05}.parquet")
}

/// The folder of a shard's parts, named as partitions of Hive are.
fn shard_folder(request: &PartsRequest<'_>) -> String {
    let shard = request.many.part.shard.unwrap_or_else(Shard::full);
    format!("shard={}", shard.file_word())
}

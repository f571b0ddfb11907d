//! A batch as a folder for the Hugging Face Hub: card, questions and answers as Parquet, and `eval.yaml`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use nearmiss_record::{Encoded, Format, Row, Table, columns, row};
use nearmiss_store::{Batch, Store};
use nearmiss_study::evaluation::Provenance;
use nearmiss_study::evaluation::batch::{
    DataSetAnswer, DataSetCard, DataSetFacts, DataSetQuestion, DataSetRow, DataSetRows, Spec,
    TestSplit,
};

use crate::ending::interrupted;
use crate::filters::LockedAnswers;
use crate::output::{self, OutputFile, TableWriter, Target};
use crate::{Failure, Outcome};

/// The card.
const CARD: &str = "README.md";

/// The benchmark.
const BENCHMARK: &str = "eval.yaml";

/// Rows of a row group: messages and answers are long.
const GROUP: usize = 512;

/// The folder in the making: its files are in their places at the end, or none is.
struct Folder<'a> {
    path: &'a Path,
    overwrite: bool,
    /// The folders that were made, outer ones first.
    made: Vec<PathBuf>,
    tables: BTreeMap<String, TableWriter>,
}

/// Writes a batch into a folder.
pub fn run(output: &OutputFile, store: &Store, batch: &Batch, locked: &LockedAnswers) -> Outcome {
    let Some(folder) = output.file() else {
        return Err(Failure::input(format!(
            "--format huggingface writes {CARD}, {BENCHMARK}, data and answers: name a folder with -o FOLDER"
        )));
    };
    let spec = Spec::from_json(&batch.spec).map_err(Failure::input)?;
    locked.say("exports");
    let stop = interrupted(true);
    let mut files = Folder::begin(folder, output.overwrites())?;
    let is_locked = |run| locked.has(run);
    let mut rows = DataSetRows::new(store, batch, &spec, &is_locked);
    while let Some(next) = rows.next_rows().map_err(Failure::input)? {
        if stop.load(Ordering::Relaxed) {
            return Err(Failure::interrupted("no file was written"));
        }
        for (part, row) in next {
            files.add(part, row)?;
        }
    }
    let facts = rows.into_facts();
    for (why, count) in &facts.left_out {
        let questions = output::counted(*count, "question");
        output::say(&format!("nearmiss: left out {questions} {}", why.label()));
    }
    let (questions, answers) =
        { facts.parts.values() }.fold((0, 0), |sum, rows| (sum.0 + rows.0, sum.1 + rows.1));
    if questions == 0 {
        return Err(Failure::finding(format!(
            "{} has no question that a data set can have; nothing was written",
            batch.id
        )));
    }
    let [card, benchmark] = texts(store, batch, &spec.portable(), &facts)?;
    let without_benchmark = benchmark.is_none();
    files.finish(&[(CARD, card), (BENCHMARK, benchmark)])?;
    if without_benchmark {
        output::say(&format!(
            "nearmiss: no {BENCHMARK}: {} without the key of the answer in the messages, so that no pattern finds yes or no",
            output::counted(facts.without_key, "question")
        ));
    }
    output::say(&format!(
        "{} and {} in {}",
        output::counted(questions, "question"),
        output::counted(answers, "answer"),
        folder.display()
    ));
    Ok(())
}

/// The card and the benchmark.
fn texts(
    store: &Store,
    batch: &Batch,
    spec: &Spec,
    facts: &DataSetFacts,
) -> Result<[Option<String>; 2], Failure> {
    let mut items = store.items(batch.id).map_err(Failure::input)?;
    items.retain(|item| facts.places.contains(&item.place));
    let provenance = Provenance::of_batch(store, (batch.id, spec, &items), &facts.runs);
    let test = TestSplit::open(store, batch, false).map_err(Failure::input)?;
    let looks = test.and_then(|test| test.looks_note());
    let part = { batch.shard.iter() }.map(|part| format!("only part {part} of the batch is here"));
    let notes = looks.into_iter().chain(part);
    let card = DataSetCard {
        spec,
        facts,
        provenance: &provenance.map_err(Failure::input)?,
        notes: notes.map(|note| format!("Note: {note}.")).collect(),
    };
    Ok([Some(card.readme()), card.eval_yaml()])
}

impl<'a> Folder<'a> {
    fn begin(path: &'a Path, overwrite: bool) -> Result<Self, Failure> {
        let refused = |why: &str| Err(Failure::input(format!("{}: {why}", path.display())));
        if path.exists() && !path.is_dir() {
            return refused("is a file; --format huggingface writes into a folder");
        }
        if path.exists() && !overwrite {
            let mut entries =
                fs::read_dir(path).map_err(|error| Failure::system(path.display(), &error))?;
            if entries.next().is_some() {
                return refused(
                    "is not empty; name another folder, or replace its files (--overwrite)",
                );
            }
        }
        Ok(Self {
            path,
            overwrite,
            made: Vec::new(),
            tables: BTreeMap::new(),
        })
    }

    /// Adds a row to the table of its part.
    fn add(&mut self, part: &str, row_of: DataSetRow) -> Outcome {
        match row_of {
            DataSetRow::Question(question) => self.write(
                DataSetCard::questions_file(part),
                || Table::new("questions", columns::<DataSetQuestion>()),
                row(&*question).map_err(Failure::input)?,
            ),
            DataSetRow::Answer(answer) => self.write(
                DataSetCard::answers_file(part),
                || Table::new("answers", columns::<DataSetAnswer>()),
                row(&*answer).map_err(Failure::input)?,
            ),
        }
    }

    fn write(&mut self, file: String, table: impl FnOnce() -> Table, row: Row) -> Outcome {
        let path = self.path.join(&file);
        let failed = |error| Failure::system(path.display(), &error);
        if !self.tables.contains_key(&file) {
            self.make_folder(path.parent().unwrap_or(self.path))?;
            let target = Target::begin(Some(&path), self.overwrite)?;
            let mut table = table();
            table.group = GROUP;
            let begun = TableWriter::begin(target, Format::Parquet, &table).map_err(failed)?;
            self.tables.insert(file.clone(), begun);
        }
        match self.tables.get_mut(&file) {
            Some(table) => table.write(Encoded::Rows(vec![row])).map_err(failed),
            None => Ok(()),
        }
    }

    fn make_folder(&mut self, folder: &Path) -> Outcome {
        let missing = folder.ancestors().take_while(|folder| !folder.exists());
        let mut missing: Vec<PathBuf> = missing.map(Path::to_path_buf).collect();
        missing.reverse();
        fs::create_dir_all(folder).map_err(|error| Failure::system(folder.display(), &error))?;
        self.made.extend(missing);
        Ok(())
    }

    /// Puts everything in its place, and removes what an earlier export of more has left.
    fn finish(mut self, texts: &[(&str, Option<String>)]) -> Outcome {
        let mut ready = Vec::new();
        let tables = std::mem::take(&mut self.tables);
        let mut names: Vec<String> = tables.keys().cloned().collect();
        for (name, table) in tables {
            let path = self.path.join(name);
            let whole = table.finish();
            ready.push(whole.map_err(|error| Failure::system(path.display(), &error))?);
        }
        for (name, text) in texts {
            let Some(text) = text else { continue };
            let path = self.path.join(name);
            let mut target = Target::begin(Some(&path), self.overwrite)?;
            let done = std::io::Write::write_all(&mut target, text.as_bytes());
            done.map_err(|error| Failure::system(path.display(), &error))?;
            ready.push(target);
            names.push((*name).to_string());
        }
        let all = DataSetCard::all_files()
            .into_iter()
            .chain([BENCHMARK.into()]);
        for name in all.filter(|name| !names.contains(name)) {
            let path = self.path.join(name);
            match fs::remove_file(&path) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                    return Err(Failure::system(path.display(), &error));
                }
                _ => {}
            }
        }
        for target in ready {
            target.finish()?;
        }
        self.made.clear();
        Ok(())
    }
}

impl Drop for Folder<'_> {
    /// As if nothing had been begun.
    fn drop(&mut self) {
        self.tables.clear();
        for folder in self.made.iter().rev() {
            // Left where something else has been put into it meanwhile.
            let _ = fs::remove_dir(folder);
        }
    }
}

//! `nearmiss runs export`: writes stored runs, and batches with their questions, to a file.

mod chat;
mod hugging_face;

pub use chat::ChatManifest;

use std::collections::BTreeSet;
use std::sync::atomic::Ordering;

use nearmiss_record::{columns, row_of};
use nearmiss_store::{
    Batch, Filter, Item, ItemState, Outcome as StoredAnswer, Run, RunId, RunRecord, Store,
};
use nearmiss_study::evaluation::Provenance;

use super::bundle::{self, BundleOptions};
use super::ending::interrupted;
use super::filters::{Filters, LockedAnswers, Unlock};
use super::output::{
    self, Encoded, ForSpreadsheet, OutputFile, Progress, Table, TableWriter, format_of, written,
};
use super::{Failure, Outcome};

/// Arguments of `runs export`.
#[derive(Debug, clap::Args)]
pub struct Export {
    #[command(flatten)]
    filters: Filters,
    /// Output format [default: from the file name, else json].
    #[arg(long, value_enum)]
    format: Option<Format>,
    #[command(flatten)]
    spreadsheet: ForSpreadsheet,
    #[command(flatten)]
    output: OutputFile,
    #[command(flatten)]
    unlock: Unlock,
    #[command(flatten)]
    chat: chat::ChatOptions,
    #[command(flatten)]
    bundle: BundleOptions,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// JSON lines: one complete run per line, for `nearmiss runs import`. Unfiltered, or with only --batch, also
    /// batches with their questions and truths.
    #[value(alias = "jsonl")]
    Json,
    /// CSV with a header; control characters become symbols.
    Csv,
    /// Apache Parquet.
    Parquet,
    /// Apache Arrow IPC stream.
    Arrow,
    /// Fine-tuning examples: correct answers with checked claims as chats (system, user, assistant). Writes
    /// train.jsonl, validation.jsonl and manifest.json to the folder -o. See `nearmiss help fine-tuning`.
    Chat,
    /// The batch of --batch as a data set for the Hugging Face Hub. Writes the card, questions and answers as Parquet,
    /// and eval.yaml for benchmarks to the folder -o. See `nearmiss help store`.
    #[value(name = "huggingface")]
    HuggingFace,
    /// The batch of --batch (b7, last, or an experiment file that was run) as one file, BATCH.nearmiss. Contains its
    /// answers, truth and templates. See `nearmiss help experiments`.
    Bundle,
}

/// What the endings of names ask for.
const ENDINGS: &[(&str, Format)] = &[
    ("jsonl", Format::Json),
    ("ndjson", Format::Json),
    ("json", Format::Json),
    ("csv", Format::Csv),
    ("parquet", Format::Parquet),
    ("arrow", Format::Arrow),
    ("arrows", Format::Arrow),
    (bundle::ENDING, Format::Bundle),
];

/// Runs `runs export`.
pub fn run(arguments: &Export) -> Outcome {
    let file = arguments.output.file();
    if arguments.format == Some(Format::Chat) {
        arguments.spreadsheet.check(false)?;
        return chats(arguments);
    }
    if let Some(option) = arguments.chat.given() {
        return Err(Failure::input(format!(
            "{option} is an option of --format chat"
        )));
    }
    let known = ".jsonl, .ndjson, .json, .csv, .parquet, .arrow and .nearmiss";
    let format = format_of(arguments.format, file, Format::Json, (ENDINGS, known))?;
    if format == Format::Bundle {
        arguments.spreadsheet.check(false)?;
        let batch = arguments.filters.batch_alone()?;
        return bundle::pack(&batch, &arguments.output, &arguments.bundle);
    }
    if let Some(option) = arguments.bundle.given() {
        return Err(Failure::input(format!(
            "{option} is an option of --format bundle"
        )));
    }
    if format == Format::HuggingFace {
        arguments.spreadsheet.check(false)?;
        return data_set(arguments);
    }
    let format = match format {
        Format::Json => output::Format::Json,
        Format::Csv => output::Format::Csv,
        Format::Arrow => output::Format::Arrow,
        // The others are written above.
        Format::Parquet | Format::Chat | Format::HuggingFace | Format::Bundle => {
            output::Format::Parquet
        }
    };
    output::check_format(format, file)?;
    arguments.spreadsheet.check(format == output::Format::Csv)?;
    let store = arguments.unlock.store()?;
    let filter = arguments.filters.in_store(&store)?;
    let mut numbers = store.numbers(&filter).map_err(Failure::input)?;
    // Tables hold runs alone.
    let batches = match format {
        output::Format::Json => chosen_batches(&store, &filter)?,
        _ => Vec::new(),
    };
    if filter.batch.is_some() {
        add_answers(&store, &batches, &mut numbers)?;
    }
    let locked = arguments.unlock.locked(&store, numbers.iter().copied())?;
    numbers.retain(|run| !locked.has(*run));
    locked.say("exports");
    let superseded = store.superseded().map_err(Failure::input)?;
    // Before the file is begun, so that it never stays behind.
    let stop = interrupted(file.is_some());
    let (target, mut table) = (arguments.output.begin()?, table());
    table.for_spreadsheet = arguments.spreadsheet.is_asked();
    if matches!(format, output::Format::Parquet | output::Format::Arrow) {
        let runs = numbers.iter().copied().collect();
        let provenance = Provenance::of_runs(&store, &runs).map_err(Failure::input)?;
        let provenance = serde_json::to_string(&provenance).map_err(Failure::input)?;
        table.metadata.push(("provenance", provenance));
    }
    let progress = Progress::new(numbers.len(), "runs", file.is_some());
    let Some(mut writer) = written(file, TableWriter::begin(target, format, &table))? else {
        return Ok(());
    };
    for batch in &batches {
        let line = output::json_line(&batch.to_record())?;
        if written(file, writer.write(Encoded::Text(line.into_bytes())))?.is_none() {
            return Ok(());
        }
    }
    let mut shown = BTreeSet::new();
    for number in &numbers {
        if stop.load(Ordering::Relaxed) {
            return Err(Failure::interrupted("no file was written"));
        }
        progress.step();
        let Some(run) = store.run(*number).map_err(Failure::input)? else {
            // It is gone meanwhile.
            continue;
        };
        if format == output::Format::Json {
            for image in images(&store, &run, &mut shown)? {
                if written(file, writer.write(Encoded::Text(image.into_bytes())))?.is_none() {
                    return Ok(());
                }
            }
        }
        let record = run.to_record(superseded.contains(number));
        let row = match format {
            // In JSON, texts that are JSON are no text.
            output::Format::Json => Encoded::Text(output::json_line(&record)?.into_bytes()),
            _ => {
                let row = row_of(&table.columns, &record).map_err(Failure::input)?;
                table.encode(format, vec![row])
            }
        };
        if written(file, writer.write(row))?.is_none() {
            return Ok(());
        }
    }
    drop(progress);
    for batch in &batches {
        for item in store.items(batch.id).map_err(Failure::input)? {
            let item = without_locked(item, &locked);
            let line = output::json_line(&item.to_record(batch.id))?;
            if written(file, writer.write(Encoded::Text(line.into_bytes())))?.is_none() {
                return Ok(());
            }
        }
    }
    if let Some(target) = written(file, writer.finish())? {
        target.finish()?;
    }
    if file.is_some() {
        let batches = match batches.len() {
            0 => String::new(),
            1 => " and 1 batch".into(),
            n => format!(" and {n} batches"),
        };
        output::say(&format!("{} runs{batches} exported", numbers.len()));
    }
    Ok(())
}

/// The table of runs, in row groups of a few hundred, as answers are long.
fn table() -> Table {
    let mut columns = columns::<RunRecord<'_>>();
    columns.retain(|column| column.name != "nearmiss_run");
    let mut table = Table::new("runs", columns);
    table.group = 512;
    table
}

/// The lines of the images of a run that no line before it has.
fn images(store: &Store, run: &Run, shown: &mut BTreeSet<String>) -> Result<Vec<String>, Failure> {
    let mut lines = Vec::new();
    for hash in run.question.image_hashes() {
        if shown.insert(hash.clone()) {
            let image = store.image(&hash).map_err(Failure::input)?;
            let line = image.map(|image| output::json_line(&image.to_record()));
            lines.extend(line.transpose()?);
        }
    }
    Ok(lines)
}

/// Writes examples for fine-tuning.
fn chats(arguments: &Export) -> Outcome {
    let store = arguments.unlock.store()?;
    let filter = arguments.filters.in_store(&store)?;
    let runs = match &filter.batch {
        None => store.outcomes(&filter).map_err(Failure::input)?,
        // With answers that were asked for elsewhere.
        Some(_) => {
            let mut numbers = store.numbers(&filter).map_err(Failure::input)?;
            let batches = chosen_batches(&store, &filter)?;
            add_answers(&store, &batches, &mut numbers)?;
            numbers.sort_unstable();
            let all = store.outcomes(&Filter::default()).map_err(Failure::input)?;
            let chosen = |run: &StoredAnswer| numbers.binary_search(&run.run).is_ok();
            all.into_iter().filter(chosen).collect()
        }
    };
    let numbers = runs.iter().map(|run| run.run);
    let locked = arguments.unlock.locked(&store, numbers)?;
    let place = (arguments.output.file(), arguments.output.overwrites());
    chat::run(&arguments.chat, place, &store, runs, &locked)
}

/// Writes a batch as a data set.
fn data_set(arguments: &Export) -> Outcome {
    let store = arguments.unlock.store()?;
    let filter = arguments.filters.in_store(&store)?;
    let batches = match &filter.batch {
        Some(_) => chosen_batches(&store, &filter)?,
        None => Vec::new(),
    };
    let [batch] = &batches[..] else {
        return Err(Failure::input(
            "a data set holds one whole batch: --batch ID, without other filters",
        ));
    };
    let mut runs = Vec::new();
    add_answers(&store, &batches, &mut runs)?;
    let locked = arguments.unlock.locked(&store, runs)?;
    hugging_face::run(&arguments.output, &store, batch, &locked)
}

/// The batches that are exported with these runs, the oldest first: all without a filter, the one that is chosen where
/// nothing else is. With other filters there are none, as their answers would be missing.
fn chosen_batches(store: &Store, filter: &Filter) -> Result<Vec<Batch>, Failure> {
    let alone = Filter {
        batch: filter.batch.clone(),
        ..Filter::default()
    };
    if *filter != alone {
        return Ok(Vec::new());
    }
    let wanted = |batch: &Batch| match &filter.batch {
        None => true,
        Some(name) => *name == batch.id.to_string(),
    };
    let all = store.batches().map_err(Failure::input)?;
    let batches = all.into_iter().rev().map(|(batch, _)| batch);
    Ok(batches.filter(wanted).collect())
}

/// Adds the answers to questions of these batches that were asked for elsewhere, so that each question has its own.
fn add_answers(store: &Store, batches: &[Batch], numbers: &mut Vec<RunId>) -> Result<(), Failure> {
    for batch in batches {
        let runs = store
            .question_runs(batch.id, 0, None)
            .map_err(Failure::input)?
            .into_values()
            .flatten();
        numbers.extend(runs.map(|run| run.run));
    }
    if !batches.is_empty() {
        numbers.sort_unstable();
        numbers.dedup();
    }
    Ok(())
}

/// A question whose answer is left out is open where it is imported.
fn without_locked(item: Item, locked: &LockedAnswers) -> Item {
    match item.run {
        Some(run) if locked.has(run) => Item {
            run: None,
            state: ItemState::Waiting,
            error: None,
            ..item
        },
        _ => item,
    }
}

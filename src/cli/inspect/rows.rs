//! `nearmiss inspect PATH…` of several: a row for each scenario, the most severe first.

use std::num::NonZeroUsize;

use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_record::{Record, Table, columns, row_of, text_table};
use nearmiss_scene::judge;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_settings::Folders;
use nearmiss_store::Store;
use nearmiss_workflow::{Filter, MissingEgo, OpenRequest, Overview, ScenarioRow, Verdicts, open};
use serde_json::{Value, json};

use super::Inspect;
use crate::ending::interrupted;
use crate::files::{Inputs, Labels};
use crate::many_files::{Failed, Job, NEXT};
use crate::open::{found, not_opened, said_once, stand_in, user_thresholds, without_ego};
use crate::output::{self, PageFormat, Row};
use crate::{Failure, Outcome};

/// What is said while a scenario is read, and its row.
struct Read {
    said: Option<String>,
    overview: Overview,
}

/// Prints a row for each scenario at the paths, or writes them to a file; one that cannot be read is said and counted.
pub fn run(arguments: &Inspect, format: PageFormat) -> Outcome {
    let checked = arguments
        .terms
        .as_deref()
        .map(|text| Overview::filter(text).map_err(|why| Failure::input(format!("--where {why}"))));
    let filter = checked.transpose()?;
    let file = arguments.output.file();
    if let Some(format) = format.of_table() {
        output::check_format(format, file)?;
    }
    let entries = found(&arguments.files)?;
    Inputs::of(&entries).spare(file)?;
    let labels = Labels::new(&entries);
    let thresholds = match Folders::find() {
        Ok(folders) => user_thresholds(&folders)?,
        // Without a home folder there are no thresholds of the user.
        Err(_) => Thresholds::shipped().clone(),
    };
    let verdicts = match &filter {
        Some(filter) if filter.personal().is_some() => answers()?,
        _ => Verdicts::default(),
    };
    let stop = interrupted(file.is_some());
    let mut failed = Failed::of(entries.len());
    let mut kept: Vec<Overview> = Vec::new();
    let done = Job::new("scenarios", &stop).run(
        &entries,
        |entry| Some(read(entry, &thresholds, &verdicts, filter.as_ref())),
        |_, read| {
            match read {
                Ok(read) => {
                    read.said.iter().for_each(|said| output::say(said));
                    let fits = |filter| read.overview.fits(filter);
                    if filter.as_ref().is_none_or(fits) {
                        kept.push(read.overview);
                    }
                }
                Err(failure) => failed.add(failure),
            }
            NEXT
        },
    );
    done.end("")?;
    let read = entries.len() - failed.count;
    kept.sort_by(Overview::compare);
    let fitting = kept.len();
    kept.truncate(arguments.top.map_or(usize::MAX, NonZeroUsize::get));
    if !failed.all() {
        write(arguments, format, kept, &labels)?;
    }
    if filter.is_some() {
        output::say(&format!(
            "nearmiss: {fitting} of {}",
            output::counted(read, "scenario")
        ));
    }
    failed.end("read")
}

/// Stored answers, for terms about them.
fn answers() -> Result<Verdicts, Failure> {
    // Without a store there are no answers.
    let store = { Folders::find().ok() }.and_then(|f| Store::open_to_read(&f.store()).ok());
    let answers = store
        .map(|store| store.verdicts(judge::MODEL, None))
        .transpose()
        .map_err(Failure::input)?;
    Ok(Verdicts::from(answers.unwrap_or_default()))
}

fn read(
    entry: &Entry,
    thresholds: &Thresholds,
    verdicts: &Verdicts,
    filter: Option<&Filter>,
) -> Result<Read, Failure> {
    let request = OpenRequest {
        entry,
        ego: &EgoSelection::Beside,
        transform: None,
        strict: false,
        stand_in: stand_in(),
    };
    let opened = open(&request).map_err(not_opened)?;
    let said = match &opened.scene {
        Ok(scene) if opened.stands_in => said_once(scene),
        Err(why @ MissingEgo::NotDriven(_)) => Some(format!(
            "nearmiss: {}",
            without_ego(entry, &opened.scenario, why).message
        )),
        _ => None,
    };
    Ok(Read {
        said,
        overview: Overview::new(entry, &opened, thresholds, verdicts, filter),
    })
}

fn write(arguments: &Inspect, format: PageFormat, all: Vec<Overview>, labels: &Labels) -> Outcome {
    let (file, overwrites) = (arguments.output.file(), arguments.output.overwrites());
    let columns = columns::<ScenarioRow>();
    let rows = |name: &dyn Fn(&ScenarioRow) -> String| {
        let row = |one: &Overview| {
            let row = ScenarioRow {
                scenario: output::visible(&name(&one.row)),
                file: output::visible(&one.row.file),
                ..one.row.clone()
            };
            row_of(&columns, &row)
        };
        all.iter()
            .map(row)
            .collect::<serde_json::Result<Vec<Row>>>()
    };
    let Some(format) = format.of_table() else {
        let rows = rows(&|row| typed(row, labels)).map_err(Failure::input)?;
        let text = text_table(&columns, &rows);
        return output::Target::begin(file, overwrites)?.save(text.as_bytes());
    };
    if format == output::Format::Json {
        let lines = all.iter().map(|one| {
            let value = serde_json::to_value(&one.row).map_err(Failure::input)?;
            output::json_line(&value)
        });
        let text = lines.collect::<Result<String, Failure>>()?;
        return output::Target::begin(file, overwrites)?.save(text.as_bytes());
    }
    let rows = rows(&|row| row.scenario.clone()).map_err(Failure::input)?;
    let mut table = Table::new(ScenarioRow::NAME, columns.clone());
    let meanings = columns
        .iter()
        .map(|c| json!({ "name": c.name, "unit": c.unit, "source": c.source }));
    table.metadata = vec![
        ("version", env!("CARGO_PKG_VERSION").into()),
        ("columns", meanings.collect::<Value>().to_string()),
    ];
    let target = output::Target::begin(file, overwrites)?;
    output::save_table(&table, format, rows, target, file)
}

/// What can be typed for a scenario: of one in a file its address, as its name alone would not do.
fn typed(row: &ScenarioRow, labels: &Labels) -> String {
    if row.file.contains('#') {
        row.file.clone()
    } else {
        labels.of(&row.scenario, &row.file)
    }
}

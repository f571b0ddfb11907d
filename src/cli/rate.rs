//! `nearmiss corpus rate`: how often the egos of an index meet a manoeuvre, per hour and per kilometre.

use std::path::PathBuf;

use nearmiss_formats::Entry;
use nearmiss_record::{CaptionedTable, Record, Table, columns, rows};
use nearmiss_render::{Palette, Picture, Provenance, RateChart, RatePoint};
use nearmiss_workflow::{
    EventFilter, IndexedEvents, Rate, attack_events, events_that_fit, rates, read_events,
};
use schemars::JsonSchema;
use serde::Serialize;

use super::corpus::save_picture;
use super::{Failure, Outcome, output};

/// Arguments of `corpus rate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "`nearmiss help rates` says what counts, and what a rate does not show.")]
pub struct Rates {
    /// Folder of the index, see `nearmiss corpus index`.
    folder: PathBuf,
    /// Terms that events fit: "manoeuvre:cut_in gap<12 closing>5".
    terms: Vec<String>,
    /// Count what is at least as extreme as what the attackers of this variant do; of another scenario, as what anyone ahead
    /// of its ego does.
    #[arg(long, value_name = "SCENARIO")]
    like: Option<PathBuf>,
    /// List the events.
    #[arg(long, conflicts_with = "output")]
    events: bool,
    /// Form of the output.
    #[arg(long, value_enum, default_value = "table")]
    format: RateFormat,
    /// Also draw the rates: a file .svg or .png.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing file.
    #[arg(long, requires = "output")]
    overwrite: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum RateFormat {
    /// Text for people.
    Table,
    /// CSV with a header.
    Csv,
    /// JSON lines: one object per row.
    #[value(alias = "jsonl")]
    Json,
}

/// Runs `corpus rate`.
pub fn run(arguments: &Rates) -> Outcome {
    let filter = EventFilter::read(&arguments.terms.join(" "));
    let filter =
        filter.map_err(|why| Failure::input(format!("terms: {}", output::visible(&why))))?;
    let index = read_events(&arguments.folder).map_err(Failure::input)?;
    let filters = match &arguments.like {
        None => vec![filter],
        Some(like) => {
            let entry = Entry::of_argument(&super::open::resolved(like)?);
            let found = attack_events(&entry, index.radius).map_err(Failure::input)?;
            let like = found
                .iter()
                .map(|event| EventFilter::like(event).and(&filter));
            like.collect()
        }
    };
    if arguments.like.is_some() {
        let words = filters.iter().map(EventFilter::words);
        words.for_each(|words| output::say(&format!("nearmiss: at least as extreme: {words}")));
    }
    for filter in &filters {
        if let Some(gap) = filter.widest_gap().filter(|gap| *gap > index.radius) {
            output::say(&format!(
                "nearmiss: gap {gap}: the index knows nothing of others farther than {} m away; `nearmiss corpus index --radius {}` does",
                index.radius,
                gap.ceil() + 10.0
            ));
        }
    }
    if arguments.events {
        let found = filters
            .iter()
            .flat_map(|filter| events_that_fit(&index, filter));
        return print("events", &found.collect::<Vec<_>>(), arguments.format);
    }
    let found: Vec<Rate> = filters
        .iter()
        .flat_map(|filter| rates(&index, filter))
        .collect();
    if found.is_empty() {
        return Err(Failure::input(format!(
            "{}: no motor vehicle drives in its scenarios",
            arguments.folder.display()
        )));
    }
    say_what_it_is(&index, &found);
    if let Some(path) = &arguments.output {
        save_picture(&picture(&found), path, arguments.overwrite)?;
    }
    print("rates", &found, arguments.format)
}

/// What makes the rates less than they seem.
fn say_what_it_is(index: &IndexedEvents, found: &[Rate]) {
    let windows = index.scenarios.iter().filter(|one| one.is_window).count();
    if windows > 0 {
        output::say(&format!(
            "nearmiss: {windows} of {} are parts of long recordings, listed for their most severe moments: their rates are too high",
            output::counted(index.scenarios.len(), "scenario")
        ));
    }
    if let Some(few) = found.iter().find(|rate| rate.independent) {
        output::say(&format!(
            "nearmiss: {} of {} egos: intervals take events as independent, and are too narrow if they are not",
            output::counted(few.recordings, "recording"),
            few.ego_source.name()
        ));
    }
}

fn print<R: Record + JsonSchema + Serialize>(
    name: &'static str,
    found: &[R],
    format: RateFormat,
) -> Outcome {
    match format {
        RateFormat::Json => found.iter().try_for_each(output::json),
        RateFormat::Csv => {
            let cells = rows(found).map_err(Failure::input)?;
            let csv = Table::new(name, columns::<R>()).csv(cells);
            output::text(&String::from_utf8_lossy(&csv))
        }
        RateFormat::Table => {
            let table = CaptionedTable::of("", name, found).map_err(Failure::input)?;
            output::text(&table.text())
        }
    }
}

fn picture(found: &[Rate]) -> Picture {
    let row = |rate: &Rate| {
        let what = rate.manoeuvre.map_or("", |kind| kind.name());
        let ends = rate.per_hour.zip(rate.per_hour_ci);
        let point = ends.map(|(rate, interval)| RatePoint {
            rate,
            interval: interval.into(),
        });
        let name = format!("{what}, {} egos", rate.ego_source.name());
        (name, point.into_iter().collect())
    };
    let counts = found.iter().map(|rate| {
        let what = rate.manoeuvre.map_or("", |kind| kind.name());
        let Rate {
            terms,
            events,
            hours,
            ..
        } = rate;
        let ego = rate.ego_source.name();
        format!("{what} {terms}, {ego}: {events} in {hours:.2} h")
    });
    let chart = RateChart {
        axis: "events an hour, with intervals of 95 %".into(),
        rows: found.iter().map(row).collect(),
        palette: Palette::paper(),
        provenance: Provenance {
            title: "nearmiss, rates of events in a corpus".into(),
            description: counts.collect::<Vec<_>>().join("; "),
            facts: vec![(
                "program",
                concat!("nearmiss ", env!("CARGO_PKG_VERSION")).into(),
            )],
        },
    };
    chart.picture()
}

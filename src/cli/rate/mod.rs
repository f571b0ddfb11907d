//! `nearmiss corpus rate`: how often the egos of an index meet a manoeuvre, per hour and per kilometre.

mod like;

use std::path::PathBuf;

use nearmiss_record::{CaptionedTable, Record, Table, columns, rows};
use nearmiss_render::{Palette, Picture, Provenance, RateChart, RatePoint};
use nearmiss_scene::corpus::EventKind;
use nearmiss_workflow::{EventFilter, IndexedEvents, Rate, events_that_fit, rates, read_events};
use schemars::JsonSchema;
use serde::Serialize;

use crate::corpus::save_picture;
use crate::{Failure, Outcome, output};

/// Arguments of `corpus rate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "`nearmiss help rates` explains events, and what a rate does not show.")]
pub struct Rates {
    /// Index folder; see `nearmiss corpus index`.
    folder: PathBuf,
    /// Terms that events must match: "manoeuvre:cut_in gap<12 closing>5".
    terms: Vec<String>,
    /// Count events at least as extreme as those of this scenario, or of each scenario in a folder; repeat for several
    ///
    /// For a variant, its attackers count; for other scenarios, whatever drives ahead of the ego. Also reports which
    /// driver models avoid it.
    #[arg(long, value_name = "SCENARIO|FOLDER")]
    like: Vec<PathBuf>,
    /// List the events.
    #[arg(long, conflicts_with = "output")]
    events: bool,
    /// Output format.
    #[arg(long, value_enum, default_value = "table")]
    format: RateFormat,
    /// Also draw the rates to FILE (.svg or .png); with --like against the number of drivers that avoid each event.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing file.
    #[arg(long, requires = "output")]
    overwrite: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum RateFormat {
    /// Human-readable text.
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
    if !arguments.like.is_empty() {
        return like::run(arguments, &index, &filter);
    }
    say_beyond(&filter, &index);
    if arguments.events {
        let found = events_that_fit(&index, &filter);
        return print("events", &found, arguments.format);
    }
    let found = rates(&index, &filter);
    if found.is_empty() && !EventKind::ALL.into_iter().any(|kind| filter.asks_for(kind)) {
        return Err(Failure::input(
            "terms: no manoeuvre fits all of them; name one, or leave manoeuvre: out",
        ));
    }
    if found.is_empty() {
        return Err(nothing_drives(arguments));
    }
    say_what_it_is(&index, &found);
    if let Some(path) = &arguments.output {
        save_picture(&picture(&found), path, arguments.overwrite)?;
    }
    print("rates", &found, arguments.format)
}

fn nothing_drives(arguments: &Rates) -> Failure {
    Failure::input(format!(
        "{}: no motor vehicle drives in its scenarios",
        arguments.folder.display()
    ))
}

/// That a filter asks for gaps which the index does not look at.
fn say_beyond(filter: &EventFilter, index: &IndexedEvents) {
    if let Some(gap) = filter.widest_gap().filter(|gap| *gap > index.radius) {
        output::say(&format!(
            "nearmiss: gap {gap}: the index knows nothing of others farther than {} m away; `nearmiss corpus index --radius {}` does",
            index.radius,
            gap.ceil() + 10.0
        ));
    }
}

/// What makes the rates less than they seem.
fn say_what_it_is<'r>(index: &IndexedEvents, found: impl IntoIterator<Item = &'r Rate>) {
    if index.copies > 0 {
        output::say(&format!(
            "nearmiss: {} left out: copies of others",
            output::counted(index.copies, "file")
        ));
    }
    let windows = index.scenarios.iter().filter(|one| one.is_window).count();
    if windows > 0 {
        output::say(&format!(
            "nearmiss: {windows} of {} are parts of long recordings, listed for their most severe moments: their rates are too high",
            output::counted(index.scenarios.len(), "scenario")
        ));
    }
    if let Some(few) = found.into_iter().find(|rate| rate.independent) {
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
        let point = point(rate);
        let name = format!("{what}, {} egos", rate.ego_source.name());
        (name, point.into_iter().collect())
    };
    let counts = found.iter().map(count);
    let chart = RateChart {
        axis: "events an hour, with intervals of 95 %".into(),
        rows: found.iter().map(row).collect(),
        palette: Palette::paper(),
        provenance: provenance(counts),
    };
    chart.picture()
}

/// `cut_in gap<12, recorded: 3 in 12.00 h`.
fn count(rate: &Rate) -> String {
    let what = rate.manoeuvre.map_or("", |kind| kind.name());
    let Rate {
        terms,
        events,
        hours,
        ..
    } = rate;
    let ego = rate.ego_source.name();
    format!("{what} {terms}, {ego}: {events} in {hours:.2} h")
}

/// A rate with its interval; nothing where nothing was driven.
fn point(rate: &Rate) -> Option<RatePoint> {
    let ends = rate.per_hour.zip(rate.per_hour_ci);
    ends.map(|(rate, interval)| RatePoint {
        rate,
        interval: interval.into(),
    })
}

/// What stands in the file of a figure, with what each rate is of.
fn provenance(counts: impl Iterator<Item = String>) -> Provenance {
    Provenance {
        title: "nearmiss, rates of events in a corpus".into(),
        description: counts.collect::<Vec<_>>().join("; "),
        facts: vec![(
            "program",
            concat!("nearmiss ", env!("CARGO_PKG_VERSION")).into(),
        )],
    }
}

//! `corpus rate --like`: how often a corpus holds something as extreme as scenarios do, and who would avoid it.

use nearmiss_drive::driver::VerdictRecord;
use nearmiss_render::{JudgedEvent, Palette, Picture, TwoAxesChart};
use nearmiss_scene::corpus::Egos;
use nearmiss_workflow::{
    EventFilter, IndexedEvents, RateLike, ScenarioEvent, events_that_fit, rates_like,
    scenario_events,
};

use super::{Rates, count, nothing_drives, point, print, provenance, say_beyond, say_what_it_is};
use crate::corpus::save_picture;
use crate::ending::interrupted;
use crate::many_files::{Failed, Job, NEXT};
use crate::open::{found, thresholds_in_use};
use crate::{Failure, Outcome, output};

/// An event of a scenario, and the rows about it: one for each kind of ego.
struct Compared {
    event: ScenarioEvent,
    rates: Vec<RateLike>,
}

/// Runs it.
pub fn run(arguments: &Rates, index: &IndexedEvents, filter: &EventFilter) -> Outcome {
    let thresholds = thresholds_in_use()?;
    let entries = found(&arguments.like)?;
    let stop = interrupted(false);
    let mut failed = Failed::of(entries.len());
    let mut compared: Vec<Compared> = Vec::new();
    let done = Job::new("scenarios", &stop)
        .writing_file(arguments.output.is_some())
        .run(
            &entries,
            |entry| Some(scenario_events(entry, index.radius, &thresholds)),
            |entry, events| {
                match events {
                    Ok(events) => compared.extend(events.into_iter().map(|event| Compared {
                        rates: rates_like(index, &entry.name, &event, filter),
                        event,
                    })),
                    Err(why) => failed.add(Failure::input(why)),
                }
                NEXT
            },
        );
    done.end("")?;
    let like = |one: &Compared| EventFilter::like(&one.event.event).and(filter);
    let filters: Vec<EventFilter> = compared.iter().map(like).collect();
    for (one, filter) in compared.iter().zip(&filters) {
        let name = one.rates.first().map_or("", |row| &row.scenario);
        let words = filter.words();
        output::say(&format!("nearmiss: {name}: at least as extreme: {words}"));
        say_beyond(filter, index);
    }
    if failed.all() {
        return failed.end("compared");
    }
    if arguments.events {
        let all = filters
            .iter()
            .flat_map(|filter| events_that_fit(index, filter));
        print("events", &all.collect::<Vec<_>>(), arguments.format)?;
        return failed.end("compared");
    }
    let rows = || compared.iter().flat_map(|one| &one.rates);
    if rows().next().is_none() {
        return Err(nothing_drives(arguments));
    }
    say_what_it_is(index, rows().map(|row| &row.rate));
    if let Some(path) = &arguments.output {
        save_picture(&picture(&compared)?, path, arguments.overwrite)?;
    }
    print(
        "rates",
        &rows().cloned().collect::<Vec<_>>(),
        arguments.format,
    )?;
    failed.end("compared")
}

/// How often, and who avoids it, as two axes; what no driver decides is not in it, and said.
fn picture(compared: &[Compared]) -> Result<Picture, Failure> {
    let event = |one: &Compared| {
        let (_, drivers) = one.event.drivers.as_ref()?;
        let decides = drivers.people().any(VerdictRecord::decides);
        let first = one.rates.first().filter(|_| decides)?;
        let manoeuvre = one.event.event.manoeuvre.name();
        let of = |egos| one.rates.iter().find(|row| row.rate.ego_source == egos);
        Some(JudgedEvent {
            name: format!("{} {manoeuvre}", first.scenario),
            avoided: drivers.avoided,
            decided: drivers.decided,
            rates: Egos::ALL.map(|egos| point(&of(egos)?.rate)).into(),
        })
    };
    let events: Vec<JudgedEvent> = compared.iter().filter_map(event).collect();
    let missing = compared.len() - events.len();
    if events.is_empty() {
        return Err(Failure::input(
            "-o: no model of a person decides any of the events: there is no figure of who avoids them",
        ));
    }
    if missing > 0 {
        output::say(&format!(
            "nearmiss: not in the figure: {} that no model of a person decides",
            output::counted(missing, "event")
        ));
    }
    let counts = compared.iter().flat_map(|one| &one.rates).map(|row| {
        let avoided = match (row.avoided, row.decided) {
            (Some(avoided), Some(decided)) => format!("{avoided} of {decided}"),
            _ => "not judged".into(),
        };
        format!("{} {}, avoided: {avoided}", row.scenario, count(&row.rate))
    });
    let chart = TwoAxesChart {
        axis: "at least as extreme: events an hour, with intervals of 95 %".into(),
        egos: Egos::ALL.map(|egos| format!("{} egos", egos.name())).into(),
        provenance: provenance(counts),
        events,
        palette: Palette::paper(),
    };
    Ok(chart.picture())
}

//! The table of windows: every pair of road users, a row each window.

use std::sync::Arc;

use nearmiss_formats::Entry;
use nearmiss_record::{Cell, Column, Kind, Row, Table};
use nearmiss_scene::corpus::{
    Egos, Exposure, IndexOptions, IndexedWindow, ScenarioDriven, WindowEgo, for_each_window,
};
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::{Measure, SEVERITY_NAMES, Thresholds, measures};
use nearmiss_scene::scenario::{Ego, Scenario};
use serde_json::json;

use super::{integer, meanings, rounded, shown, text};
use crate::INDEX_RADIUS;

/// The measures of a window unless others are named.
pub const INDEX_MEASURES: &str = "distance,risk,ttc,ttc_lane,drac,time_gap,btn,stn,pet,rss_margin";

/// What a window is measured by unless something else is said: 2 s long, one each second, pairs within
/// [`INDEX_RADIUS`], the [`INDEX_MEASURES`].
#[must_use]
pub fn default_index_options() -> IndexOptions {
    IndexOptions {
        length: 2.0,
        stride: 1.0,
        radius: INDEX_RADIUS,
        measures: in_order(&INDEX_MEASURES.split(',').collect::<Vec<_>>()),
    }
}

/// The measures with these ids, each once, in the order of columns.
#[must_use]
pub fn in_order(ids: &[&str]) -> Vec<&'static Measure> {
    measures().filter(|m| ids.contains(&m.id)).collect()
}

/// The columns before those of measures.
fn fixed_columns() -> Vec<Column> {
    vec![
        text("scenario", "the file's name without its ending"),
        text("file", "path as it was found"),
        text("sha256", "hash of the file"),
        text(
            "ego_source",
            "recorded: the ego beside the scenario; obstacle: one of its obstacles",
        ),
        integer("ego_id", "id of the ego"),
        integer("obstacle_id", "id in the scenario"),
        text("obstacle_type", "type in the scenario"),
        integer("first_step", "first step with both"),
        integer("last_step", "last step with both"),
        Column::clock("start", "time of the first step"),
        Column::clock("end", "time of the last step"),
        text("manoeuvre", "what the obstacle does to the ego"),
        text("road", "kind of road under the ego at the last step"),
        integer(
            "severity",
            "severity of the most severe step, 0 (contact) to 5 (none)",
        ),
        text("severity_name", "name of that number"),
        integer("worst_step", "that step"),
    ]
}

/// The table.
#[must_use]
pub fn index_table(options: &IndexOptions, thresholds: &Thresholds) -> Table {
    let measures = options
        .measures
        .iter()
        .map(|m| Column::new(m.id, Kind::Number, m.unit, m.source).optional());
    let mut table = Table::new(
        "windows",
        fixed_columns().into_iter().chain(measures).collect(),
    );
    let changes = json!(thresholds.change_words());
    table.metadata = vec![
        ("version", env!("CARGO_PKG_VERSION").into()),
        ("columns", meanings(&table).to_string()),
        ("severities", SEVERITY_NAMES.join(",")),
        ("window", options.length.to_string()),
        ("stride", options.stride.to_string()),
        ("radius", options.radius.to_string()),
        ("thresholds_changed", changes.to_string()),
    ];
    table
}

/// The windows of a scenario, with each road user in turn as the ego, and the recorded one if there is any; what
/// happened to these egos, and how far they drove.
#[must_use]
pub fn window_rows(
    entry: &Entry,
    scenario: &Arc<Scenario>,
    recorded: Option<Ego>,
    options: &IndexOptions,
    thresholds: &Thresholds,
) -> (Vec<Row>, ScenarioDriven) {
    let recorded_id = recorded.as_ref().map_or(0, |ego| ego.id);
    let mut rows = Vec::new();
    let head: [Cell; 3] = [
        shown(&entry.name),
        shown(&entry.display()),
        scenario.hash.to_string().into(),
    ];
    let mut take = |window: IndexedWindow| {
        rows.push(window_row(&head, scenario, &window, recorded_id));
    };
    let mut driven = for_each_window(scenario, recorded, options, thresholds, &mut take);
    if entry.is_window() {
        // Others are in several windows of the recording.
        driven.obstacles = Exposure::default();
        driven
            .events
            .retain(|event| event.ego_source == Egos::Recorded);
    }
    let events = driven.events.into_iter();
    driven.events = events.map(|event| event.rounded(rounded)).collect();
    let driven = ScenarioDriven {
        scenario: visible(&entry.name).into_owned(),
        file: visible(&entry.display()).into_owned(),
        sha256: scenario.hash.to_string(),
        is_window: entry.is_window(),
        driven,
    };
    (rows, driven)
}

fn window_row(head: &[Cell; 3], scenario: &Scenario, window: &IndexedWindow, recorded: i64) -> Row {
    let (source, ego) = match window.ego {
        WindowEgo::Recorded => ("recorded", recorded),
        WindowEgo::Obstacle(id) => ("obstacle", id),
    };
    let (first, last) = window.steps;
    let time = |step: i64| Cell::finite(rounded(step as f64 * scenario.dt()));
    let known = [
        source.into(),
        Cell::Integer(ego),
        Cell::Integer(window.obstacle),
        window.kind.into(),
        Cell::Integer(first),
        Cell::Integer(last),
        time(first),
        time(last),
        window.manoeuvre.name().into(),
        window.road.name().into(),
        Cell::Integer(window.severity.into()),
        SEVERITY_NAMES[usize::from(window.severity)].into(),
        Cell::Integer(window.worst_step),
    ];
    let values = window
        .values
        .iter()
        .map(|value| value.map_or(Cell::None(""), |v| Cell::finite(rounded(v))));
    head.iter().cloned().chain(known).chain(values).collect()
}

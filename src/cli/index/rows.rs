//! The rows of an index: a window each.

use serde_json::{Value, json};

use crate::Failure;
use crate::metrics::rounded;
use crate::output::{self, Cell, Column, Kind, Row, Table};
use nearmiss_formats::Entry;
use nearmiss_scene::corpus::{IndexOptions, IndexedWindow, WindowEgo, for_each_window};
use nearmiss_scene::metrics::{SEVERITY_NAMES, Thresholds};
use nearmiss_scene::scenario::Scenario;

/// The columns before those of measures.
fn fixed() -> Vec<Column> {
    let text = |name, source| Column::new(name, Kind::Text, "", source);
    let integer = |name, source| Column::new(name, Kind::Integer, "", source);
    let seconds = |name, source| Column::new(name, Kind::Number, "s", source);
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
        seconds("start", "time of the first step"),
        seconds("end", "time of the last step"),
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
pub fn table(options: &IndexOptions, thresholds: &Thresholds) -> Table {
    let measures = options
        .measures
        .iter()
        .map(|m| Column::new(m.id, Kind::Number, m.unit, m.source).optional());
    let mut table = Table::new("windows", fixed().into_iter().chain(measures).collect());
    let columns = table
        .columns
        .iter()
        .map(|c| json!({ "name": c.name, "unit": c.unit, "source": c.source }));
    let changes = json!(thresholds.change_words());
    table.metadata = vec![
        ("version", env!("CARGO_PKG_VERSION").into()),
        ("columns", columns.collect::<Value>().to_string()),
        ("severities", SEVERITY_NAMES.join(",")),
        ("window", options.length.to_string()),
        ("stride", options.stride.to_string()),
        ("radius", options.radius.to_string()),
        ("thresholds_changed", changes.to_string()),
    ];
    table
}

/// The rows of a scenario, and what is doubtful about its ego.
pub fn measure(
    entry: &Entry,
    options: &IndexOptions,
    thresholds: &Thresholds,
) -> (Vec<String>, Result<Vec<Row>, Failure>) {
    let scenario = match entry.read() {
        Ok(scenario) => scenario,
        Err(error) => return (Vec::new(), Err(Failure::input(error))),
    };
    let mut said = Vec::new();
    // The pairs of obstacles are worth measuring without it.
    let recorded = entry.recorded_ego(&scenario).unwrap_or_else(|error| {
        said.push(format!("nearmiss: {error}; indexed without this ego"));
        None
    });
    let recorded_id = recorded.as_ref().map_or(0, |ego| ego.id);
    let mut rows = Vec::new();
    let head: [Cell; 3] = [
        output::visible(&entry.name).into(),
        output::visible(&entry.display()).into(),
        scenario.hash.to_string().into(),
    ];
    let mut take = |window: IndexedWindow| {
        rows.push(row(&head, &scenario, &window, recorded_id));
    };
    for_each_window(&scenario, recorded, options, thresholds, &mut take);
    (said, Ok(rows))
}

fn row(head: &[Cell; 3], scenario: &Scenario, window: &IndexedWindow, recorded: i64) -> Row {
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

/// How many pairs the rows are of; those of a pair stand together.
pub fn pairs(rows: &[Row]) -> u64 {
    let pair = |row: &Row| (row[3].clone(), row[4].clone(), row[5].clone());
    let mut last = None;
    let mut count = 0;
    for row in rows {
        let this = Some(pair(row));
        count += u64::from(this != last);
        last = this;
    }
    count
}

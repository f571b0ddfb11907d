//! The table of the exact convention: every measure, between real bodies.

use crate::files::RowFile;
use crate::output::{Cell, Column, Kind, Row};
use nearmiss_scene::metrics::{Context, Reading, Thresholds, measures};
use nearmiss_scene::scenario::Scene;

/// Columns of every row behind those of the file: the time.
pub const WHEN: [Column; 2] = [
    Column::new("step", Kind::Integer, "", "time step of the scenario"),
    Column::new("time", Kind::Number, "s", "time since time step 0"),
];

const WHO: [Column; 2] = [
    Column::new("obstacle", Kind::Integer, "", "id in the scenario"),
    Column::new(
        "relative_direction",
        Kind::Text,
        "",
        "where the obstacle is, seen from the ego's body",
    ),
];

pub fn columns() -> Vec<Column> {
    let measures = measures().map(|m| Column::new(m.id, Kind::Number, m.unit, m.source).optional());
    let head = RowFile::COLUMNS.into_iter().chain(WHEN);
    head.chain(WHO).chain(measures).collect()
}

/// Every measure of every obstacle whose centre is within `radius` metres of the ego's, at every step of the ego.
pub fn rows(
    file: &RowFile,
    scene: &Scene,
    radius: Option<f64>,
    thresholds: &Thresholds,
) -> Vec<Row> {
    let mut rows = Vec::new();
    let context = Context::under(scene, thresholds);
    for step in context.steps() {
        for (place, participant) in context.participants().iter().enumerate() {
            let Some(encounter) = context.encounter(place, step) else {
                continue;
            };
            let apart = encounter.other.pose.position - encounter.ego.pose.position;
            if radius.is_some_and(|radius| apart.x.hypot(apart.y) > radius) {
                continue;
            }
            let who = [
                Cell::Integer(participant.obstacle.id),
                encounter.relation().direction.name().into(),
            ];
            let measures = measures().map(|m| cell(m.evaluate(&encounter)));
            let head = file.cells().into_iter().chain(when(scene, step)).chain(who);
            rows.push(head.chain(measures).collect());
        }
    }
    rows
}

/// The cells of the columns [`WHEN`].
pub fn when(scene: &Scene, step: i64) -> [Cell; 2] {
    [
        Cell::Integer(step),
        Cell::finite(rounded(scene.time_of(step))),
    ]
}

/// A measure's reading as a cell.
pub fn cell(reading: Reading) -> Cell {
    match reading {
        Reading::Value(value) => Cell::finite(rounded(value)),
        Reading::None(why) => Cell::None(why.reason()),
    }
}

/// Micrometres and microseconds are beyond what the files carry.
pub fn rounded(value: f64) -> f64 {
    let millionths = value * 1e6;
    if millionths.is_finite() {
        millionths.round() / 1e6 + 0.0
    } else {
        value
    }
}

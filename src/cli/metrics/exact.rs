//! The table of the exact convention: every measure, between real bodies.

use super::table::{Cell, Column, Form, Kind, Sheet, Values};
use crate::metrics::{Context, MEASURES, Reading, Thresholds};
use crate::scenario::Scene;

/// Leading columns of every row: scenario and time.
pub const WHEN: [Column; 3] = [
    Column {
        name: "scenario",
        kind: Kind::Text,
        unit: "",
        source: "the file's name without its ending",
    },
    Column {
        name: "timestep",
        kind: Kind::Integer,
        unit: "",
        source: "time step of the scenario",
    },
    Column {
        name: "time",
        kind: Kind::Number {
            form: Form::Shortest,
            lacking: false,
        },
        unit: "s",
        source: "time since time step 0",
    },
];

const WHO: [Column; 2] = [
    Column {
        name: "obstacle_id",
        kind: Kind::Integer,
        unit: "",
        source: "id in the scenario",
    },
    Column {
        name: "relative_direction",
        kind: Kind::Text,
        unit: "",
        source: "where the obstacle is, seen from the ego's body",
    },
];

pub fn columns() -> Vec<Column> {
    let measures = MEASURES.iter().map(|measure| Column {
        name: measure.id,
        kind: Kind::Number {
            form: Form::Shortest,
            lacking: true,
        },
        unit: measure.unit,
        source: measure.source,
    });
    WHEN.into_iter().chain(WHO).chain(measures).collect()
}

/// Every measure of every obstacle whose centre is within `radius` metres of the ego's, at every step of the ego.
pub fn sheet(name: String, scene: &Scene, radius: Option<f64>, thresholds: &Thresholds) -> Sheet {
    let (mut steps, mut times, mut ids, mut directions) = (vec![], vec![], vec![], vec![]);
    let mut measures: Vec<Vec<Cell>> = vec![Vec::new(); MEASURES.len()];
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
            steps.push(step);
            times.push(Cell::finite(rounded(scene.time_of(step))));
            ids.push(participant.obstacle.id);
            directions.push(encounter.relation().direction.name());
            for (measure, cells) in MEASURES.iter().zip(&mut measures) {
                cells.push(cell((measure.compute)(&encounter)));
            }
        }
    }
    let head = [
        Values::Same(name),
        Values::Integer(steps),
        Values::Number(times),
        Values::Integer(ids),
        Values::Text(directions),
    ];
    let rows = measures.first().map_or(0, Vec::len);
    let values = head
        .into_iter()
        .chain(measures.into_iter().map(Values::Number));
    Sheet {
        rows,
        values: values.collect(),
    }
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

//! The table of whole scenes: the ego against all obstacles together, one row a step.

use super::exact::{WHEN, cell, rounded};
use super::table::{Cell, Column, Form, Kind, Sheet, Values};
use crate::metrics::{Context, SCENE_MEASURES, Thresholds};
use crate::scenario::Scene;

pub fn columns() -> Vec<Column> {
    let measures = SCENE_MEASURES.iter().map(|measure| Column {
        name: measure.id,
        kind: Kind::Number {
            form: Form::Shortest,
            lacking: true,
        },
        unit: measure.unit,
        source: measure.source,
    });
    WHEN.into_iter().chain(measures).collect()
}

/// Every measure of the scene at every step at which the ego is recorded.
pub fn sheet(name: String, scene: &Scene, thresholds: &Thresholds) -> Sheet {
    let context = Context::under(scene, thresholds);
    let recorded = |step: &i64| scene.ego.track.at(*step).is_some();
    let steps: Vec<i64> = context.steps().filter(recorded).collect();
    let times = steps.iter().map(|&step| rounded(scene.time_of(step)));
    let head = [
        Values::Same(name),
        Values::Integer(steps.clone()),
        Values::Number(times.map(Cell::finite).collect()),
    ];
    let measures = SCENE_MEASURES.iter().map(|measure| {
        let cells = steps
            .iter()
            .map(|&step| cell((measure.compute)(&context, step)));
        Values::Number(cells.collect())
    });
    Sheet {
        rows: steps.len(),
        values: head.into_iter().chain(measures).collect(),
    }
}

//! The table of whole scenes: the ego against all obstacles together, one row a step.

use super::exact::{WHEN, cell, when};
use crate::files::RowFile;
use crate::output::{Column, Kind, Row};
use nearmiss_scene::metrics::{Context, SCENE_MEASURES, Thresholds};
use nearmiss_scene::scenario::Scene;

pub fn columns() -> Vec<Column> {
    let measures = SCENE_MEASURES
        .iter()
        .map(|m| Column::new(m.id, Kind::Number, m.unit, m.source).optional());
    let head = RowFile::COLUMNS.into_iter().chain(WHEN);
    head.chain(measures).collect()
}

/// Every measure of the scene at every step at which the ego is recorded.
pub fn rows(file: &RowFile, scene: &Scene, thresholds: &Thresholds) -> Vec<Row> {
    let context = Context::under(scene, thresholds);
    let steps = context.steps();
    let recorded = steps.filter(|step| scene.ego.track.at(*step).is_some());
    let row = |step| {
        let measures = SCENE_MEASURES
            .iter()
            .map(|m| cell((m.compute)(&context, step)));
        let head = file.cells().into_iter().chain(when(scene, step));
        head.chain(measures).collect()
    };
    recorded.map(row).collect()
}

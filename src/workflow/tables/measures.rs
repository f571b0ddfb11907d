//! The tables of measures: every obstacle at every step, and the ego against all together.

use nearmiss_record::{Cell, Column, Kind, Row, Table};
use nearmiss_scene::metrics::{Context, Measure, SCENE_MEASURES, Thresholds, own_formulas};
use nearmiss_scene::scenario::Scene;
use nearmiss_study::evaluation::Provenance;
use nearmiss_study::evaluation::batch::Spec;
use serde_json::{Value, json};

use super::{RowFile, WHEN, integer, meanings, reading, text, when};

/// The columns of [`exact_rows`] with these measures.
#[must_use]
pub fn exact_columns(measures: &[&'static Measure]) -> Vec<Column> {
    let who = [
        integer("obstacle", "id in the scenario"),
        text(
            "relative_direction",
            "where the obstacle is, seen from the ego's body",
        ),
    ];
    let head = RowFile::COLUMNS.into_iter().chain(WHEN);
    head.chain(who)
        .chain(measures.iter().map(|m| column_of(m.id, m.unit, m.source)))
        .collect()
}

/// These measures of every obstacle whose centre is within `radius` metres of the ego's, at every step of the ego.
#[must_use]
pub fn exact_rows(
    file: &RowFile,
    context: &Context<'_>,
    radius: Option<f64>,
    measures: &[&'static Measure],
) -> Vec<Row> {
    let mut rows = Vec::new();
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
            let measures = measures.iter().map(|m| reading(m.evaluate(&encounter)));
            let head = file.cells().into_iter().chain(when(context.scene(), step));
            rows.push(head.chain(who).chain(measures).collect());
        }
    }
    rows
}

/// The columns of [`scene_rows`].
#[must_use]
pub fn scene_columns() -> Vec<Column> {
    let head = RowFile::COLUMNS.into_iter().chain(WHEN);
    let measures = SCENE_MEASURES.iter();
    head.chain(measures.map(|m| column_of(m.id, m.unit, m.source)))
        .collect()
}

fn column_of(id: &'static str, unit: &'static str, source: &'static str) -> Column {
    Column::new(id, Kind::Number, unit, source).optional()
}

/// Every measure of the scene at every step at which the ego is recorded.
#[must_use]
pub fn scene_rows(file: &RowFile, scene: &Scene, thresholds: &Thresholds) -> Vec<Row> {
    let context = Context::under(scene, thresholds);
    let steps = context.steps();
    let recorded = steps.filter(|step| scene.ego.track.at(*step).is_some());
    let row = |step| {
        let measures = SCENE_MEASURES
            .iter()
            .map(|m| reading((m.compute)(&context, step)));
        let head = file.cells().into_iter().chain(when(scene, step));
        head.chain(measures).collect()
    };
    recorded.map(row).collect()
}

/// A table of measures with the meaning of its columns, by a convention; the thresholds where they count, and whether the
/// user's own measures are among the columns.
#[must_use]
pub fn measure_table(
    columns: Vec<Column>,
    convention: &str,
    thresholds: Option<&Thresholds>,
    has_own: bool,
) -> Table {
    let mut table = Table::new("measures", columns);
    table.metadata = vec![
        ("version", env!("CARGO_PKG_VERSION").into()),
        ("convention", convention.into()),
        ("columns", meanings(&table).to_string()),
    ];
    if let Some(thresholds) = thresholds {
        let changes = Value::from(thresholds.change_words());
        table
            .metadata
            .push(("thresholds_changed", changes.to_string()));
    }
    let provenance = provenance(thresholds);
    let whole = serde_json::to_string(&provenance).unwrap_or_default();
    table.metadata.push(("provenance", whole));
    table
        .json_values
        .push(("provenance", in_a_line(&provenance, has_own)));
    table
}

/// This program, and the thresholds where they count.
#[must_use]
pub fn provenance(thresholds: Option<&Thresholds>) -> Provenance {
    let mut provenance = Provenance::of_program();
    if let Some(thresholds) = thresholds {
        provenance.set_thresholds(Spec::threshold_changes(thresholds));
    }
    provenance
}

/// What each line of JSON says of its provenance: what is known of a measure, and nothing of answers.
fn in_a_line(provenance: &Provenance, has_own: bool) -> Value {
    let mut said = json!({
        "program": provenance.program,
        "commit": provenance.commit,
        "thresholds": provenance.thresholds,
        "thresholds_sha256": provenance.thresholds_sha256,
    });
    let own = own_formulas();
    if has_own && !own.is_empty() {
        said["own_measures"] = own.into();
    }
    said
}

//! The tables of scenes: their columns and rows, the same for commands and Python.

mod encounters;
mod family;
mod lanes;
mod measures;
mod windows;

pub use encounters::{
    Encounter, encounter_rows, encounter_table, encounters, left_out, too_coarse,
};
pub use family::{EncounterCases, FamilyResults, Vary};
pub use lanes::lane_table;
pub use measures::{
    exact_columns, exact_rows, measure_table, provenance, scene_columns, scene_rows,
};
pub use windows::{INDEX_MEASURES, default_index_options, in_order, index_table, window_rows};

use nearmiss_formats::Entry;
use nearmiss_record::{Cell, Column, Kind, Table};
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::Reading;
use nearmiss_scene::scenario::{ContentHash, Scene};
use serde_json::{Value, json};

/// Digits of a hash that tell files apart, as elsewhere.
const DIGITS: usize = 12;

/// The beginning of a file's hash, as tables have it.
#[must_use]
pub fn short_hash(hash: &ContentHash) -> String {
    hash.to_string().chars().take(DIGITS).collect()
}

/// The scenario, its file and its ego, for the rows about it.
#[derive(Debug, Clone)]
pub struct RowFile([Cell; 4]);

impl RowFile {
    /// The columns.
    pub const COLUMNS: [Column; 4] = [
        text("scenario", "the file's name without its ending"),
        text("file", "path as it was found"),
        text(
            "hash",
            "first 12 digits of the SHA-256 of the scenario's content",
        ),
        text("ego", "where the ego's motion is from"),
    ];

    /// That of a scene.
    #[must_use]
    pub fn new(entry: &Entry, scene: &Scene) -> Self {
        Self([
            shown(&entry.name),
            shown(&entry.display()),
            short_hash(&scene.scenario.hash).into(),
            shown(&scene.ego.source.short()),
        ])
    }

    /// The cells under [`Self::COLUMNS`].
    #[must_use]
    pub fn cells(&self) -> [Cell; 4] {
        self.0.clone()
    }
}

/// Columns of a moment.
const WHEN: [Column; 2] = [
    integer("step", "time step of the scenario"),
    Column::clock("time", "time since time step 0"),
];

/// The cells of the columns [`WHEN`].
fn when(scene: &Scene, step: i64) -> [Cell; 2] {
    [
        Cell::Integer(step),
        Cell::finite(rounded(scene.time_of(step))),
    ]
}

const fn text(name: &'static str, source: &'static str) -> Column {
    Column::new(name, Kind::Text, "", source)
}

const fn integer(name: &'static str, source: &'static str) -> Column {
    Column::new(name, Kind::Integer, "", source)
}

/// Text from outside, as no terminal obeys it.
fn shown(text: &str) -> Cell {
    visible(text).into_owned().into()
}

/// A measure's reading as a cell.
fn reading(reading: Reading) -> Cell {
    match reading {
        Reading::Value(value) => Cell::finite(rounded(value)),
        Reading::None(why) => Cell::None(why.reason()),
    }
}

/// Micrometres and microseconds are beyond what the files carry.
#[must_use]
pub fn rounded(value: f64) -> f64 {
    let millionths = value * 1e6;
    if millionths.is_finite() {
        millionths.round() / 1e6 + 0.0
    } else {
        value
    }
}

/// What the metadata of a table says of its columns.
#[must_use]
pub fn meanings(table: &Table) -> Value {
    let columns = table.columns.iter();
    columns
        .map(|c| json!({ "name": c.name, "unit": c.unit, "source": c.source }))
        .collect()
}

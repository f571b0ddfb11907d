//! The compact form: a header line with units, then one row a step and participant.

use std::borrow::Cow;

use super::parts::{lanelet_ids, name, subject};
use super::writer::{Subject, Writer};
use crate::scenario::{Motion, Participant, Scene};

/// A column: its title with the unit, and what its numbers are.
pub(super) struct Column {
    pub title: Cow<'static, str>,
    pub quantity: &'static str,
}

/// A column.
pub(super) const fn column(title: &'static str, quantity: &'static str) -> Column {
    Column {
        title: Cow::Borrowed(title),
        quantity,
    }
}

/// Contents of a table cell.
pub(super) enum Cell {
    Nothing,
    Real(f64),
    Angle(f64),
    /// Degrees.
    Degrees(f64),
    Whole(i64),
    /// The time of a step, with the seconds of a step.
    Time(i64, f64),
    Words(&'static str),
    /// The lanelets under a participant.
    Lanelets(Vec<i64>),
}

impl Cell {
    /// A number, or nothing.
    pub fn number(value: Option<f64>) -> Self {
        value.map_or(Self::Nothing, Self::Real)
    }

    /// Words, or nothing.
    pub fn words(words: Option<&'static str>) -> Self {
        words.map_or(Self::Nothing, Self::Words)
    }

    /// The lanelets under a participant.
    pub fn lanelets(scene: &Scene, motion: &Motion) -> Self {
        Self::Lanelets(scene.scenario.network.lanelets_at(&motion.pose.position))
    }
}

/// The line of titles of rows that begin with [`begin`].
pub(super) fn titles(w: &mut Writer, columns: &[&[Column]]) {
    let first = if w.is_relative() {
        "t [s],who"
    } else {
        "step,t [s],who"
    };
    titles_after(w, first, columns);
}

/// The line of titles with these `first`.
pub(super) fn titles_after(w: &mut Writer, first: &str, columns: &[&[Column]]) {
    w.words(first);
    for column in columns.iter().copied().flatten() {
        w.words(",").words(&column.title);
    }
    w.words("\n");
}

/// Begins a row: when and who.
pub(super) fn begin(w: &mut Writer, scene: &Scene, step: i64, who: Option<&Participant<'_>>) {
    w.about(Subject::Scene, Some(step));
    if !w.is_relative() {
        w.whole("step", step).words(",");
    }
    w.time(step, scene.scenario.dt())
        .words(",")
        .about(who.map_or(Subject::Ego, subject), Some(step));
    match who {
        Some(who) => name(w, who),
        None => {
            w.words("ego");
        }
    }
}

/// Cells of a row under `columns`; those that are missing at the end have no value.
pub(super) fn cells(w: &mut Writer, columns: &[Column], cells: &[Cell]) {
    for (place, column) in columns.iter().enumerate() {
        w.words(",");
        match cells.get(place).unwrap_or(&Cell::Nothing) {
            Cell::Nothing => w.words("-"),
            Cell::Real(value) => w.number(column.quantity, *value),
            Cell::Angle(value) => w.angle(column.quantity, *value),
            Cell::Degrees(value) => w.degrees(column.quantity, *value),
            Cell::Time(step, dt) => w.time(*step, *dt),
            Cell::Whole(value) => w.whole(column.quantity, *value),
            Cell::Words(words) => w.words(words),
            Cell::Lanelets(ids) if ids.is_empty() => w.words("-"),
            Cell::Lanelets(ids) => lanelet_ids(w, ids, "+"),
        };
    }
}

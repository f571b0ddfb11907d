//! Scenarios as tables of tracks for other programs: our own columns, and the shapes of INTERACTION and highD.

mod highd;
mod interaction;
#[cfg(test)]
mod tests;
mod tracks;

use std::collections::HashSet;

use nearmiss_base::geometry::Point;
use nearmiss_record::{Format, Row, Table};
use nearmiss_scene::scenario::{Ego, Motion, ObstacleType, Scenario};

use super::openscenario::{Actor, ExportedEgo, Notes, actors};

pub use tracks::COLUMNS as OWN_COLUMNS;

/// What tables look like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TableShape {
    /// A row a road user and step, in the columns that `nearmiss help tracks` tells.
    Tracks(Format),
    /// A table of the INTERACTION Dataset, with everyone in it.
    Interaction,
    /// The three tables of a recording of highD.
    HighD,
}

/// A scenario as tables.
#[derive(Debug, Default)]
pub struct WrittenTables {
    /// Ends of the files' names, behind that of the recording, and their bytes.
    pub files: Vec<(&'static str, Vec<u8>)>,
    /// What the shape cannot say, one sentence each.
    pub notes: Vec<String>,
}

/// Why a scenario is not written.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// No road user is in it.
    #[error("no road user has a body and a place: there is no row to write")]
    Empty,
    /// A road user drives across the road of highD.
    #[error(
        "highD is of straight roads, and {name} drives {degrees:.0}° across its road; --format interaction or tracks has a place for it"
    )]
    Across {
        /// Who.
        name: String,
        /// How far off the road, degrees.
        degrees: f64,
    },
    /// Writing goes to memory.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

/// Writes a scenario and its ego as tables. The same scenario gives the same bytes.
///
/// # Errors
/// No road user is in it, or its traffic is none of this shape.
pub fn write_tables(
    shape: TableShape,
    scenario: &Scenario,
    ego: Option<&Ego>,
) -> Result<WrittenTables, TableError> {
    let mut notes = Notes::default();
    let recording = Recording::of(scenario, ego, &mut notes);
    if recording.users.is_empty() {
        return Err(TableError::Empty);
    }
    let mut written = match shape {
        TableShape::Tracks(format) => tracks::write(&recording, format)?,
        TableShape::Interaction => interaction::write(&recording),
        TableShape::HighD => highd::write(recording, &scenario.network)?,
    };
    written.notes.extend(notes.sentences());
    if ego.is_none() {
        written
            .notes
            .push("no ego: none is recorded beside it; --ego ID or --ego planner adds one".into());
    }
    let roads = &scenario.network;
    if !roads.lanelets.is_empty() && shape != TableShape::HighD {
        written.notes.push(
            "the road is left out: a table has tracks only; --map FILE adds it where the table is read".into(),
        );
    }
    Ok(written)
}

/// A scenario and its ego as our own table of tracks: a row a road user and step.
#[must_use]
pub fn track_table(scenario: &Scenario, ego: Option<&Ego>) -> (Table, Vec<Row>) {
    tracks::rows(&Recording::of(scenario, ego, &mut Notes::default()))
}

/// A road user's rows.
struct User {
    id: i64,
    kind: ObstacleType,
    is_ego: bool,
    /// Metres.
    length: f64,
    /// Metres.
    width: f64,
    /// By step; places are the middle of the body.
    states: Vec<(i64, Motion)>,
}

/// Everyone in a scenario.
struct Recording {
    users: Vec<User>,
    /// The first step and the last one.
    steps: (i64, i64),
    /// Seconds.
    time_step: f64,
}

impl Recording {
    fn of(scenario: &Scenario, ego: Option<&Ego>, notes: &mut Notes) -> Self {
        let exported = ego.map_or(ExportedEgo::Missing, ExportedEgo::Follows);
        Self::new(scenario, &actors(scenario, exported, notes), ego)
    }

    fn new(scenario: &Scenario, actors: &[Actor], ego: Option<&Ego>) -> Self {
        let moving = actors.iter().filter(|actor| !actor.stands);
        let all = moving.flat_map(|actor| actor.stretches.iter().flatten());
        let seen = all.map(|(step, _)| (*step, *step));
        // Where all stand, two steps tell that.
        let span = seen.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let steps = span.unwrap_or((0, 1));
        let mut taken: HashSet<i64> = actors.iter().filter_map(|a| a.name.parse().ok()).collect();
        let users = actors.iter().map(|actor| {
            let id = actor.name.parse().ok();
            let states = actor.stretches.iter().flatten();
            let states: Vec<(i64, Motion)> = match states.clone().next() {
                Some((_, motion)) if actor.stands => {
                    (steps.0..=steps.1).map(|step| (step, *motion)).collect()
                }
                _ => states.copied().collect(),
            };
            let states = states.into_iter();
            User {
                id: id.unwrap_or_else(|| free(ego.map_or(1, |ego| ego.id), &mut taken)),
                kind: actor.kind,
                is_ego: id.is_none(),
                length: actor.body.length,
                width: actor.body.width,
                states: states
                    .map(|(step, motion)| (step, in_middle(motion, actor.body.center)))
                    .collect(),
            }
        });
        Self {
            users: users.collect(),
            steps,
            time_step: scenario.dt(),
        }
    }

    /// Seconds since step 0.
    fn time(&self, step: i64) -> f64 {
        // Of a tenth of a second there is no sum of parts.
        (step as f64 * self.time_step * 1e9).round() / 1e9
    }

    /// How the ego is found in a shape that has no column for it.
    fn ego_in_words(&self) -> Option<String> {
        let ego = self.users.iter().find(|user| user.is_ego)?;
        Some(format!(
            "this shape does not tell the ego: it is track {0}, `FILE#track={0}` opens with it",
            ego.id
        ))
    }
}

/// An id of the ego that no obstacle has.
fn free(wanted: i64, taken: &mut HashSet<i64>) -> i64 {
    let mut id = wanted.max(1);
    while !taken.insert(id) {
        id += 1;
    }
    id
}

/// A motion of the middle of a body whose middle lies at `center` of it.
fn in_middle(mut motion: Motion, center: Point) -> Motion {
    let (sin, cos) = motion.pose.heading.sin_cos();
    motion.pose.position.x += center.x * cos - center.y * sin;
    motion.pose.position.y += center.x * sin + center.y * cos;
    motion
}

/// A number as short as it reads back the same.
fn number(value: f64) -> String {
    // Zero has no sign.
    (value + 0.0).to_string()
}

//! Rows of an Argoverse 2 scenario, put together to tracks.

use std::collections::HashMap;

use super::table::{Table, Text};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::assembly::{RecordedTrack, TrackState, along};
use crate::recordings::report::Report;
use crate::recordings::{repeated, sizes};
use nearmiss_scene::scenario::ObstacleType;
use nearmiss_scene::scenario::plausibility::limits::LATEST_STEP;

/// The track of the vehicle that records.
const RECORDER: &str = "AV";

/// The rows of a file.
pub struct Rows {
    /// The id of the scenario.
    pub scenario: String,
    /// The track whose future is to be forecast.
    pub focal: String,
    /// In the order in which they first appear.
    pub tracks: Vec<NamedTrack>,
}

/// A track under its name in the file.
pub struct NamedTrack {
    pub name: String,
    kind: ObstacleType,
    states: Vec<TrackState>,
}

impl NamedTrack {
    /// Whether it is that of the vehicle that records.
    pub fn is_recorder(&self) -> bool {
        self.name == RECORDER
    }

    /// The track under an id of the scenario.
    pub fn recorded(self, id: i64, recorder: (f64, f64)) -> RecordedTrack {
        let (length, width) = if self.is_recorder() {
            recorder
        } else {
            sizes::usual(self.kind)
        };
        RecordedTrack {
            shape: None,
            is_static: false,
            id,
            kind: self.kind,
            length,
            width,
            states: self.states,
        }
    }
}

/// Reads all rows.
pub fn read(report: &Report, table: &Table<'_>) -> Result<Rows, ReadError> {
    let names = table.needed_texts("track_id")?;
    let kinds = table.needed_texts("object_type")?;
    let steps = table.needed_numbers("timestep")?;
    let (x, y) = (
        table.needed_numbers("position_x")?,
        table.needed_numbers("position_y")?,
    );
    let headings = table.needed_numbers("heading")?;
    let velocities = (table.numbers("velocity_x")?, table.numbers("velocity_y")?);
    let first = |name| Ok::<_, ReadError>(table.first_text(name)?.unwrap_or_default());
    let (scenario, focal) = (first("scenario_id")?, first("focal_track_id")?);
    let mut places: HashMap<&str, usize> = HashMap::new();
    let mut tracks: Vec<NamedTrack> = Vec::new();
    let mut last: Option<(&Text, usize)> = None;
    for (row, name) in names.iter().enumerate() {
        // Rows are counted from 1 in messages, as other tables do.
        let at = || report.at(format!("row {}", row + 1));
        let step = steps[row];
        if step.fract() != 0.0 || step.abs() > LATEST_STEP as f64 {
            return Err(at().fail(format!("`timestep` is {step}")));
        }
        let plain = |value: f64| {
            if value.abs() < 1e6 {
                Ok(value)
            } else {
                at().number(value)
            }
        };
        let heading = plain(headings[row])?;
        let velocity = match &velocities {
            (Some(x), Some(y)) => Some(along(heading, plain(x[row])?, plain(y[row])?)),
            _ => None,
        };
        let (x, y) = (plain(x[row])?, plain(y[row])?);
        let place = match last.filter(|(before, _)| before.is_same(name)) {
            Some((_, place)) => place,
            None => *places.entry(name.as_str()).or_insert_with(|| {
                tracks.push(NamedTrack {
                    name: name.as_str().to_string(),
                    kind: kind(kinds[row].as_str()),
                    states: Vec::new(),
                });
                tracks.len() - 1
            }),
        };
        last = Some((name, place));
        tracks[place].states.push(TrackState {
            step: step as i64,
            position: at_point(x, y, at)?,
            heading,
            velocity,
            acceleration: None,
        });
    }
    for track in &mut tracks {
        let name = || format!("track {}", track.name);
        repeated::once(report, name, &mut track.states, |s| s.step, |s| s.position);
    }
    Ok(Rows {
        scenario,
        focal,
        tracks,
    })
}

fn at_point<'r>(
    x: f64,
    y: f64,
    at: impl Fn() -> crate::recordings::report::At<'r>,
) -> Result<nearmiss_base::geometry::Point, ReadError> {
    if x.abs() < 1e6 && y.abs() < 1e6 {
        Ok(nearmiss_base::geometry::Point::new(x, y))
    } else {
        at().point(x, y)
    }
}

/// The kind of a class.
fn kind(class: &str) -> ObstacleType {
    match class {
        "vehicle" => ObstacleType::Car,
        "bus" => ObstacleType::Bus,
        "pedestrian" => ObstacleType::Pedestrian,
        "motorcyclist" => ObstacleType::Motorcycle,
        "cyclist" | "riderless_bicycle" => ObstacleType::Bicycle,
        "construction" => ObstacleType::ConstructionZone,
        _ => ObstacleType::Unknown,
    }
}

//! Road users of a Waymo scenario.

use super::Recorded;
use super::messages::{ObjectState, Track};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::assembly::{
    Ids, RecordedTrack, TRUCK_LENGTH, TrackState, median, signed_speed,
};
use crate::recordings::report::{At, Report};
use nearmiss_scene::scenario::ObstacleType;

/// Sizes that vary by more than this over a track are noted, metres.
const VARIES: f64 = 0.05;

/// The ids of tracks as they are in the scenario, in the order of the file.
pub fn read(
    report: &Report,
    recorded: &Recorded,
    ids: &mut Ids,
) -> Result<Vec<RecordedTrack>, ReadError> {
    let mut varying = Vec::new();
    let mut long = 0;
    let mut tracks = Vec::with_capacity(recorded.tracks.len());
    for (place, track) in recorded.tracks.iter().enumerate() {
        let name = || format!("tracks[{place}]");
        let Some(id) = track.id.filter(|id| *id > 0).map(i64::from) else {
            report.at(name()).warn("no id; left out");
            continue;
        };
        let (track, spread) = self::track(report, recorded, track, id, &name)?;
        if !ids.take(id) {
            report
                .at(name())
                .warn(format!("track {id} is there twice; the first is used"));
            continue;
        }
        long += usize::from(track.kind == ObstacleType::Truck);
        if spread > VARIES {
            varying.push((id, spread));
        }
        tracks.push(track);
    }
    let most = varying.iter().max_by(|a, b| a.1.total_cmp(&b.1)).copied();
    if let Some((id, spread)) = most {
        report.note(format!(
            "lengths or widths of {} tracks vary over time, most by {spread:.2} m (track {id}); the median of each is used",
            varying.len()
        ));
    }
    report.note_count(long, |n| {
        format!(
            "vehicles longer than {TRUCK_LENGTH} m are taken as trucks, as the data set does not tell: {n}"
        )
    });
    Ok(tracks)
}

/// The id of the track that recorded the scenario.
pub fn ego(report: &Report, recorded: &Recorded) -> Option<i64> {
    let at = || report.at("sdc_track_index");
    let Some(place) = recorded.sdc_track_index else {
        at().warn("missing; no ego");
        return None;
    };
    let track = usize::try_from(place)
        .ok()
        .and_then(|i| recorded.tracks.get(i));
    if track.is_none() {
        at().warn(format!(
            "{place}, but there are {} tracks; no ego",
            recorded.tracks.len()
        ));
    }
    track?.id.map(i64::from)
}

/// A track, and by how much its size varies, metres.
fn track(
    report: &Report,
    recorded: &Recorded,
    track: &Track,
    id: i64,
    name: &impl Fn() -> String,
) -> Result<(RecordedTrack, f64), ReadError> {
    let steps = recorded.timestamps_seconds.len();
    if track.states.len() != steps {
        let message = format!("{} states for {steps} time stamps", track.states.len());
        report.at(name()).warn(message);
    }
    let mut states = Vec::new();
    let (mut lengths, mut widths) = (Vec::new(), Vec::new());
    for (step, said) in track.states.iter().take(steps).enumerate() {
        if said.valid != Some(true) {
            continue;
        }
        let at = LazyPlace { report, name, step };
        states.push(state(&at, said)?);
        lengths.push(at.number(f64::from(said.length.unwrap_or(0.0)))?);
        widths.push(at.number(f64::from(said.width.unwrap_or(0.0)))?);
    }
    let spread = |values: &[f64]| {
        let most = values.iter().copied().fold(f64::MIN, f64::max);
        let least = values.iter().copied().fold(f64::MAX, f64::min);
        if values.is_empty() { 0.0 } else { most - least }
    };
    let varies = spread(&lengths).max(spread(&widths));
    let length = median(lengths);
    let kind = match track.object_type {
        Some(1) if length > TRUCK_LENGTH => ObstacleType::Truck,
        Some(1) => ObstacleType::Car,
        Some(2) => ObstacleType::Pedestrian,
        Some(3) => ObstacleType::Bicycle,
        _ => ObstacleType::Unknown,
    };
    let track = RecordedTrack {
        shape: None,
        is_static: false,
        id,
        kind,
        length,
        width: median(widths),
        states,
    };
    Ok((track, varies))
}

/// A state's place, spelled out only in messages.
struct LazyPlace<'a, N: Fn() -> String> {
    report: &'a Report,
    name: &'a N,
    step: usize,
}

impl<N: Fn() -> String> LazyPlace<'_, N> {
    fn at(&self) -> At<'_> {
        self.report
            .at(format!("{}/states[{}]", (self.name)(), self.step))
    }

    fn number(&self, value: f64) -> Result<f64, ReadError> {
        // Spelling the place out for each of many numbers would take longest of all.
        if value.abs() < 1e6 {
            return Ok(value);
        }
        self.at().number(value)
    }
}

fn state(
    at: &LazyPlace<'_, impl Fn() -> String>,
    said: &ObjectState,
) -> Result<TrackState, ReadError> {
    let (Some(x), Some(y)) = (said.center_x, said.center_y) else {
        return Err(at
            .at()
            .fail("a valid state without `center_x` and `center_y`"));
    };
    let (x, y) = (at.number(x)?, at.number(y)?);
    let heading = at.number(f64::from(said.heading.unwrap_or(0.0)))?;
    let velocity = match (said.velocity_x, said.velocity_y) {
        (Some(x), Some(y)) => {
            let (x, y) = (at.number(f64::from(x))?, at.number(f64::from(y))?);
            Some(signed_speed(heading, x, y))
        }
        _ => None,
    };
    Ok(TrackState {
        step: i64::try_from(at.step).unwrap_or(i64::MAX),
        position: at.at_point(x, y)?,
        heading,
        velocity,
        acceleration: None,
    })
}

impl<N: Fn() -> String> LazyPlace<'_, N> {
    fn at_point(&self, x: f64, y: f64) -> Result<nearmiss_base::geometry::Point, ReadError> {
        if x.abs() < 1e6 && y.abs() < 1e6 {
            return Ok(nearmiss_base::geometry::Point::new(x, y));
        }
        self.at().point(x, y)
    }
}

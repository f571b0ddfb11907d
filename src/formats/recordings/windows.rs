//! Windows around one track of a long recording: how they are named and cut.
//!
//! Which of them are worth looking at is measured by those who list them: this module knows no measures.

use std::collections::HashMap;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use super::Report;
use crate::commonroad::ReadError;
use nearmiss_scene::scenario::Scenario;

/// Length of a window, seconds.
pub const LENGTH: f64 = 10.0;

/// So much of a window lies after its worst moment, seconds.
const AFTER: f64 = 3.0;

/// Recordings up to this long are one scenario, seconds.
pub const MAX_WHOLE_SECONDS: f64 = 30.0;

/// Windows of a recording that are listed.
const MAX_LISTED: usize = 50;

/// A track shorter than this is no ego, seconds.
const MIN_EGO_SECONDS: f64 = 2.0;

/// Moments a second of a [`LongRecording`].
pub const MOMENTS: f64 = 5.0;

/// Which part of a recording: a track, and when its window begins; without a time, as long as the track is there.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowRequest {
    /// The track's name in the recording.
    pub track: String,
    /// Seconds.
    pub start: Option<f64>,
}

impl WindowRequest {
    /// Reads `track=NAME` or `track=NAME@34.0s`.
    ///
    /// # Errors
    /// It is something else.
    pub fn parse(part: &str, report: &Report) -> Result<Self, ReadError> {
        let wrong = || {
            report.fail(format!(
                "`{part}` is no window; name one as `track=12@34.0s`, or a whole track as `track=12`"
            ))
        };
        let rest = part.strip_prefix("track=").ok_or_else(wrong)?;
        // Names of tracks may have an `@`, times have none.
        let timed = rest.rsplit_once('@').and_then(|(track, time)| {
            let seconds: f64 = time.strip_suffix('s').unwrap_or(time).parse().ok()?;
            (seconds.is_finite() && seconds.abs() < 1e7).then_some((track, Some(seconds)))
        });
        let (track, start) = timed.unwrap_or((rest, None));
        if track.is_empty() {
            return Err(wrong());
        }
        Ok(Self {
            track: track.to_string(),
            start,
        })
    }
}

/// A recording of minutes: everyone in it, a few moments a second and without lanes, and how stretches of it are named.
#[derive(Debug)]
pub struct LongRecording {
    /// Its tracks. None of them is the ego.
    pub scenario: Arc<Scenario>,
    /// What the recording calls its tracks.
    names: HashMap<i64, String>,
    /// When the first step is, seconds.
    start: f64,
    /// The steps of the vehicle that recorded, where windows are around it alone.
    recorder: Option<Range<i64>>,
}

impl LongRecording {
    /// A recording that begins at `start` seconds; `names` is what it calls its tracks.
    pub fn new(scenario: Scenario, names: HashMap<i64, String>, start: f64) -> Self {
        Self {
            scenario: Arc::new(scenario),
            names,
            start,
            recorder: None,
        }
    }

    /// The same of a recording that a vehicle made, which sees all around itself and little of others. `steps` are its; the
    /// scenario has it in stretches, each a track with a name, and the others have none.
    pub fn of_recorder(
        scenario: Scenario,
        stretches: HashMap<i64, String>,
        start: f64,
        steps: Range<i64>,
    ) -> Self {
        Self {
            recorder: Some(steps),
            ..Self::new(scenario, stretches, start)
        }
    }

    /// The tracks that windows are around.
    #[must_use]
    pub fn egos(&self) -> Vec<i64> {
        let mut egos = self.scenario.possible_egos();
        egos.retain(|id| self.recorder.is_none() || self.names.contains_key(id));
        egos
    }

    /// The name of a track, and when ten seconds around it begin in which a step, its worst, is not far from the end;
    /// nothing of a track that is not there or is hardly there.
    fn beginning(&self, track: i64, worst: i64) -> Option<(&str, f64)> {
        let name = self.names.get(&track)?;
        let steps = match &self.recorder {
            Some(steps) => steps.clone(),
            None => self.scenario.obstacle(track)?.track().steps(),
        };
        let (from, to) = (self.seconds(steps.start), self.seconds(steps.end - 1));
        if to - from < MIN_EGO_SECONDS {
            return None;
        }
        let start = (self.seconds(worst) + AFTER - LENGTH).clamp(from, (to - LENGTH).max(from));
        Some((name, start))
    }

    fn seconds(&self, step: i64) -> f64 {
        self.start + step as f64 * self.scenario.dt()
    }

    /// The addresses around the worst moments of tracks, in their order; of those of the same name, a moment that is in a
    /// window before it has none of its own.
    #[must_use]
    pub fn windows(&self, moments: impl IntoIterator<Item = (i64, i64)>) -> Vec<String> {
        let mut taken: HashMap<&str, Vec<f64>> = HashMap::new();
        let mut windows = Vec::new();
        for (track, worst) in moments {
            let Some((name, start)) = self.beginning(track, worst) else {
                continue;
            };
            let at = self.seconds(worst);
            let before = taken.entry(name).or_default();
            if before
                .iter()
                .any(|start| (*start..=start + LENGTH).contains(&at))
            {
                continue;
            }
            before.push(start);
            windows.push(format!("track={name}@{start:.1}s"));
            if windows.len() == MAX_LISTED {
                break;
            }
        }
        windows
    }

    /// The beginnings of its tracks, in their order, which says nothing about what happens in them.
    #[must_use]
    pub fn beginnings(&self) -> Vec<String> {
        let tracks = self.scenario.obstacles.iter();
        self.windows(tracks.map(|track| (track.id, track.track().steps().start)))
    }
}

/// An error about a recording that is opened as a whole.
pub fn too_long(report: &Report, file: &Path, track: &str, start: f64) -> ReadError {
    let file = file.display();
    report.fail(format!(
        "longer than {MAX_WHOLE_SECONDS} s; name ten seconds around a track, such as {file}#track={track}@{start:.1}s (`nearmiss inspect` of its folder lists those worth looking at)"
    ))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn of_a_recorder_each_moment_is_in_one_window() {
        let scenario = crate::bundled()[0].read().unwrap();
        let ids: Vec<i64> = scenario.possible_egos();
        let dt = scenario.dt();
        let names = ids.iter().map(|id| (*id, "ego".to_string())).collect();
        let scenario = Arc::try_unwrap(scenario).unwrap();
        let steps = 0..(60.0 / dt) as i64 + 1;
        let recording = LongRecording::of_recorder(scenario, names, 5.0, steps);
        assert_eq!(recording.egos(), ids);
        let at = |seconds: f64| (ids[0], ((seconds - 5.0) / dt).round() as i64);
        // Seconds of the recording, the most dangerous first.
        let windows = recording.windows([30.0, 31.0, 22.0, 6.0, 64.0].map(at));
        let starts = ["23.0", "15.0", "5.0", "55.0"];
        assert_eq!(windows, starts.map(|start| format!("track=ego@{start}s")));
        let none = (i64::MAX, 0);
        assert!(recording.windows([none]).is_empty());
    }

    #[test]
    fn a_window_is_a_track_and_perhaps_a_time() {
        let report = Report::about("x.csv");
        let parse = |part: &str| {
            let wanted = WindowRequest::parse(part, &report).ok()?;
            Some((wanted.track, wanted.start))
        };
        assert_eq!(parse("track=12"), Some(("12".into(), None)));
        assert_eq!(parse("track=12@34.0s"), Some(("12".into(), Some(34.0))));
        assert_eq!(parse("track=a@b"), Some(("a@b".into(), None)));
        assert_eq!(parse("track=@1s"), None);
        assert_eq!(parse("12"), None);
        let error = WindowRequest::parse("12", &report).unwrap_err().to_string();
        assert!(error.contains("track=12@34.0s"), "{error}");
    }
}

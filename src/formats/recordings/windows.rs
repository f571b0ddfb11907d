//! Windows around one track of a long recording: how they are named and cut.
//!
//! Which of them are worth looking at is measured by those who list them: this module knows no measures.

use std::cmp::Ordering;
use std::collections::HashMap;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use super::Report;
use crate::commonroad::ReadError;
use crate::dispatch::Address;
use nearmiss_scene::scenario::{Obstacle, Scenario};

/// Length of a window, seconds.
pub const LENGTH: f64 = 10.0;

/// So much of a window lies after its worst moment, seconds.
const AFTER: f64 = 3.0;

/// Recordings up to this long are one scenario, seconds.
pub const MAX_WHOLE_SECONDS: f64 = 30.0;

/// No window begins later, seconds: of the year 5138, in Unix time.
const LATEST: f64 = 1e11;

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
    /// The one that an address names, as [`Self::parse`]; nothing where it names a whole recording.
    ///
    /// # Errors
    /// See [`Self::parse`].
    pub fn of(address: &Address, report: &Report) -> Result<Option<Self>, ReadError> {
        let part = address.part.as_ref();
        part.map(|part| Self::parse(part, report)).transpose()
    }

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
            (seconds.is_finite() && seconds.abs() < LATEST).then_some((track, Some(seconds)))
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

    /// The beginnings of its tracks, in their order, which says nothing about what happens in them.
    #[must_use]
    pub fn beginnings(&self) -> Vec<RankedMoment> {
        let tracks = self.scenario.obstacles.iter();
        let moment = |track: &Obstacle| RankedMoment {
            track: track.id,
            step: track.track().steps().start,
            rank: (0, 0.0),
        };
        tracks.map(moment).collect()
    }
}

/// A moment of a track that a window may be around.
#[derive(Debug, Clone, Copy)]
pub struct RankedMoment {
    /// The track.
    pub track: i64,
    /// The step.
    pub step: i64,
    /// The less, the earlier its window is listed; those alike stay in their order.
    pub rank: (u8, f64),
}

/// The windows of a recording that are listed, of all of its stretches.
#[derive(Debug, Default)]
pub struct WindowList(Vec<Candidate>);

#[derive(Debug)]
struct Candidate {
    rank: (u8, f64),
    track: String,
    /// When the window begins, and when its moment is, seconds.
    start: f64,
    at: f64,
}

impl WindowList {
    /// Adds the windows around moments of a stretch.
    pub fn add(&mut self, stretch: &LongRecording, moments: &[RankedMoment]) {
        for moment in moments {
            if let Some((name, start)) = stretch.beginning(moment.track, moment.step) {
                self.0.push(Candidate {
                    rank: moment.rank,
                    track: name.to_string(),
                    start,
                    at: stretch.seconds(moment.step),
                });
            }
        }
        self.reduce();
    }

    /// Leaves those that are listed: of a track, a moment that is in a window before it has none of its own.
    fn reduce(&mut self) {
        let by_rank = |a: &Candidate, b: &Candidate| -> Ordering {
            (a.rank.0.cmp(&b.rank.0)).then(a.rank.1.total_cmp(&b.rank.1))
        };
        self.0.sort_by(by_rank);
        let mut taken: HashMap<String, Vec<f64>> = HashMap::new();
        self.0.retain(|one| {
            let before = taken.entry(one.track.clone()).or_default();
            let mut before_it = before.iter();
            let is_new = !before_it.any(|start| (*start..=start + LENGTH).contains(&one.at));
            before.extend(is_new.then_some(one.start));
            is_new
        });
        self.0.truncate(MAX_LISTED);
    }

    /// Their addresses in the file.
    #[must_use]
    pub fn addresses(&self) -> Vec<String> {
        let address = |one: &Candidate| format!("track={}@{:.1}s", one.track, one.start);
        self.0.iter().map(address).collect()
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
        let at = |seconds: f64| RankedMoment {
            track: ids[0],
            step: ((seconds - 5.0) / dt).round() as i64,
            rank: (0, 0.0),
        };
        // Seconds of the recording, the most dangerous first.
        let mut windows = WindowList::default();
        windows.add(&recording, &[30.0, 31.0, 22.0, 6.0, 64.0].map(at));
        let expected = ["23.0", "15.0", "5.0", "55.0"].map(|start| format!("track=ego@{start}s"));
        assert_eq!(windows.addresses(), expected);
        // Of a second stretch, what is worse comes first, and what is there already does not come twice.
        let worse = |seconds| RankedMoment {
            rank: (0, -1.0),
            ..at(seconds)
        };
        windows.add(&recording, &[worse(31.0), worse(44.0)]);
        assert_eq!(
            windows.addresses()[..2],
            ["track=ego@24.0s", "track=ego@37.0s"]
        );
        let none = RankedMoment {
            track: i64::MAX,
            ..at(6.0)
        };
        let mut empty = WindowList::default();
        empty.add(&recording, &[none]);
        assert!(empty.addresses().is_empty());
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

//! A scenario of a table: all of it, one of several, or a window around a track.

use std::collections::HashMap;
use std::path::Path;

use nearmiss_scene::scenario::{ContentHash, Scenario};

use super::table::Track;
use super::{MapOfTable, Table};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::Report;
use crate::recordings::assembly::{About, Ids, Map, RecordedTrack, TrackState, assemble};
use crate::recordings::maps::{self, Around};
use crate::recordings::opendrive;
use crate::recordings::windows::{self, LongRecording, WindowRequest};

/// So many tracks are named in a message.
const MAX_LISTED: usize = 5;

/// Numbers of tracks that are told.
const MAX_NUMBERS: usize = 12;

impl Table {
    /// The tracks of a scenario of the table, with their places in it.
    pub(super) fn tracks(&self, scenario: &str) -> impl Iterator<Item = (usize, &Track)> {
        let all = self.recorded.tracks.iter().enumerate();
        all.filter(move |(_, track)| track.scenario == scenario)
    }

    /// The steps of a scenario.
    fn span(&self, scenario: &str) -> (i64, i64) {
        let spans = self.tracks(scenario).map(|(_, track)| track.span());
        spans
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
            .unwrap_or_default()
    }

    /// Whether a scenario is listed as windows.
    pub fn is_long(&self, scenario: &str) -> bool {
        let (first, last) = self.span(scenario);
        (last - first) as f64 * self.recorded.time_step > windows::MAX_WHOLE_SECONDS
    }

    fn recorded_track(
        &self,
        place: usize,
        track: &Track,
        states: Vec<TrackState>,
    ) -> RecordedTrack {
        RecordedTrack {
            id: self.ids.get(&place).copied().unwrap_or_default(),
            kind: track.kind,
            length: track.size.0,
            width: track.size.1,
            shape: None,
            is_static: false,
            states,
        }
    }

    /// Everyone in a long recording, a few times a second.
    pub fn long_recording(&self, report: Report) -> Result<LongRecording, ReadError> {
        let dt = self.recorded.time_step;
        let every = (1.0 / windows::MOMENTS / dt).round().max(1.0) as i64;
        let mut names = HashMap::new();
        let mut tracks = Vec::new();
        for (place, track) in self.recorded.tracks.iter().enumerate() {
            let seen = track.states.iter().filter(|s| s.step % every == 0);
            let states = seen.map(|state| moved(state, |step| step / every));
            let recorded = self.recorded_track(place, track, states.collect());
            names.insert(recorded.id, track.name.clone());
            tracks.push(recorded);
        }
        let about = About::bare(self.about.source, "ZAM_Tracks", dt * every as f64);
        let scenario = assemble(report, about, Map::default(), tracks)?;
        Ok(LongRecording::new(scenario, names, self.recorded.start))
    }

    /// A scenario: `part` is one of several in the table, or a window.
    pub fn open(
        &self,
        file: &Path,
        part: Option<&str>,
        report: Report,
    ) -> Result<Scenario, ReadError> {
        let scenario = part.filter(|part| self.tracks(part).next().is_some());
        let window = part.filter(|_| scenario.is_none());
        let window = window
            .map(|part| WindowRequest::parse(part, &report))
            .transpose()?;
        let name = scenario.or_else(|| self.only_scenario());
        let Some(name) = name else {
            let first = self.recorded.tracks.first().map_or("", |t| &t.scenario);
            let file = file.display();
            return Err(report.fail(format!(
                "several scenarios; name one, such as {file}#{first} (`nearmiss inspect` of its folder lists them)"
            )));
        };
        let (first, last) = self.span(name);
        if window.is_none() && scenario.is_none() && self.is_long(name) {
            let longest = self.tracks(name).max_by_key(|(_, t)| t.states.len());
            let (track, start) = longest.map_or(("1", 0), |(_, t)| (t.name.as_str(), t.span().0));
            let start = self.recorded.start + start as f64 * self.recorded.time_step;
            return Err(windows::too_long(&report, file, track, start));
        }
        let (steps, chosen) = match window {
            Some(window) => {
                let (steps, place) = self.window(&window, name, &report)?;
                (steps, Some(place))
            }
            None => (
                (first, last),
                self.tracks(name).find(|(_, t)| t.is_ego).map(|(p, _)| p),
            ),
        };
        self.scenario(name, steps, chosen, report)
    }

    /// The name of the scenario where the table has one.
    pub(super) fn only_scenario(&self) -> Option<&str> {
        let first = &self.recorded.tracks.first()?.scenario;
        let mut all = self.recorded.tracks.iter();
        all.all(|track| track.scenario == *first).then_some(first)
    }

    /// The steps of a window, and the place of its track.
    fn window(
        &self,
        window: &WindowRequest,
        scenario: &str,
        report: &Report,
    ) -> Result<((i64, i64), usize), ReadError> {
        let dt = self.recorded.time_step;
        let found = self
            .tracks(scenario)
            .find(|(_, track)| track.name == window.track);
        let Some((place, track)) = found else {
            let known = self.tracks(scenario).map(|(_, track)| track.name.as_str());
            let known: Vec<&str> = known.collect();
            let more = match known.len().saturating_sub(MAX_LISTED) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            let first = known[..known.len().min(MAX_LISTED)].join(", ");
            let message = format!("no track `{}`; it has {first}{more}", window.track);
            return Err(report.fail(message));
        };
        let steps = match window.start {
            Some(start) => {
                let first = ((start - self.recorded.start) / dt).round() as i64;
                (first, first + (windows::LENGTH / dt).round() as i64)
            }
            None => track.span(),
        };
        let is_there = |state: &TrackState| (steps.0..=steps.1).contains(&state.step);
        if track.states.iter().any(is_there) {
            return Ok((steps, place));
        }
        Err(report.fail(format!(
            "track `{}` is not there in that window",
            window.track
        )))
    }

    fn scenario(
        &self,
        name: &str,
        steps: (i64, i64),
        ego: Option<usize>,
        report: Report,
    ) -> Result<Scenario, ReadError> {
        for note in &self.about.notes {
            report.note(note.as_str());
        }
        for said in &self.recorded.diagnostics {
            let at = report.row(said.line, said.element.clone());
            at.note(said.severity, said.message.clone());
        }
        self.leftovers.report_to(&report);
        // Of logs no unit of time was found out: they are in seconds.
        let first = self.recorded.start + steps.0 as f64 * self.recorded.time_step;
        if first.abs() >= self.recorded.time_step / 2.0 && self.recorded.decided.time > 0.0 {
            let written = self.recorded.decided.written((first * 1e6).round() / 1e6);
            report.note(format!(
                "time 0 is {} in the table",
                (written * 1e6).round() / 1e6
            ));
        }
        let mut tracks = Vec::new();
        for (place, track) in self.tracks(name) {
            let from = track.states.partition_point(|s| s.step < steps.0);
            let to = track.states.partition_point(|s| s.step <= steps.1);
            let seen = &track.states[from..to];
            if !seen.is_empty() {
                let states = seen.iter().map(|s| moved(s, |step| step - steps.0));
                tracks.push(self.recorded_track(place, track, states.collect()));
            }
        }
        let numbered = self.tracks(name).filter_map(|(place, track)| {
            let id = self.ids.get(&place)?.to_string();
            (id != track.name).then(|| format!("`{}` {id}", track.name))
        });
        let numbered: Vec<String> = numbered.collect();
        if !numbered.is_empty() {
            let some = &numbered[..numbered.len().min(MAX_NUMBERS)];
            let more = match numbered.len() - some.len() {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            report.note(format!("tracks are numbered: {}{more}", some.join(", ")));
        }
        let ego = ego.and_then(|place| self.ids.get(&place).copied());
        let (map, map_hash) = self.map(&report, steps.0, &tracks)?;
        // A window is the same one in a stretch as in the whole table.
        let whole = (steps.0 + self.before, steps.1 + self.before);
        let around = format!("{name} {whole:?} {ego:?} {}", self.about.how);
        let about = About {
            source: self.about.source,
            benchmark_id: format!(
                "ZAM_Tracks-1_{}_T-{}",
                ego.unwrap_or(1).max(1),
                whole.0.max(0) + 1
            ),
            time_step_size: self.recorded.time_step,
            tags: self.about.tags.iter().map(ToString::to_string).collect(),
            ego,
            hash: self.hashed.with([&map_hash.bytes()[..], around.as_bytes()]),
        };
        assemble(report, about, map, tracks)
    }

    /// The map, where there is one; ids of tracks stay theirs.
    fn map(
        &self,
        report: &Report,
        first: i64,
        tracks: &[RecordedTrack],
    ) -> Result<(Map, ContentHash), ReadError> {
        let mut ids = Ids::beyond(self.ids.values().copied());
        self.ids.values().for_each(|id| {
            ids.take(*id);
        });
        let path = match &self.map {
            None => {
                report.note("no map: the scenario has no lanes; --map FILE adds one");
                return Ok((Map::default(), ContentHash::digest(b"")));
            }
            Some(MapOfTable::Inside(bytes)) => {
                report.note("the map is in the recording");
                let network = opendrive::read(bytes, report.file(), report, &mut ids)?;
                return Ok((network.map, ContentHash::digest(bytes)));
            }
            Some(MapOfTable::File(path)) => path,
        };
        report.note(format!("map {}", path.display()));
        let states = tracks.iter().filter_map(|track| track.states.first());
        let dt = self.recorded.time_step;
        let around = Around {
            plane: self.recorded.plane,
            places: states.map(|state| state.position).collect(),
            clock: (self.recorded.start + first as f64 * dt, dt),
        };
        maps::read(report, path, &around, &mut ids)
    }
}

/// A state at another step.
fn moved(state: &TrackState, step: impl Fn(i64) -> i64) -> TrackState {
    TrackState {
        step: step(state.step),
        ..*state
    }
}

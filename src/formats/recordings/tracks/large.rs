//! Tables that are larger than memory: which times are where in the file, so that a stretch of it can be read alone.

use std::collections::HashMap;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_base::system::{self, FileCache};
use nearmiss_scene::scenario::{Diagnostic, HashedBeginning, Scenario, Severity};

use super::arrow;
use super::batch::{Batch, Values, Wanted};
use super::columns::Role;
use super::gather::{Rows, Slice, plain_number};
use super::said::is_own_reading;
use super::table::{Decided, Recorded, Said};
use super::text::{self, BadCell};
use super::{Leftovers, Plan, Table, Written, hashed, numbers};
use crate::commonroad::ReadError;
use crate::dispatch::{Address, Parts, Stretches};
use crate::recordings::Report;
use crate::recordings::windows::{self, WindowRequest};

/// Text of more bytes is read in stretches.
const LARGE_TEXT: u64 = 192 << 20;

/// A Parquet file of more rows is, too.
const LARGE_ROWS: usize = 2_000_000;

/// Rows of a stretch, about.
const STRETCH_ROWS: f64 = 400_000.0;

/// How often a row may be read while the stretches are, on average.
const MOST_READINGS: usize = 12;

/// So much around a window is read, too, seconds: motion is found out from rows before and after.
const MARGIN: f64 = 3.0;

/// Outlines that are kept, bytes.
const MAX_CACHED: usize = 16 << 20;

static OUTLINES: FileCache<Outline> = FileCache::new(MAX_CACHED);

/// What is where in a table.
#[derive(Debug)]
pub struct Outline {
    plan: Plan,
    path: PathBuf,
    pieces: Vec<Piece>,
    /// Names of scenarios; none where the table has one.
    scenarios: Vec<String>,
    /// Ids of tracks by their names, where the table has one scenario.
    ids: HashMap<String, i64>,
    rows: u64,
    /// Rows of a stretch, about.
    at_once: f64,
    /// Its bytes.
    hashed: HashedBeginning,
    /// The units and conventions of the first stretch, and what is said of them.
    decided: Option<Decided>,
    notes: Vec<Diagnostic>,
    /// When step 0 is, seconds.
    start: f64,
}

/// Rows that are read together.
#[derive(Debug)]
struct Piece {
    place: Place,
    rows: u64,
    /// The first and the last time, in the table's unit.
    times: (f64, f64),
    /// Places of the names of scenarios.
    scenarios: Vec<u32>,
}

#[derive(Debug, Clone, Copy)]
enum Place {
    Text(text::Piece),
    /// A row group of Parquet, and its first row, from 1.
    Group(usize, usize),
}

/// The outline of a table, if it is so large that it needs one.
///
/// # Errors
/// It cannot be read.
pub fn outline(
    path: &Path,
    plan: impl FnOnce() -> Result<Plan, ReadError>,
) -> Result<Option<Arc<Outline>>, ReadError> {
    let bytes = std::fs::metadata(path).map_or(0, |file| file.len());
    // Rows of Parquet take a few bytes at least.
    if bytes < LARGE_TEXT.min(LARGE_ROWS as u64) {
        return Ok(None);
    }
    let plan = plan()?;
    let is_large = match &plan.written {
        Written::Text(layout, packing) => {
            let has_lines = layout.form != text::Form::JsonArray;
            let is_plain = *packing == super::Packing::Plain && !plan.is_of_one;
            has_lines && is_plain && bytes > LARGE_TEXT
        }
        Written::Columns(arrow::Form::Parquet) => {
            let groups = arrow::row_groups(path).unwrap_or_default();
            groups.iter().sum::<usize>() > LARGE_ROWS
        }
        Written::Columns(_) | Written::Log(_) => false,
    };
    if !is_large {
        return Ok(None);
    }
    if is_own_reading() {
        return Outline::read(plan, path, STRETCH_ROWS).map(|outline| Some(Arc::new(outline)));
    }
    let found = OUTLINES.get(&[path], || {
        let outline = Outline::read(plan, path, STRETCH_ROWS)?;
        let size = outline.pieces.len() * size_of::<Piece>();
        Ok((outline, size))
    })?;
    Ok(Some(found))
}

impl Outline {
    fn read(plan: Plan, path: &Path, at_once: f64) -> Result<Self, ReadError> {
        let report = Report::about(path.display().to_string());
        let mut outline = Self {
            pieces: Vec::new(),
            scenarios: Vec::new(),
            ids: HashMap::new(),
            rows: 0,
            at_once,
            hashed: hashed(&[path], &report)?,
            decided: None,
            notes: Vec::new(),
            start: 0.0,
            path: path.to_path_buf(),
            plan,
        };
        outline.find_pieces(&report)?;
        outline.check(&report)?;
        // What the units are is found out once, so that all stretches agree.
        let first = outline.stretches(None)[0];
        let rows = outline.rows_of(first, None, &report)?;
        let recorded = outline.recorded(rows, &report)?;
        outline.start = recorded.start;
        outline.decided = Some(recorded.decided);
        let mut notes = recorded.diagnostics;
        notes.retain(|said| said.severity == Severity::Note && said.line == 0);
        outline.notes = notes;
        Ok(outline)
    }

    fn find_pieces(&mut self, report: &Report) -> Result<(), ReadError> {
        let clock = self.plan.columns.clock(self.plan.rate);
        let (roles, wanted) = self.plan.wanted();
        let looked_at = [clock, Role::Nanoseconds, Role::Scenario, Role::Id];
        let some = roles.into_iter().zip(wanted);
        let (roles, wanted): (Vec<Role>, Vec<Wanted>) =
            some.filter(|(role, _)| looked_at.contains(role)).unzip();
        let place = |wanted: Role| roles.iter().position(|role| *role == wanted);
        let (times, scenario, id) = (place(clock), place(Role::Scenario), place(Role::Id));
        let (mut pieces, mut names, mut ids) = (Vec::new(), Names::default(), Names::default());
        let mut add = |place, mut batch: Batch| {
            batch.join_times(&roles);
            let Some(Values::Numbers(times)) = times.map(|times| &batch.values[times]) else {
                return;
            };
            let some = || times.iter().copied().filter(|time| time.is_finite());
            let texts = |place: Option<usize>| match place.map(|place| &batch.values[place]) {
                Some(Values::Texts(_, texts)) => &texts.texts[..],
                _ => &[],
            };
            let scenarios = names.places(texts(scenario));
            // Ids of several scenarios are theirs.
            if names.all.len() < 2 {
                ids.places(texts(id));
            }
            pieces.push(Piece {
                place,
                rows: batch.lines.len() as u64,
                times: (
                    some().fold(f64::INFINITY, f64::min),
                    some().fold(f64::NEG_INFINITY, f64::max),
                ),
                scenarios,
            });
        };
        let read = match &self.plan.written {
            Written::Text(layout, _) => {
                let io = |error| ReadError::io(report.file(), &error);
                let mut file = system::open_file(&self.path).map_err(io)?;
                let mut take = |piece, rows: Batch| add(Place::Text(piece), rows);
                layout.pieces(&mut file, &wanted, &mut take)
            }
            _ => (|| {
                let mut first = 1;
                let groups = arrow::row_groups(&self.path);
                for (group, rows) in groups.map_err(text::unread)?.into_iter().enumerate() {
                    let mut take = |batch: Batch| {
                        add(Place::Group(group, first), batch);
                        Ok(())
                    };
                    arrow::read_group(&self.path, group, first, &wanted, &mut take)?;
                    first += rows;
                }
                Ok(())
            })(),
        };
        read.map_err(|bad| self.plan.wrong(report, bad))?;
        pieces.retain(|piece| piece.times.0 <= piece.times.1);
        // Batches of a group are read together.
        pieces.dedup_by(|next, group| {
            let is_same = matches!((next.place, group.place), (Place::Group(a, _), Place::Group(b, _)) if a == b);
            if is_same {
                group.rows += next.rows;
                group.times.0 = group.times.0.min(next.times.0);
                group.times.1 = group.times.1.max(next.times.1);
                group.scenarios.append(&mut next.scenarios);
            }
            is_same
        });
        self.rows = pieces.iter().map(|piece| piece.rows).sum();
        self.pieces = pieces;
        // A scenario of minutes is listed as a table without one.
        if names.all.len() > 1 {
            self.scenarios = names.all;
        } else {
            let found = numbers(ids.all.iter().map(|name| ("", &**name)));
            self.ids = ids.all.into_iter().zip(found).collect();
        }
        Ok(())
    }

    /// Whether stretches can be read without reading all of it for each.
    fn check(&self, report: &Report) -> Result<(), ReadError> {
        if self.pieces.is_empty() {
            return Err(report.fail("no row with a time"));
        }
        if !self.scenarios.is_empty() {
            return Ok(());
        }
        let all = self.stretches(None);
        let read: usize = all
            .iter()
            .map(|times| self.pieces_in(*times, None).count())
            .sum();
        if all.len() > 2 && read > MOST_READINGS * self.pieces.len() {
            return Err(report.fail(format!(
                "{} rows whose times are all over the file; sort them by time or by track",
                self.rows
            )));
        }
        Ok(())
    }

    /// From when to when stretches are, in the table's unit; `window` is how much two of them share.
    fn stretches(&self, window: Option<f64>) -> Vec<(f64, f64)> {
        let first = self
            .pieces
            .iter()
            .map(|p| p.times.0)
            .fold(f64::INFINITY, f64::min);
        let last = self
            .pieces
            .iter()
            .map(|p| p.times.1)
            .fold(f64::NEG_INFINITY, f64::max);
        let count = (self.rows as f64 / self.at_once).ceil().max(1.0);
        let shared = window.unwrap_or(0.0);
        let long = ((last - first) / count).max(2.0 * shared);
        let count = ((last - first) / long.max(f64::MIN_POSITIVE))
            .ceil()
            .max(1.0) as u32;
        (0..count)
            .map(|i| {
                let from = first + f64::from(i) * long;
                let to = if i + 1 == count {
                    last
                } else {
                    from + long + shared
                };
                (from, to)
            })
            .collect()
    }

    fn pieces_in(&self, times: (f64, f64), scenario: Option<u32>) -> impl Iterator<Item = &Piece> {
        self.pieces.iter().filter(move |piece| {
            let is_then = piece.times.0 <= times.1 && piece.times.1 >= times.0;
            is_then && scenario.is_none_or(|scenario| piece.scenarios.contains(&scenario))
        })
    }

    /// The rows of some times and perhaps of one scenario.
    fn rows_of(
        &self,
        times: (f64, f64),
        scenario: Option<&str>,
        report: &Report,
    ) -> Result<Rows, ReadError> {
        let (roles, wanted) = self.plan.wanted();
        let mut rows = Rows::only(Slice {
            clock: self.plan.columns.clock(self.plan.rate),
            times,
            scenario: scenario.map(str::to_string),
        });
        let place = scenario.and_then(|name| self.scenarios.iter().position(|s| s == name));
        let place = place.and_then(|place| u32::try_from(place).ok());
        let read = self.pieces_in(times, place).try_for_each(|piece| {
            let mut take = |batch| rows.add(&roles, batch);
            match (piece.place, &self.plan.written) {
                (Place::Text(piece), Written::Text(layout, _)) => {
                    let bytes =
                        bytes_of(&self.path, piece).map_err(|e| text::unread(e.to_string()))?;
                    take(layout.piece(&piece, &bytes, &wanted)?)
                }
                (Place::Group(group, first), _) => {
                    arrow::read_group(&self.path, group, first, &wanted, &mut take)
                }
                (Place::Text(_), _) => Ok(()),
            }
        });
        read.map_err(|bad: BadCell| self.plan.wrong(report, bad))?;
        Ok(rows)
    }

    fn recorded(&self, rows: Rows, report: &Report) -> Result<Recorded, ReadError> {
        let said = Said {
            decided: self.decided,
            ..self.plan.said()
        };
        Recorded::new(rows, &self.plan.columns, said, report.file())
    }

    fn table(&self, rows: Rows, report: &Report) -> Result<Table, ReadError> {
        let mut recorded = self.recorded(rows, report)?;
        let notes = self.notes.iter().cloned();
        recorded.diagnostics.splice(0..0, notes);
        let leftovers = Leftovers::default();
        let before = (recorded.start - self.start) / recorded.time_step;
        let mut table = self
            .plan
            .table(recorded, &self.path, self.hashed.clone(), leftovers);
        table.before = before.round() as i64;
        // A road user has the same id in every stretch.
        for (place, track) in table.recorded.tracks.iter().enumerate() {
            if let Some(id) = self.ids.get(&track.name) {
                table.ids.insert(place, *id);
            }
        }
        Ok(table)
    }

    /// The id of the road user that is called so.
    pub fn id_of(&self, name: &str) -> Option<i64> {
        self.ids.get(name).copied()
    }

    /// A time in seconds in the table's unit.
    fn written(&self, seconds: f64) -> f64 {
        self.decided.unwrap_or_default().written(seconds)
    }

    /// The scenarios in it.
    pub fn parts(self: &Arc<Self>) -> Parts {
        if !self.scenarios.is_empty() {
            return Parts::Named(self.scenarios.clone());
        }
        let outline = Arc::clone(self);
        let window = outline.written(windows::LENGTH);
        let all = outline.stretches(Some(window)).into_iter();
        let stretches = all.filter_map(move |times| {
            let report = Report::about(outline.path.display().to_string());
            let rows = match outline.rows_of(times, None, &report) {
                // In a pause no road user is there.
                Ok(rows) if rows.count() == 0 => return None,
                rows => rows,
            };
            let table = rows.and_then(|rows| outline.table(rows, &report));
            Some(table.and_then(|table| table.long_recording(report)))
        });
        let stretches: Stretches = Box::new(stretches);
        Parts::Stretches(stretches)
    }

    /// The scenario at an address in it.
    ///
    /// # Errors
    /// There is none, or no time is named.
    pub fn open_at(&self, address: &Address, report: Report) -> Result<Scenario, ReadError> {
        let part = address.part.as_deref();
        let everything = (f64::NEG_INFINITY, f64::INFINITY);
        if let Some(name) = part.filter(|part| self.scenarios.iter().any(|s| s == part)) {
            let rows = self.rows_of(everything, Some(name), &report)?;
            let table = self.table(rows, &report)?;
            return table.open(&address.file, part, report);
        }
        let window = part
            .map(|part| WindowRequest::parse(part, &report))
            .transpose()?;
        let start = window.and_then(|window| window.start);
        let Some(start) = start else {
            let first = self
                .decided
                .unwrap_or_default()
                .seconds(self.stretches(None)[0].0);
            return Err(windows::too_long(&report, &address.file, "1", first));
        };
        let times = [start - MARGIN, start + windows::LENGTH + MARGIN];
        let [from, to] = times.map(|time| self.written(time));
        let rows = self.rows_of((from, to), None, &report)?;
        let table = self.table(rows, &report)?;
        table.open(&address.file, part, report)
    }
}

/// Names in the order in which they come first.
#[derive(Default)]
struct Names {
    all: Vec<String>,
    places: HashMap<String, u32>,
}

impl Names {
    fn places(&mut self, names: &[String]) -> Vec<u32> {
        let place = |name: &String| {
            let plain = plain_number(name.clone());
            let next = u32::try_from(self.all.len()).unwrap_or(u32::MAX);
            *self.places.entry(plain).or_insert_with_key(|name| {
                self.all.push(name.clone());
                next
            })
        };
        names.iter().map(place).collect()
    }
}

fn bytes_of(path: &Path, piece: text::Piece) -> std::io::Result<Vec<u8>> {
    let mut file = system::open_file(path)?;
    file.seek(SeekFrom::Start(piece.at))?;
    let mut bytes = vec![0; piece.bytes];
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::fmt::Write;

    use super::*;
    use crate::recordings::windows::WindowList;

    /// Two minutes of eight cars on a circle each, ten times a second, in milliseconds and degrees clockwise from north; or
    /// without headings, and as unevenly.
    fn text(by_time: bool, uneven: i32) -> String {
        let mut rows = Vec::new();
        for car in 0..8 {
            for step in 0..1200 {
                let radius = 20.0 + 4.0 * f64::from(car);
                let time = 100 * step + step * 7 % 11 * uneven;
                let turned = f64::from(time) * 1e-3 * 8.0 / radius;
                let (x, y) = (radius * turned.cos(), radius * turned.sin());
                let north = -turned.to_degrees().rem_euclid(360.0) + 360.0;
                let heading = if uneven == 0 {
                    format!("{north:.3}")
                } else {
                    String::new()
                };
                let time = 5_000 + time;
                let name = match car {
                    0 | 1 if uneven > 0 => ["x1", "y1"][usize::from(car == 1)].to_string(),
                    _ => car.to_string(),
                };
                rows.push((
                    step,
                    format!("{time},{name},{x:.4},{y:.4},{heading},8.0,4.5,1.8"),
                ));
            }
        }
        if by_time {
            rows.sort_by_key(|(step, _)| *step);
        }
        let mut text = String::from("time,id,x,y,heading,speed,length,width");
        rows.iter()
            .for_each(|(_, row)| write!(text, "\n{row}").unwrap());
        text
    }

    #[test]
    fn a_stretch_of_a_large_table_is_that_of_the_whole_one() {
        let folder = tempfile::tempdir().unwrap();
        for (by_time, uneven) in [(true, 0), (false, 0), (true, 3)] {
            let path = folder.path().join(format!("{by_time}{uneven}.csv"));
            std::fs::write(&path, text(by_time, uneven)).unwrap();
            let report = || Report::about("t");
            let whole = super::super::read(&path).unwrap();
            let plan = super::super::plan(&path, &report()).unwrap();
            let outline = Arc::new(Outline::read(plan, &path, 3000.0).unwrap());
            assert_eq!(
                (outline.rows, outline.stretches(Some(10_000.0)).len()),
                (9600, 4)
            );
            let Parts::Stretches(stretches) = outline.parts() else {
                panic!("not in stretches")
            };
            let mut list = WindowList::default();
            let mut longest = 0;
            for stretch in stretches {
                let stretch = stretch.unwrap();
                longest = longest.max(stretch.scenario.obstacles[0].track().steps().count());
                list.add(&stretch, &stretch.beginnings());
            }
            // 30 s and what two share, five times a second.
            assert!((199..=200).contains(&longest), "{longest}");
            let windows = list.addresses();
            assert!(windows.contains(&"track=3@5.0s".to_string()), "{windows:?}");
            for part in ["track=3@5.0s", "track=7@61.0s"] {
                let address = Address {
                    file: path.clone(),
                    part: Some(part.into()),
                };
                let of_stretch = outline.open_at(&address, report()).unwrap();
                let of_whole = whole.open_at(&address).unwrap();
                assert_eq!(of_stretch.dt(), of_whole.dt());
                assert_eq!(of_stretch.hash, of_whole.hash);
                let name = |scenario: &Scenario| scenario.header.benchmark_id.clone();
                assert_eq!(name(&of_stretch), name(&of_whole));
                for (a, b) in of_stretch.obstacles.iter().zip(&of_whole.obstacles) {
                    assert_eq!(a.id, b.id);
                    let states = a.track().iter().zip(b.track().iter());
                    for ((step, a), (other, b)) in states {
                        assert_eq!(step, other);
                        assert!((a.pose.position - b.pose.position).norm() < 1e-9);
                        assert!((a.pose.heading - b.pose.heading).abs() < 1e-9);
                    }
                }
            }
            let without_time = Address {
                file: path,
                part: Some("track=3".into()),
            };
            let error = outline.open_at(&without_time, report()).unwrap_err();
            assert!(error.to_string().contains("ten seconds"), "{error}");
        }
    }

    #[test]
    fn a_pause_and_a_scenario_of_one_name_are_listed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        let mut table = String::from("scenario,time,id,x,y\n");
        for (start, name) in [(0, "b"), (0, "c"), (100_000, "a"), (100_000, "c")] {
            for i in 0..200 {
                let time = f64::from(start) + f64::from(i) * 0.1;
                writeln!(table, "one,{time:.1},{name},{i},0").unwrap();
            }
        }
        std::fs::write(&path, table).unwrap();
        let report = || Report::about("t");
        let plan = super::super::plan(&path, &report()).unwrap();
        let outline = Arc::new(Outline::read(plan, &path, 100.0).unwrap());
        let Parts::Stretches(stretches) = outline.parts() else {
            panic!("not in stretches")
        };
        let mut list = WindowList::default();
        for stretch in stretches {
            let stretch = stretch.unwrap();
            list.add(&stretch, &stretch.beginnings());
        }
        assert_eq!(list.addresses().len(), 4, "{:?}", list.addresses());
        let opened = |part: &str| {
            let address = Address {
                file: path.clone(),
                part: Some(part.into()),
            };
            outline.open_at(&address, report()).unwrap()
        };
        let [first, second] = ["track=c@0.0s", "track=c@100000.0s"].map(opened);
        let ids = |scenario: &Scenario| {
            let ego = scenario.recorded_ego.as_ref().unwrap().obstacle.id;
            (scenario.obstacles[0].id, ego)
        };
        assert_eq!((ids(&first), ids(&second)), ((1, 2), (3, 2)));
        assert_ne!(first.hash, second.hash);
        assert_ne!(first.header.benchmark_id, second.header.benchmark_id);
    }
}

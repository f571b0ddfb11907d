//! A table of tracks in SI units: what was found out of its units and conventions, or assumed, is kept for the report.

use nearmiss_base::geometry::{Point, angle_between};
use nearmiss_scene::scenario::{Diagnostic, ObstacleType, Severity};

use super::check::Told;
use super::columns::{Columns, Convention, FOOT, QUATERNION, Role};
use super::gather::{MODE, Rows};
use super::guess::{self, HeadingForm, ODD_HEADING, Pair, SpeedUnit};
use super::states::signed;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::Report;
use crate::recordings::assembly::{self, TrackState};
use crate::recordings::utm::TransverseMercator;

/// The tracks of a table, metres, seconds and radians.
#[derive(Debug)]
pub struct Recorded {
    /// In the order in which they come first.
    pub tracks: Vec<Track>,
    /// When step 0 is, seconds of the recording.
    pub start: f64,
    /// Seconds.
    pub time_step: f64,
    /// Where places in degrees became metres.
    pub plane: Option<TransverseMercator>,
    /// What was found out and assumed, and what is odd.
    pub diagnostics: Vec<Diagnostic>,
    /// Its units and conventions.
    pub decided: Decided,
}

/// The units and conventions of a table, once they are known.
#[derive(Debug, Clone, Copy, Default)]
pub struct Decided {
    /// What one of its times is, seconds.
    pub(super) time: f64,
    /// What one of x, y, length and width is, metres.
    pub(super) lengths: [f64; 4],
    /// What one of its speeds is, m/s.
    pub(super) speed: f64,
    pub(super) is_local: bool,
    pub(super) is_down: bool,
    pub(super) is_turned: bool,
    pub(super) heading: Option<HeadingForm>,
    /// How far before the middle places are, in lengths.
    pub(super) ahead: Option<f64>,
    pub(super) plane: Option<TransverseMercator>,
    /// Seconds.
    pub(super) time_step: f64,
}

impl Decided {
    /// A time of the table in seconds.
    pub fn seconds(&self, written: f64) -> f64 {
        written * self.time
    }

    /// Seconds in the table's unit.
    pub fn written(&self, seconds: f64) -> f64 {
        seconds / self.time
    }
}

/// A track of a table.
#[derive(Debug)]
pub struct Track {
    /// As in the table.
    pub name: String,
    /// The scenario that it is in; empty where the table has one.
    pub scenario: String,
    /// What it is.
    pub kind: ObstacleType,
    /// Whether the table says that it is the ego.
    pub is_ego: bool,
    /// Length and width, metres.
    pub size: (f64, f64),
    /// In order of steps.
    pub states: Vec<TrackState>,
}

impl Track {
    /// The road user of a predicted trajectory, where it is a number.
    pub fn id_of_forecast(&self) -> Option<i64> {
        let name = self
            .name
            .rsplit_once(MODE)
            .map_or(&*self.name, |(id, _)| id);
        name.parse().ok()
    }

    /// The first and the last step.
    pub fn span(&self) -> (i64, i64) {
        let step = |state: Option<&TrackState>| state.map_or(0, |s| s.step);
        (step(self.states.first()), step(self.states.last()))
    }
}

/// What the user or a known data set says of a table beside its columns.
#[derive(Debug, Clone, Copy, Default)]
pub struct Said {
    /// Pictures a second.
    pub rate: Option<f64>,
    /// What classes mean.
    pub kind: Option<fn(&str) -> ObstacleType>,
    /// How much of its units and conventions is known.
    pub trust: Trust,
    /// Whether times only say what comes after what.
    pub is_order: bool,
    /// What was found out of another part of the table.
    pub decided: Option<Decided>,
}

/// How much is known of the units and conventions of a table.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Trust {
    /// What its columns say.
    #[default]
    Nothing,
    /// It has the columns of our own: what contradicts seconds, metres and radians is found out.
    Ours,
    /// A data set says all: nothing is guessed.
    All,
}

/// So many tracks are named.
const MAX_NAMED: usize = 5;

/// Pairs of rows that are looked at to find something out.
const MOST_PAIRS: usize = 50_000;

/// A table whose units are being found out.
pub(super) struct Work<'a> {
    pub(super) rows: Rows,
    pub(super) columns: &'a Columns,
    pub(super) said: Said,
    pub(super) report: Report,
    /// Seconds, once they are known; before as in the table.
    pub(super) times: Vec<f64>,
    /// Metres once they are known.
    pub(super) places: Vec<Point>,
    pub(super) plane: Option<TransverseMercator>,
    /// Rows of each track in order of time.
    pub(super) order: Vec<Vec<u32>>,
    /// Length and width of each track, 0 where the table has none.
    pub(super) sizes: Vec<(f64, f64)>,
    /// What speeds are multiplied with to be m/s.
    pub(super) speed: f64,
    /// Whether velocities are along and across the body rather than the axes.
    pub(super) is_local: bool,
    /// Whether the table's y grows downwards.
    pub(super) is_down: bool,
    /// Whether velocities along y are the other way than places are now.
    pub(super) is_turned: bool,
    /// What one of its times is, seconds, and one of x, y, length and width, metres.
    pub(super) time: f64,
    pub(super) lengths: [f64; 4],
    /// How far before the middle places are, in lengths.
    pub(super) ahead: Option<f64>,
    /// Headings of rows without one whose places were moved, radians; empty where none were.
    pub(super) followed: Vec<f64>,
}

impl Recorded {
    /// Finds out the units of a table and makes its tracks; `file` names it in messages.
    ///
    /// # Errors
    /// There is no row, or its times cannot be understood: what to say about them.
    pub fn new(rows: Rows, columns: &Columns, said: Said, file: &str) -> Result<Self, ReadError> {
        let report = Report::about(file);
        if rows.lines.is_empty() {
            let message = match rows.incomplete {
                (0, _) => "no track in it: it has no rows".into(),
                (count, line) => format!(
                    "no track in it: {count} rows lack an id, a time or a place, the first one in line {line}"
                ),
            };
            return Err(report.fail(message));
        }
        let mut work = Work::new(rows, columns, said, report);
        work.note_rows();
        work.read_places()?;
        work.read_times()?;
        work.read_lengths();
        work.read_speeds();
        let form = work.read_headings();
        work.check_units(form);
        let (start, time_step) = work.steps(form)?;
        work.move_to_middles(form, start, time_step);
        work.finish(form, start, time_step)
    }

    /// Bytes, about.
    pub fn size(&self) -> usize {
        let states: usize = self.tracks.iter().map(|t| t.states.capacity()).sum();
        states * size_of::<TrackState>() + self.tracks.len() * (size_of::<Track>() + 32)
    }
}

impl<'a> Work<'a> {
    fn new(mut rows: Rows, columns: &'a Columns, said: Said, report: Report) -> Self {
        let parts = QUATERNION.map(|role| rows.numbers.remove(&role));
        if let [Some(w), Some(x), Some(y), Some(z)] = parts {
            let yaw = |row: usize| assembly::yaw([w[row], x[row], y[row], z[row]]);
            let headings = (0..w.len()).map(yaw).collect();
            rows.numbers.insert(Role::Heading, headings);
        }
        let count = rows.tracks.len();
        let mut sizes = vec![(0.0, 0.0); count];
        let of = |role: Role| rows.numbers.get(&role);
        for (row, track) in rows.track.iter().enumerate() {
            let size = &mut sizes[*track as usize];
            let value = |role: Role| of(role).map_or(0.0, |values| values[row]);
            // The first size of a track is its size.
            for (known, value) in [
                (&mut size.0, value(Role::Length)),
                (&mut size.1, value(Role::Width)),
            ] {
                if *known <= 0.0 && value > 0.0 {
                    *known = value;
                }
            }
        }
        Self {
            order: Vec::new(),
            times: Vec::new(),
            places: Vec::new(),
            plane: None,
            speed: 1.0,
            is_local: false,
            is_down: columns.has(Convention::Down),
            is_turned: columns.has(Convention::Down),
            followed: Vec::new(),
            time: 1.0,
            lengths: [1.0; 4],
            ahead: None,
            rows,
            columns,
            said,
            report,
            sizes,
        }
    }

    pub(super) fn factor(&self, role: Role) -> Option<f64> {
        self.columns.source(role)?.factor
    }

    pub(super) fn column(&self, role: Role) -> &str {
        self.columns.source(role).map_or("", |s| s.column.as_str())
    }

    pub(super) fn numbers(&self, role: Role) -> Option<&Vec<f64>> {
        self.rows.numbers.get(&role)
    }

    fn note_rows(&self) {
        let (count, line) = self.rows.incomplete;
        if count > 0 {
            let at = self.report.row(line as usize, "");
            at.warn(format!(
                "{count} rows lack an id, a time or a place, this one first; left out"
            ));
        }
        self.report.note_count(self.rows.headers, |n| {
            format!("header lines between rows: {n}; skipped")
        });
        self.report.note_count(self.rows.unknown, |n| {
            format!("values of keys that none of the first rows has: {n}; not read")
        });
        self.report.note_count(self.rows.commas, |n| {
            format!("numbers with a decimal comma: {n}; read as with a point")
        });
        self.report.note(format!("columns: {}", self.columns));
    }

    /// Places as in the table, those in degrees in metres.
    fn read_places(&mut self) -> Result<(), ReadError> {
        let planar = self.numbers(Role::X).zip(self.numbers(Role::Y));
        let places: Vec<Point> = if let Some((x, y)) = planar {
            x.iter().zip(y).map(|(x, y)| Point::new(*x, *y)).collect()
        } else if let (Some(longitude), Some(latitude)) =
            (self.numbers(Role::Longitude), self.numbers(Role::Latitude))
        {
            let outside = latitude
                .iter()
                .zip(longitude)
                .position(|(lat, lon)| lat.abs() > 90.0 || lon.abs() > 360.0);
            if let Some(row) = outside {
                let at = self.report.row(self.rows.lines[row] as usize, "");
                let message = format!("latitude {}, longitude {}", latitude[row], longitude[row]);
                return Err(at.fail(message));
            }
            // The plane is that of the place in whole hundredths of a degree, so that tables of a place have the same.
            let round = |v: f64| (v * 100.0).round() / 100.0;
            let (lat, lon) = (round(latitude[0]), round(longitude[0]));
            let known = self.said.decided.and_then(|decided| decided.plane);
            let plane = known.unwrap_or_else(|| TransverseMercator::around(lat, lon));
            let each = latitude.iter().zip(longitude);
            let places = each.map(|(lat, lon)| {
                let (east, north) = plane.forward(*lat, *lon);
                Point::new(east, north)
            });
            let places = places.collect();
            if known.is_none() {
                self.report.note(format!(
                    "places in degrees; x and y are metres east and north of {lat}, {lon}"
                ));
            }
            self.plane = Some(plane);
            places
        } else {
            Vec::new()
        };
        self.places = places;
        Ok(())
    }

    /// Rows of tracks that follow each other, from all over the table.
    pub(super) fn pairs(&self) -> Vec<Pair> {
        let every = (self.rows.lines.len() / MOST_PAIRS).max(1);
        let velocity = self
            .numbers(Role::VelocityX)
            .zip(self.numbers(Role::VelocityY));
        let mut pairs = Vec::new();
        for (track, rows) in self.order.iter().enumerate() {
            for pair in rows.windows(2).step_by(every) {
                let (a, b) = (pair[0] as usize, pair[1] as usize);
                let heading = |row: usize| self.numbers(Role::Heading).map_or(f64::NAN, |h| h[row]);
                let speed = match (self.numbers(Role::Speed), velocity) {
                    (Some(speed), _) => speed[b],
                    (None, Some((x, y))) => x[b].hypot(y[b]),
                    (None, None) => f64::NAN,
                };
                let time = self.times[b] - self.times[a];
                if time > 0.0 {
                    pairs.push(Pair {
                        track,
                        time,
                        moved: self.places[b] - self.places[a],
                        heading: (heading(a), heading(b)),
                        speed,
                        length: self.sizes[track].0,
                    });
                }
            }
        }
        pairs
    }

    /// Lengths and places in metres.
    fn read_lengths(&mut self) {
        let measured = self
            .sizes
            .iter()
            .copied()
            .filter(|s| s.0 > 0.0 && s.1 > 0.0);
        let measured: Vec<(f64, f64)> = measured.collect();
        let said = |role| self.factor(role);
        let is_said = match self.said.decided {
            Some(decided) => decided.lengths.map(Some),
            None => [Role::X, Role::Y, Role::Length, Role::Width].map(said),
        };
        let found = is_said.iter().all(Option::is_none) && guess::are_feet(&measured);
        if found {
            self.report
                .note("lengths are in feet: so vehicles are as wide as usual");
        }
        let usual = if found { FOOT } else { 1.0 };
        self.lengths = is_said.map(|factor| factor.unwrap_or(usual));
        if let Some(decided) = self.said.decided {
            self.is_down = decided.is_down;
        }
        let [x, y, length, width] = self.lengths;
        if self.plane.is_none() {
            // y points down in pictures.
            let y = if self.is_down { -y } else { y };
            for place in &mut self.places {
                *place = Point::new(place.x * x, place.y * y);
            }
        }
        for size in &mut self.sizes {
            *size = (size.0 * length, size.1 * width);
        }
    }

    /// Speeds in m/s.
    fn read_speeds(&mut self) {
        if let Some(decided) = self.said.decided {
            (self.speed, self.is_local) = (decided.speed, decided.is_local);
            self.is_turned = decided.is_turned;
            return;
        }
        let given = [Role::Speed, Role::VelocityX].map(|role| self.numbers(role).is_some());
        let role = match given {
            [true, _] => Role::Speed,
            [_, true] => Role::VelocityX,
            _ => return,
        };
        let pairs = self.pairs();
        self.speed = match (
            self.factor(role),
            guess::speed_unit(&pairs, self.lengths[0] == FOOT),
        ) {
            (Some(factor), _) => factor,
            (None, SpeedUnit::Known(name, factor)) => {
                if factor < 1.0 {
                    self.report
                        .note(format!("speeds are in {name}: so they agree with places"));
                }
                factor
            }
            (None, SpeedUnit::Odd(ratio)) => {
                let at = self.report.at(format!("column {}", self.column(role)));
                at.warn(format!(
                    "speeds are {ratio:.2} times what places and times say; taken as m/s: are the units of all three right?"
                ));
                1.0
            }
            (None, SpeedUnit::Unknown) => 1.0,
        };
        if let Some((x, y)) = self
            .numbers(Role::VelocityX)
            .zip(self.numbers(Role::VelocityY))
        {
            // As y says, and the other way.
            let ways = [self.is_down, !self.is_down];
            let mut off = ways.map(|_| Vec::new());
            for rows in &self.order {
                for pair in rows.windows(2).take(100) {
                    let (a, b) = (pair[0] as usize, pair[1] as usize);
                    let moved = self.places[b] - self.places[a];
                    if moved.norm() > 0.1 && x[b].hypot(y[b]) > 0.5 {
                        for (off, is_turned) in off.iter_mut().zip(ways) {
                            let y = if is_turned { -y[b] } else { y[b] };
                            let between = angle_between(y.atan2(x[b]), moved.y.atan2(moved.x));
                            off.push(between.abs());
                        }
                    }
                }
            }
            let is_many = off[0].len() > 20;
            let middle = off.map(assembly::median);
            self.is_turned = ways[usize::from(is_many && middle[1] < middle[0])];
            self.is_local = self.said.trust == Trust::Nothing
                && is_many
                && middle.iter().all(|off| *off > 0.6)
                && self.numbers(Role::Heading).is_some();
            if self.is_local {
                self.report.note(format!(
                    "`{}` and `{}` are along and across the body: they do not follow the places",
                    self.column(Role::VelocityX),
                    self.column(Role::VelocityY)
                ));
            }
        }
    }

    /// How headings are written; nothing where there are none.
    fn read_headings(&mut self) -> Option<HeadingForm> {
        self.numbers(Role::Heading)?;
        if let Some(decided) = self.said.decided {
            return decided.heading;
        }
        let degrees = self.factor(Role::Heading).map(|factor| factor < 1.0);
        let says_north = self.columns.has(Convention::North);
        let pairs = self.pairs();
        let is_plain = || {
            let off = guess::heading_off(&pairs, HeadingForm::default());
            off.is_some_and(|off| off <= ODD_HEADING)
        };
        if self.said.trust == Trust::All || self.said.trust == Trust::Ours && is_plain() {
            return Some(HeadingForm {
                degrees: degrees.unwrap_or(false),
                from_north: says_north,
                mirrored: self.is_down && !says_north,
            });
        }
        let north = says_north.then_some(true);
        let (found_form, off) = guess::heading_form(&pairs, degrees, north);
        let mut form = found_form;
        let column = format!("column {}", self.column(Role::Heading));
        let mut found = Vec::new();
        if degrees.is_none() && form.degrees {
            found.push("in degrees");
        }
        if north.is_none() && form.from_north {
            found.push("clockwise from north");
        }
        if !found.is_empty() {
            let why = off.map_or("so large are they", |_| "so they agree with the motion");
            let message = format!("headings are {}: {why}", found.join(", "));
            self.report.at(&*column).note(Severity::Note, message);
        }
        match off {
            // They are as the table's places are, before those were turned over.
            _ if self.is_down => form.mirrored = off.is_none() && !form.from_north || form.mirrored,
            Some(_) if form.mirrored => {
                self.report
                    .note("y grows downwards: so headings agree with the motion; turned over");
                self.is_down = true;
                self.is_turned = !self.is_turned;
                self.places.iter_mut().for_each(|place| place.y = -place.y);
                form.mirrored = false;
            }
            _ => {}
        }
        if let Some(off) = off.filter(|off| *off > ODD_HEADING) {
            let odd = pairs.chunk_by(|a, b| a.track == b.track);
            let odd = odd.filter(|of| {
                guess::heading_off(of, found_form).is_some_and(|off| off > ODD_HEADING)
            });
            let names: Vec<String> = odd
                .map(|of| format!("`{}`", self.rows.tracks[of[0].track].name))
                .collect();
            let of = match names.len() {
                0 => String::new(),
                count if count > MAX_NAMED => format!(" (tracks: {count})"),
                _ => format!(" (tracks {})", names.join(", ")),
            };
            self.report.at(column).warn(format!(
                "headings are {:.0}° off the motion on average{of}; are they of this table?",
                off.to_degrees()
            ));
        }
        Some(form)
    }

    /// Tells tracks whose speeds or headings are in another unit than those of the others.
    fn check_units(&self, form: Option<HeadingForm>) {
        if self.said.trust == Trust::All || self.said.decided.is_some() {
            return;
        }
        let mut speeds = Told::new(&self.report, "speeds in another unit");
        let mut headings = Told::new(&self.report, "headings in another unit");
        let pairs = self.pairs();
        for pairs in pairs.chunk_by(|a, b| a.track == b.track) {
            let track = pairs[0].track;
            let name = &self.rows.tracks[track].name;
            let line = self.rows.lines[self.order[track][0] as usize];
            if let Some((unit, ratio)) = guess::other_speed_unit(pairs, self.speed) {
                speeds.tell(line, name, || {
                    format!(
                        "its speeds are {ratio:.2} times its motion; are they in {unit}? used as is"
                    )
                });
            }
            let form = form.filter(|_| self.numbers(Role::Heading).is_some());
            if let Some((form, off)) =
                form.and_then(|f| Some((f, guess::other_angle_unit(pairs, f)?)))
            {
                let unit = if form.degrees { "radians" } else { "degrees" };
                headings.tell(line, name, || {
                    let off = off.to_degrees();
                    format!(
                        "its headings are {off:.0}° off its motion; are they in {unit}? used as is"
                    )
                });
            }
        }
        speeds.finish();
        headings.finish();
    }

    /// The heading of a row, radians; NaN where it has none.
    pub(super) fn heading(&self, form: HeadingForm, row: u32) -> f64 {
        let written = self
            .numbers(Role::Heading)
            .map_or(f64::NAN, |h| h[row as usize]);
        signed(form, written)
    }
}

//! The tracks of a table whose units are known: steps, states, and what of these has to be derived.

use std::cell::OnceCell;
use std::f64::consts::FRAC_PI_2;

use nearmiss_base::geometry::{Point, angle_between};
use nearmiss_scene::scenario::Sample;
use nearmiss_scene::scenario::plausibility::refused_coordinate;
use nearmiss_scene::scenario::track::forget_headings_at_standstill;

use super::check::{self, Seen};
use super::columns::Role;
use super::guess::HeadingForm;
use super::motion;
use super::table::{Decided, Recorded, Track, Trust, Work};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::assembly::{TrackState, signed_speed};

impl Work<'_> {
    /// The tracks.
    pub(super) fn finish(
        self,
        form: Option<HeadingForm>,
        start: f64,
        dt: f64,
    ) -> Result<Recorded, ReadError> {
        if let Some(row) = self.places.iter().position(|p| {
            refused_coordinate(p.x)
                .or(refused_coordinate(p.y))
                .is_some()
        }) {
            let at = self.report.row(self.rows.lines[row] as usize, "");
            let why = refused_coordinate(self.places[row].x)
                .or(refused_coordinate(self.places[row].y))
                .unwrap_or_default();
            return Err(at.fail(why));
        }
        let step = |time: f64| ((time - start) / dt).round() as i64;
        let seen = self
            .order
            .iter()
            .zip(&self.rows.tracks)
            .map(|(rows, track)| {
                let each = rows.iter().map(|row| Seen {
                    step: step(self.times[*row as usize]),
                    line: self.rows.lines[*row as usize],
                    place: self.places[*row as usize],
                });
                (track.name.clone(), each.collect())
            });
        let seen: Vec<(String, Vec<Seen>)> = seen.collect();
        check::check(&self.report, &seen, dt);
        let mut missing = Missing::default();
        let mut tracks = Vec::with_capacity(seen.len());
        for (track, (name, rows)) in seen.into_iter().enumerate() {
            let states = self.states(track, &rows, form, dt, &mut missing);
            let named = &self.rows.tracks[track];
            tracks.push(Track {
                name,
                scenario: named.scenario.clone(),
                kind: self.kind(track),
                is_ego: named.is_ego,
                size: self.sizes[track],
                states,
            });
        }
        self.report.note_count(missing.headings, |n| {
            format!("headings from the motion, smoothed over up to 0.8 s: {n}")
        });
        if !missing.still.is_empty() {
            let some = missing.still.iter().take(MAX_STILL);
            let some: Vec<String> = some.map(|name| format!("`{name}`")).collect();
            let more = match missing.still.len() - some.len() {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            self.report.note(format!(
                "tracks that never move: {}{more}; their headings are not known, 0 (along x) is taken",
                some.join(", ")
            ));
        }
        self.report.note_count(missing.held, |n| {
            format!(
                "`{}` is the direction of movement, which standstill has none of; held there (rows: {n})",
                self.column(Role::Heading)
            )
        });
        self.report.note_count(missing.speeds, |n| {
            format!("speeds from the motion, smoothed over up to 0.8 s: {n}")
        });
        let decided = Decided {
            time: self.time,
            lengths: self.lengths,
            speed: self.speed,
            is_local: self.is_local,
            is_down: self.is_down,
            is_turned: self.is_turned,
            time_step: dt,
            heading: form,
            ahead: self.ahead,
            plane: self.plane,
        };
        Ok(Recorded {
            tracks,
            decided,
            start,
            time_step: dt,
            plane: self.plane,
            diagnostics: self.report.into_diagnostics(),
        })
    }

    /// The speed that a row says, m/s, for a body with this heading.
    fn speed(&self, row: usize, heading: f64) -> Option<f64> {
        let own = self.numbers(Role::Speed).map(|all| all[row] * self.speed);
        own.filter(|speed| speed.is_finite()).or_else(|| {
            let [x, y] = [Role::VelocityX, Role::VelocityY].map(|role| self.numbers(role));
            let (x, y) = (x?[row] * self.speed, y?[row] * self.speed);
            let y = if self.is_turned { -y } else { y };
            let speed = if self.is_local {
                x.hypot(y).copysign(x)
            } else {
                signed_speed(heading, x, y)
            };
            speed.is_finite().then_some(speed)
        })
    }

    /// The headings of a track's rows, NaN where it has none. Those of rows that stand and that only a motion tells are
    /// held, and counted in `missing`.
    fn headings(
        &self,
        order: &[u32],
        rows: &[Seen],
        form: Option<HeadingForm>,
        dt: f64,
        missing: &mut Missing,
    ) -> Vec<f64> {
        let Some((form, written)) = form.zip(self.numbers(Role::Heading)) else {
            return vec![f64::NAN; rows.len()];
        };
        let mut headings: Vec<f64> = order.iter().map(|row| self.heading(form, *row)).collect();
        if self.said.trust != Trust::Nothing {
            return headings;
        }
        // Standstill is told in tenths of a second.
        let scale = (STEP / dt).max(1.0);
        let samples = rows
            .iter()
            .zip(order)
            .zip(&headings)
            .map(|((seen, row), heading)| {
                let is_zero = written[*row as usize] == 0.0;
                Sample {
                    step: seen.step,
                    position: seen.place * scale,
                    heading: Some(if is_zero { 0.0 } else { *heading }).filter(|h| h.is_finite()),
                    velocity: self.speed(*row as usize, *heading),
                    acceleration: None,
                }
            });
        let mut samples: Vec<Sample> = samples.collect();
        forget_headings_at_standstill(&mut samples);
        let is_known = |i: &usize| samples[*i].heading.is_some();
        let Some(mut held) = (0..samples.len()).find(is_known).map(|i| headings[i]) else {
            return headings;
        };
        for (i, heading) in headings.iter_mut().enumerate() {
            if is_known(&i) {
                held = *heading;
            } else if angle_between(held, *heading).abs() > TURNED {
                missing.held += 1;
                *heading = held;
            }
        }
        headings
    }

    /// The states of a track; headings and speeds that had to be derived are counted in `missing`.
    fn states(
        &self,
        track: usize,
        rows: &[Seen],
        form: Option<HeadingForm>,
        dt: f64,
        missing: &mut Missing,
    ) -> Vec<TrackState> {
        let order = &self.order[track];
        let headings = self.headings(order, rows, form, dt, missing);
        let acceleration = self.numbers(Role::Acceleration);
        let stronger = self.factor(Role::Acceleration).unwrap_or(1.0);
        // What the table says is not derived.
        let derived = OnceCell::new();
        let derive = || {
            let steps: Vec<i64> = rows.iter().map(|row| row.step).collect();
            let places: Vec<Point> = rows.iter().map(|row| row.place).collect();
            motion::derive(&steps, &places, dt)
        };
        if headings.iter().all(|heading| heading.is_nan())
            && derived.get_or_init(derive).iter().all(|at| at.speed == 0.0)
        {
            missing.still.push(self.rows.tracks[track].name.clone());
        }
        let mut states = Vec::with_capacity(rows.len());
        for (i, seen) in rows.iter().enumerate() {
            let row = order[i];
            let at = row as usize;
            let heading = if headings[i].is_nan() {
                missing.headings += 1;
                let followed = self.followed.get(at).filter(|heading| heading.is_finite());
                followed.map_or_else(|| derived.get_or_init(derive)[i].heading, |known| *known)
            } else {
                headings[i]
            };
            let said = self.speed(at, heading);
            let own = acceleration.map(|all| all[at] * stronger);
            let own = own.filter(|value| value.is_finite());
            let (velocity, acceleration) = match said {
                Some(speed) => (speed, own),
                None => {
                    missing.speeds += 1;
                    let found = derived.get_or_init(derive)[i];
                    // A body whose heading is known may go backwards.
                    let back = angle_between(found.heading, heading).abs() > FRAC_PI_2;
                    let sign = if back { -1.0 } else { 1.0 };
                    let acceleration = own.or(Some(found.acceleration * sign));
                    (found.speed * sign, acceleration)
                }
            };
            states.push(TrackState {
                step: seen.step,
                position: seen.place,
                heading,
                velocity: Some(velocity),
                acceleration,
            });
        }
        states
    }
}

/// So many rows lack something.
#[derive(Default)]
struct Missing {
    headings: usize,
    speeds: usize,
    /// Headings that were held.
    held: usize,
    /// Tracks that never move and have no heading.
    still: Vec<String>,
}

/// So many tracks that never move are named.
const MAX_STILL: usize = 5;

/// A usual step, seconds.
const STEP: f64 = 0.1;

/// No body that stands turns by more, radians.
const TURNED: f64 = 0.1;

/// A heading in radians for places as they are now.
pub(super) fn signed(form: HeadingForm, written: f64) -> f64 {
    let radians = form.radians(written);
    if form.mirrored { -radians } else { radians }
}

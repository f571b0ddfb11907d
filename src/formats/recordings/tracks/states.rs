//! The tracks of a table whose units are known: steps, states, and what of these has to be derived.

use std::cell::OnceCell;
use std::f64::consts::FRAC_PI_2;

use nearmiss_base::geometry::{Point, angle_between};
use nearmiss_scene::scenario::plausibility::refused_coordinate;

use super::check::{self, Seen};
use super::columns::Role;
use super::guess::HeadingForm;
use super::motion;
use super::table::{Decided, Recorded, Track, Work};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::assembly::{self, TrackState, signed_speed};
use crate::recordings::rows::Steps;

impl Work<'_> {
    /// The tracks.
    pub(super) fn finish(mut self, form: Option<HeadingForm>) -> Result<Recorded, ReadError> {
        let steps = self.steps()?;
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
        let step = |time: f64| ((time - steps.0) / steps.1).round() as i64;
        let mut seen: Vec<(String, Vec<Seen>)> = Vec::with_capacity(self.order.len());
        let mut twice: Option<(u32, String, usize)> = None;
        for (track, rows) in self.order.iter_mut().enumerate() {
            let (times, before) = (&self.times, rows.len());
            let mut first_twice = None;
            rows.dedup_by(|row, kept| {
                let same = step(times[*row as usize]) == step(times[*kept as usize]);
                if same {
                    first_twice.get_or_insert(self.rows.lines[*row as usize]);
                }
                same
            });
            let name = &self.rows.tracks[track].name;
            if let Some(line) = first_twice {
                let known = twice.get_or_insert((line, name.clone(), 0));
                known.2 += before - rows.len();
            }
            let each = rows.iter().map(|row| Seen {
                step: step(self.times[*row as usize]),
                line: self.rows.lines[*row as usize],
                place: self.places[*row as usize],
            });
            seen.push((name.clone(), each.collect()));
        }
        if let Some((line, name, count)) = twice {
            let at = self.report.row(line as usize, format!("track `{name}`"));
            at.warn(format!(
                "{count} rows are at a time that their track has already, this one first; the first row of each is used"
            ));
        }
        check::check(&self.report, &seen, steps.1);
        let mut missing = (0, 0);
        let mut tracks = Vec::with_capacity(seen.len());
        for (track, (name, rows)) in seen.into_iter().enumerate() {
            let states = self.states(track, &rows, form, steps.1, &mut missing);
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
        self.report.note_count(missing.0, |n| {
            format!("headings from the motion, smoothed over up to 0.8 s: {n}")
        });
        self.report.note_count(missing.1, |n| {
            format!("speeds from the motion, smoothed over up to 0.8 s: {n}")
        });
        let decided = Decided {
            time: self.time,
            lengths: self.lengths,
            speed: self.speed,
            is_local: self.is_local,
            is_down: self.is_down,
            heading: form,
            ahead: self.ahead,
            plane: self.plane,
        };
        Ok(Recorded {
            tracks,
            decided,
            start: steps.0,
            time_step: steps.1,
            plane: self.plane,
            diagnostics: self.report.into_diagnostics(),
        })
    }

    /// When the first step is and how long one is, seconds. Rows of a table that is sampled unevenly are put on even steps.
    fn steps(&mut self) -> Result<(f64, f64), ReadError> {
        let mut all = self.times.clone();
        all.sort_by(f64::total_cmp);
        all.dedup();
        match Steps::from_times(&all) {
            Ok(found) => {
                found.report_to(&self.report);
                Ok((found.start, found.time_step))
            }
            Err(why) => {
                // Each track may have a clock of its own.
                let between = self.order.iter().flat_map(|rows| {
                    rows.windows(2)
                        .map(|pair| self.times[pair[1] as usize] - self.times[pair[0] as usize])
                });
                let between = between.filter(|time| *time > 1e-4).collect();
                let median = assembly::median(between);
                let time_step = (median * 1e3).round() / 1e3;
                let (start, last) = (all[0], all[all.len() - 1]);
                if time_step <= 0.0 || (last - start) / time_step > 1e7 {
                    return Err(self.report.fail(why));
                }
                self.resample(start, time_step);
                self.report.at("").warn(format!(
                    "rows are not at equal times; places are interpolated at steps of {time_step} s"
                ));
                Ok((start, time_step))
            }
        }
    }

    /// Moves rows to the nearest steps: place, heading and speed at that time, by those of the rows around it.
    fn resample(&mut self, start: f64, time_step: f64) {
        let old = (self.times.clone(), self.places.clone());
        let numbers = [
            Role::Heading,
            Role::Speed,
            Role::VelocityX,
            Role::VelocityY,
            Role::Acceleration,
        ];
        let before: Vec<(Role, Vec<f64>)> = numbers
            .into_iter()
            .filter_map(|role| Some((role, self.rows.numbers.get(&role)?.clone())))
            .collect();
        for rows in &self.order {
            for (i, row) in rows.iter().enumerate() {
                let row = *row as usize;
                let time = start + ((old.0[row] - start) / time_step).round() * time_step;
                let other = if time < old.0[row] {
                    i.checked_sub(1).and_then(|i| rows.get(i))
                } else {
                    rows.get(i + 1)
                };
                self.times[row] = time;
                let Some(other) = other.map(|row| *row as usize) else {
                    continue;
                };
                let between = old.0[other] - old.0[row];
                if between == 0.0 || between.abs() > 3.0 * time_step {
                    continue;
                }
                let part = (time - old.0[row]) / between;
                self.places[row] = old.1[row] + (old.1[other] - old.1[row]) * part;
                for (role, values) in &before {
                    let (a, b) = (values[row], values[other]);
                    // Headings that pass the end of their circle stay.
                    let is_far = *role == Role::Heading && (b - a).abs() > 1.0;
                    if let Some(all) = self.rows.numbers.get_mut(role).filter(|_| !is_far) {
                        all[row] = a + (b - a) * part;
                    }
                }
            }
        }
    }

    /// The states of a track; headings and speeds that had to be derived are counted in `missing`.
    fn states(
        &self,
        track: usize,
        rows: &[Seen],
        form: Option<HeadingForm>,
        dt: f64,
        missing: &mut (usize, usize),
    ) -> Vec<TrackState> {
        let order = &self.order[track];
        let velocity = self
            .numbers(Role::VelocityX)
            .zip(self.numbers(Role::VelocityY));
        let acceleration = self.numbers(Role::Acceleration);
        let stronger = self.factor(Role::Acceleration).unwrap_or(1.0);
        let complete =
            form.is_some() && (velocity.is_some() || self.numbers(Role::Speed).is_some());
        // What the table says is not derived.
        let derived = OnceCell::new();
        let derive = || {
            let steps: Vec<i64> = rows.iter().map(|row| row.step).collect();
            let places: Vec<Point> = rows.iter().map(|row| row.place).collect();
            motion::derive(&steps, &places, dt)
        };
        if !complete {
            derived.get_or_init(derive);
        }
        let mut states = Vec::with_capacity(rows.len());
        for (i, seen) in rows.iter().enumerate() {
            let row = order[i];
            let at = row as usize;
            let given = form.map_or(f64::NAN, |form| self.heading(form, row));
            let heading = if given.is_nan() {
                missing.0 += 1;
                derived.get_or_init(derive)[i].heading
            } else {
                given
            };
            let by_axes = velocity.map(|(x, y)| (x[at] * self.speed, y[at] * self.speed));
            let said = match (self.numbers(Role::Speed), by_axes) {
                (Some(speed), _) if speed[at].is_finite() => Some(speed[at] * self.speed),
                (_, Some((x, y))) if x.is_finite() && y.is_finite() => Some(if self.is_local {
                    x.hypot(y).copysign(x)
                } else {
                    signed_speed(heading, x, if self.is_down { -y } else { y })
                }),
                _ => None,
            };
            let own = acceleration.map(|all| all[at] * stronger);
            let own = own.filter(|value| value.is_finite());
            let (velocity, acceleration) = match said {
                Some(speed) => (speed, own),
                None => {
                    missing.1 += 1;
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

/// A heading in radians for places as they are now.
pub(super) fn signed(form: HeadingForm, written: f64) -> f64 {
    let radians = form.radians(written);
    if form.mirrored { -radians } else { radians }
}

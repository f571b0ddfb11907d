//! The times of a table: their unit, and the even steps that rows are put on.

use std::f64::consts::PI;

use super::columns::Role;
use super::guess::{self, HeadingForm, TimeUnit};
use super::table::{Trust, Work};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::assembly;
use crate::recordings::rows::Steps;

/// Times that are nearer to each other are the same, seconds.
const SAME: f64 = 1e-4;

/// Over more steps nothing is interpolated.
const GAP: f64 = 3.0;

/// So many steps before its first row and behind its last one a track is there.
const BEYOND: f64 = 0.25;

/// No table has more steps.
const MOST_STEPS: f64 = 1e7;

impl Work<'_> {
    /// Puts the rows of each track in order of time and of the file.
    fn order_rows(&mut self) {
        let mut order = vec![Vec::new(); self.rows.tracks.len()];
        for (row, track) in (0..).zip(&self.rows.track) {
            order[*track as usize].push(row);
        }
        for rows in &mut order {
            rows.sort_by(|a, b| self.times[*a as usize].total_cmp(&self.times[*b as usize]));
        }
        self.order = order;
    }

    /// Times in seconds.
    pub(super) fn read_times(&mut self) -> Result<(), ReadError> {
        let role = self.columns.clock(self.said.rate);
        let Some(column) = self.numbers(role).cloned() else {
            return Err(self.report.fail("no column of time"));
        };
        let are_whole = column.iter().all(|v| v.fract() == 0.0);
        self.times = column;
        self.order_rows();
        self.time = match self.said.decided {
            Some(decided) => decided.time,
            None if self.said.is_order => 1.0,
            None => self.time_unit(role, are_whole)?,
        };
        // Numbers near zero keep all their digits.
        let factor = self.time;
        self.times.iter_mut().for_each(|time| *time *= factor);
        Ok(())
    }

    /// What one of the table's times is, seconds.
    fn time_unit(&self, role: Role, are_whole: bool) -> Result<f64, ReadError> {
        let named = self.factor(role).filter(|_| role == Role::Time);
        if let Some(factor) = named {
            return Ok(factor);
        }
        let pairs = self.pairs();
        let between = rounded(assembly::median(pairs.iter().map(|p| p.time).collect()));
        let name = self.column(role);
        let at = || self.report.at(format!("column {name}"));
        let guessed = guess::time_unit(between, are_whole);
        let counts = guessed == TimeUnit::Frames || role == Role::Frame && are_whole;
        let unit = match self.said.rate {
            Some(rate) if counts => return Ok(1.0 / rate),
            Some(_) => {
                return Err(at().fail(format!(
                    "`{name}` counts no frames: {between} apart; leave --rate out, or say that it does with --columns frame={name}"
                )));
            }
            None if role == Role::Frame => TimeUnit::Frames,
            None => guessed,
        };
        match (unit, guess::rate(&pairs)) {
            (TimeUnit::Seconds(factor), _) => {
                if factor < 1.0 {
                    let words = if factor < 1e-8 {
                        "nanoseconds"
                    } else if factor < 1e-5 {
                        "microseconds"
                    } else {
                        "milliseconds"
                    };
                    self.report.note(format!(
                        "`{name}` is in {words}: whole numbers, mostly {between} apart"
                    ));
                }
                Ok(factor)
            }
            // Whole seconds, where nothing contradicts them.
            (TimeUnit::Frames, None | Some(1.0)) if self.said.trust == Trust::Ours => Ok(1.0),
            (TimeUnit::Frames, Some(rate)) => {
                self.report.note(format!(
                    "`{name}` counts frames, {rate} a second: so speeds agree with places"
                ));
                Ok(1.0 / rate)
            }
            (TimeUnit::Frames, None) => Err(at().fail(format!(
                "whole numbers that are mostly {between} apart: frames? say how many a second with --rate HZ, or that they are seconds with --columns time={name}[s]"
            ))),
        }
    }

    /// Leaves out rows at a time that their track has already.
    fn once(&mut self) {
        let mut twice: Option<(u32, &str)> = None;
        let mut count = 0;
        for (track, rows) in self.order.iter_mut().enumerate() {
            rows.dedup_by(|row, kept| {
                let between = self.times[*row as usize] - self.times[*kept as usize];
                if between < SAME {
                    let name = &self.rows.tracks[track].name;
                    twice.get_or_insert((self.rows.lines[*row as usize], name));
                    count += 1;
                }
                between < SAME
            });
        }
        if let Some((line, name)) = twice {
            let at = self.report.row(line as usize, format!("track `{name}`"));
            at.warn(format!(
                "{count} rows are at a time that their track has already, this one first; the first row of each is used"
            ));
        }
    }

    /// When the first step is and how long one is, seconds. Rows that are sampled unevenly are put on even steps.
    pub(super) fn steps(&mut self, form: Option<HeadingForm>) -> Result<(f64, f64), ReadError> {
        self.once();
        let mut all = self.times.clone();
        all.sort_by(f64::total_cmp);
        all.dedup_by(|next, time| *next - *time < SAME);
        let (first, last) = (all[0], all[all.len() - 1]);
        let known = self.said.decided.map(|decided| decided.time_step);
        let found = known.map_or_else(|| Steps::from_times(&all).map(|found| found.time_step), Ok);
        // Each track may have a clock of its own.
        let between = self.order.iter().flat_map(|rows| {
            rows.windows(2)
                .map(|pair| self.times[pair[1] as usize] - self.times[pair[0] as usize])
        });
        let about = found.clone().unwrap_or_else(|_| typical(between.collect()));
        let likely = known.or(usual_step(about));
        let usual = likely.filter(|usual| (last - first) / usual <= MOST_STEPS);
        let time_step = match (usual, found) {
            (Some(usual), found) => {
                let mut steps = found.into_iter().chain([usual]);
                if let Some(time_step) = steps.find(|step| are_on_steps(&all, *step)) {
                    return Ok((first, time_step));
                }
                usual
            }
            (None, Ok(found)) => return Ok((first, found)),
            (None, Err(why)) => return Err(self.report.fail(why)),
        };
        // Steps are where they are in every part of the table.
        let start = (first / time_step).round() * time_step;
        self.resample(start, time_step, form);
        self.report.at("").warn(format!(
            "rows are not at equal times; places are interpolated at steps of {} s",
            rounded(time_step)
        ));
        Ok((start, time_step))
    }

    /// Puts each track on steps: places and numbers between those of its rows.
    fn resample(&mut self, start: f64, time_step: f64, form: Option<HeadingForm>) {
        let mut between: Vec<Between> = Vec::with_capacity(self.times.len());
        let mut tracks = Vec::with_capacity(self.times.len());
        for (track, rows) in (0..).zip(&self.order) {
            let time = |row: u32| self.times[row as usize];
            let mut next = i64::MIN;
            for rows in rows.chunk_by(|a, b| time(*b) - time(*a) <= GAP * time_step) {
                let at = |row: u32| (time(row) - start) / time_step;
                let (from, to) = (at(rows[0]), at(rows[rows.len() - 1]));
                let mut steps = (from - BEYOND).ceil() as i64..=(to + BEYOND).floor() as i64;
                if steps.is_empty() {
                    steps = from.round() as i64..=from.round() as i64;
                }
                let mut i = 0;
                for step in next.max(*steps.start())..=*steps.end() {
                    let then = start + step as f64 * time_step;
                    while i + 2 < rows.len() && time(rows[i + 1]) < then {
                        i += 1;
                    }
                    let pair = (rows[i], rows[(i + 1).min(rows.len() - 1)]);
                    let long = time(pair.1) - time(pair.0);
                    let part = if long > 0.0 {
                        ((then - time(pair.0)) / long).clamp(-0.5, 1.5)
                    } else {
                        0.0
                    };
                    between.push(Between { step, pair, part });
                    tracks.push(track);
                    next = step + 1;
                }
            }
        }
        let half = form.map_or(PI, |form| if form.degrees { 180.0 } else { PI });
        for (role, values) in &mut self.rows.numbers {
            let value = |of: &Between| {
                let (a, b) = (values[of.pair.0 as usize], values[of.pair.1 as usize]);
                match role {
                    Role::Heading => a + ((b - a + half).rem_euclid(2.0 * half) - half) * of.part,
                    _ => a + (b - a) * of.part,
                }
            };
            *values = between.iter().map(value).collect();
        }
        let place = |of: &Between| {
            let (a, b) = (
                self.places[of.pair.0 as usize],
                self.places[of.pair.1 as usize],
            );
            a + (b - a) * of.part
        };
        self.places = between.iter().map(place).collect();
        let line = |of: &Between| {
            let nearest = if of.part > 0.5 { of.pair.1 } else { of.pair.0 };
            self.rows.lines[nearest as usize]
        };
        self.rows.lines = between.iter().map(line).collect();
        let time = |of: &Between| start + of.step as f64 * time_step;
        self.times = between.iter().map(time).collect();
        self.rows.track = tracks;
        self.order_rows();
    }
}

/// A time as messages tell it.
fn rounded(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e6
}

/// A step between two rows.
struct Between {
    step: i64,
    pair: (u32, u32),
    /// Of the way from the first to the second.
    part: f64,
}

/// Whether times in order are on steps from the first one, as far as they are written so exactly.
fn are_on_steps(times: &[f64], time_step: f64) -> bool {
    let off = |time: &f64, grain: f64| {
        let parts = time / grain;
        (parts - parts.round()).abs() * grain
    };
    let grains = [1.0, 0.1, 0.01, 1e-3];
    let is_grain = |grain: &f64| times.iter().all(|time| off(time, *grain) < 2e-6);
    let rounding = grains.into_iter().find(is_grain).unwrap_or(0.0) / 2.0;
    times
        .iter()
        .all(|time| off(&(time - times[0]), time_step) <= rounding.max(SAME) + 1e-6)
}

/// The mean of times between rows, without gaps.
fn typical(mut between: Vec<f64>) -> f64 {
    let median = assembly::median(between.clone());
    between.retain(|time| (0.5..1.5).contains(&(time / median)));
    between.iter().sum::<f64>() / between.len().max(1) as f64
}

/// A usual length of steps that is about this long, seconds: of whole numbers of them a second, or of milliseconds.
fn usual_step(about: f64) -> Option<f64> {
    let rate = 1.0 / about;
    let whole = [10.0, 5.0, 1.0].map(|grain| (rate / grain).round() * grain);
    let usual = whole
        .into_iter()
        .find(|whole| (whole / rate - 1.0).abs() < 0.05);
    let step = usual.map_or((about * 1e3).round() / 1e3, |rate| 1.0 / rate);
    (step > 0.0 && step.is_finite()).then_some(step)
}

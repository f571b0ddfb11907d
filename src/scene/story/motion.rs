//! How one moves over some steps: turns, speeds, and where it slows down.

use std::ops::{Range, RangeInclusive};

use crate::scenario::Motion;
use nearmiss_base::geometry::{Vector, angle_between};

/// Who slows down with less does not brake, m/s².
const BRAKING: f64 = 1.0;

/// Decelerations are those over so many seconds: single steps are noise.
const OVER: f64 = 0.4;

/// Headings of who moves less than this in all are noise, metres.
const LEAST_WAY: f64 = 2.0;

/// Who gains or loses less does not speed up or brake, m/s.
const NOTABLE: f64 = 0.5;

/// Speeds are told to rise from here on, m/s.
const RISE: f64 = 1.5;

/// The share of a way by which places may differ from speeds.
const AS_RECORDED: f64 = 0.15;

/// Headings that change by more between two steps are those of a reversal or of noise, radians: 30°.
const JUMP: f64 = 0.524;

/// Motions at consecutive steps, of which some are told.
pub(super) struct Drive {
    all: Vec<(i64, Motion)>,
    /// Places of those that are told.
    told: Range<usize>,
    dt: f64,
}

/// The time in which one slows down or speeds up.
pub(super) struct Change {
    /// First and last step.
    pub steps: (i64, i64),
    /// Speeds there, m/s.
    pub speeds: (f64, f64),
    /// The most of slowing down, m/s².
    pub most: f64,
}

impl Drive {
    /// Those around `told` that follow each other without a gap.
    pub fn new(motion: impl Fn(i64) -> Option<Motion>, told: RangeInclusive<i64>, dt: f64) -> Self {
        let there = |step: i64| motion(step).map(|motion| (step, motion));
        let mut all: Vec<_> = (i64::MIN..*told.start()).rev().map_while(there).collect();
        all.reverse();
        let first = all.len();
        all.extend(told.clone().filter_map(there));
        let told_to = all.len();
        all.extend((told.end() + 1..).map_while(there));
        Self {
            all,
            told: first..told_to,
            dt,
        }
    }

    fn told(&self) -> &[(i64, Motion)] {
        &self.all[self.told.clone()]
    }

    fn speed(&self, place: usize) -> f64 {
        self.all[place].1.velocity.abs()
    }

    /// Whether the places around one are as far apart as its recorded speed says: simulators tell speeds along a lane, and
    /// the body cuts its curve.
    fn is_driven(&self, place: usize) -> bool {
        let from = &self.all[place.saturating_sub(1)];
        let to = &self.all[(place + 1).min(self.all.len() - 1)];
        let way = (to.1.pose.position - from.1.pose.position).norm();
        let told = self.speed(place) * (to.0 - from.0) as f64 * self.dt;
        (way - told).abs() <= AS_RECORDED * told.max(way)
    }

    fn change(&self, from: usize, to: usize, most: f64) -> Change {
        Change {
            steps: (self.all[from].0, self.all[to].0),
            speeds: (self.speed(from), self.speed(to)),
            most,
        }
    }

    /// From the first told place to the next that is at least a metre away.
    pub fn next_way(&self) -> Option<Vector> {
        let from = self.told().first()?.1.pose.position;
        let mut ways = self
            .told()
            .iter()
            .map(|(_, motion)| motion.pose.position - from);
        ways.find(|way| way.norm() >= 1.0)
    }

    /// The change of heading, radians, positive to the left; nothing of who hardly moves.
    pub fn turned(&self) -> Option<f64> {
        let mut way = 0.0;
        let mut turned = 0.0;
        for pair in self.told().windows(2) {
            let [(_, from), (_, to)] = pair else { continue };
            way += (to.pose.position - from.pose.position).norm();
            let by = angle_between(from.pose.heading, to.pose.heading);
            turned += if by.abs() > JUMP { 0.0 } else { by };
        }
        (way >= LEAST_WAY).then_some(turned)
    }

    /// Lowest and highest speed, m/s.
    pub fn speeds(&self) -> (f64, f64) {
        let speeds = self.told().iter().map(|(_, motion)| motion.velocity.abs());
        speeds.fold((f64::INFINITY, 0.0), |(low, high), speed| {
            (low.min(speed), high.max(speed))
        })
    }

    /// The deceleration around a place, m/s²: over [`OVER`], or as much of it as is recorded.
    fn slowing(&self, place: usize) -> Option<f64> {
        let half = ((OVER / 2.0 / self.dt).round() as usize).max(1);
        let from = self.all.get(place.saturating_sub(half))?;
        let to = self.all.get((place + half).min(self.all.len() - 1))?;
        let seconds = (to.0 - from.0) as f64 * self.dt;
        (seconds > 0.0).then(|| (from.1.velocity.abs() - to.1.velocity.abs()) / seconds)
    }

    /// The time around the hardest deceleration between two of the told steps in which one slows down all the time, however
    /// long before and after them.
    pub fn hardest_slowing(&self, between: RangeInclusive<i64>) -> Option<Change> {
        let all: Vec<f64> = { 0..self.all.len() }
            .filter_map(|place| self.slowing(place))
            .collect();
        let inside = |place: &usize| between.contains(&self.all[*place].0);
        let told = self
            .told
            .clone()
            .filter(|place| *place < all.len() && inside(place));
        let hardest = told.max_by(|a, b| all[*a].total_cmp(&all[*b]))?;
        let brakes = |place: &usize| all[*place] >= BRAKING;
        let first = (0..=hardest).rev().take_while(brakes).last()?;
        let last = (hardest..all.len()).take_while(brakes).last()?;
        let most = all[first..=last].iter().copied().fold(0.0, f64::max);
        let change = self.change(first, last, most);
        (change.speeds.0 - change.speeds.1 >= NOTABLE).then_some(change)
    }

    /// The largest rise of the speed between two of the told steps.
    pub fn rise(&self) -> Option<Change> {
        let mut lowest = self.told.start;
        let mut found: Option<(usize, usize)> = None;
        for place in self.told.clone() {
            // The last of those from which it rises.
            if self.speed(place) <= self.speed(lowest) {
                lowest = place;
            }
            let rise = |(from, to): (usize, usize)| self.speed(to) - self.speed(from);
            if rise((lowest, place)) > found.map_or(0.0, rise) {
                found = Some((lowest, place));
            }
        }
        let (from, to) = found?;
        if ![from, to].into_iter().all(|place| self.is_driven(place)) {
            return None;
        }
        let change = self.change(from, to, 0.0);
        (change.speeds.1 - change.speeds.0 >= RISE).then_some(change)
    }

    /// By how much the speed has fallen already where one begins to brake, without a break before, m/s.
    pub fn fallen_before(&self, step: i64) -> f64 {
        let Some(at) = self.all.iter().position(|(own, _)| *own == step) else {
            return 0.0;
        };
        let falls = |place: &usize| self.speed(*place) > self.speed(place + 1);
        let first = (0..at).rev().take_while(falls).last();
        first.map_or(0.0, |first| self.speed(first) - self.speed(at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_base::geometry::Pose;

    /// One that drives along x with these speeds, a tenth of a second each.
    fn drive(speeds: &[f64], told: RangeInclusive<i64>) -> Drive {
        let mut x = 0.0;
        let motions: Vec<Motion> = { speeds.iter() }
            .map(|velocity| {
                x += velocity * 0.1;
                Motion {
                    pose: Pose::new(x, 0.0, 0.0),
                    velocity: *velocity,
                    acceleration: 0.0,
                }
            })
            .collect();
        let at = |step: i64| motions.get(usize::try_from(step).ok()?).copied();
        Drive::new(at, told, 0.1)
    }

    #[test]
    fn the_most_of_a_braking_is_that_of_all_that_is_told_of_it() {
        // 8 m/s² for a second before what is told, then 2.
        let hard = (0..10).map(|i| 20.0 - 0.8 * f64::from(i));
        let soft = (0..10).map(|i| 12.0 - 0.2 * f64::from(i));
        let speeds: Vec<f64> = hard.chain(soft).collect();
        let drive = drive(&speeds, 14..=19);
        let change = drive.hardest_slowing(14..=19).expect("it brakes");
        assert!(change.speeds.0 > 18.0 && change.speeds.1 < 11.0);
        assert!((change.most - 8.0).abs() < 0.1, "{}", change.most);
    }

    #[test]
    fn a_rise_that_the_places_do_not_have_is_not_told() {
        let rising: Vec<f64> = (0..20).map(|i| 4.0 + 0.2 * f64::from(i)).collect();
        assert!(drive(&rising, 0..=19).rise().is_some());
        let mut lies = drive(&rising, 0..=19);
        for (step, motion) in &mut lies.all {
            motion.pose.position.x = 0.4 * *step as f64;
        }
        assert!(lies.rise().is_none());
    }
}

//! How one moves over some steps: turns, speeds, and where it slows down.

use std::ops::{Range, RangeInclusive};

use super::{SLOWED, STANDING};
use crate::scenario::Motion;
use nearmiss_base::geometry::{Vector, angle_between};

/// Who slows down with less does not brake, m/s².
const BRAKING: f64 = 1.0;

/// Decelerations are those over so many seconds: single steps are noise.
const OVER: f64 = 0.4;

/// Headings of who moves less than this in all are noise, metres.
const LEAST_WAY: f64 = 2.0;

/// Who gains or loses less does not speed up or brake, m/s.
pub(super) const NOTABLE: f64 = 0.5;

/// The share of a way by which places may differ from speeds.
const AS_RECORDED: f64 = 0.15;

/// Headings that change by more between two steps are those of a reversal or of noise, where the way does not turn as they
/// do, radians: 30°.
const JUMP: f64 = 0.524;

/// Who turns by more between two steps goes back, radians: 135°.
const BACK: f64 = 2.356;

/// A braking goes on after a break of so many seconds.
const BREAK: f64 = 1.0;

/// Motions at consecutive steps, of which some are told.
pub(super) struct Drive {
    all: Vec<(i64, Motion)>,
    /// Places of those that are told.
    told: Range<usize>,
    dt: f64,
}

/// The time in which one slows down or speeds up.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Change {
    /// First and last step.
    pub steps: (i64, i64),
    /// Speeds there, m/s.
    pub speeds: (f64, f64),
    /// The most of slowing down, m/s².
    pub most: f64,
}

impl Change {
    /// How much faster it gets, m/s.
    pub fn gain(&self) -> f64 {
        self.speeds.1 - self.speeds.0
    }
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
        let seconds = (to.0 - from.0) as f64 * self.dt;
        let told = self.speed(place) * seconds;
        // Who starts has gone a bit by the next step.
        (way - told).abs() <= (AS_RECORDED * told.max(way)).max(STANDING * seconds)
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
        self.way(self.told.start, self.told.clone())
    }

    /// From a place to the next of others that is at least a metre away.
    fn way(&self, from: usize, others: impl Iterator<Item = usize>) -> Option<Vector> {
        let position = |place: usize| self.all.get(place).map(|(_, motion)| motion.pose.position);
        let from = position(from)?;
        let mut ways = others.filter_map(|place| Some(position(place)? - from));
        ways.find(|way| way.norm() >= 1.0)
    }

    /// Whether the way turns by about so much between a place and the next.
    fn way_turns(&self, place: usize, by: f64) -> bool {
        let before = self.way(place, (0..place).rev());
        let after = self.way(place + 1, place + 2..self.all.len());
        before.zip(after).is_some_and(|(before, after)| {
            let turned = angle_between((-before.y).atan2(-before.x), after.y.atan2(after.x));
            by.abs() < BACK && (turned - by).abs() < JUMP
        })
    }

    /// The change of heading, radians, positive to the left; nothing of who hardly moves.
    pub fn turned(&self) -> Option<f64> {
        let mut way = 0.0;
        let mut turned = 0.0;
        for (place, pair) in self.told.clone().zip(self.told().windows(2)) {
            let [(_, from), (_, to)] = pair else { continue };
            way += (to.pose.position - from.pose.position).norm();
            let by = angle_between(from.pose.heading, to.pose.heading);
            if by.abs() <= JUMP || self.way_turns(place, by) {
                turned += by;
            }
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

    /// The times in which one slows down, however long before and after what is told; with short breaks, in which it does
    /// not get faster.
    pub fn brakings(&self) -> Vec<Change> {
        let all: Vec<f64> = { 0..self.all.len() }
            .filter_map(|place| self.slowing(place))
            .collect();
        let mut found: Vec<(usize, usize)> = Vec::new();
        for place in (0..all.len()).filter(|place| all[*place] >= BRAKING) {
            match found.last_mut() {
                Some((first, last)) if self.goes_on(*first, *last, place) => *last = place,
                _ => found.push((place, place)),
            }
        }
        let changes = found.into_iter().map(|(first, last)| {
            let most = all[first..=last].iter().copied().fold(0.0, f64::max);
            // What lasts less than that for which it is measured is more than it.
            self.change(first, last, most.max(self.mean(first, last)))
        });
        changes.filter(|change| -change.gain() >= NOTABLE).collect()
    }

    /// The mean deceleration from one place to another, m/s².
    fn mean(&self, from: usize, to: usize) -> f64 {
        let seconds = (self.all[to].0 - self.all[from].0) as f64 * self.dt;
        if seconds > 0.0 {
            (self.speed(from) - self.speed(to)) / seconds
        } else {
            0.0
        }
    }

    /// Whether a braking goes on at a place where one brakes again.
    fn goes_on(&self, first: usize, last: usize, again: usize) -> bool {
        let seconds = (self.all[again].0 - self.all[last].0) as f64 * self.dt;
        let faster = (last..=again).any(|place| self.speed(place) > self.speed(last) + SLOWED);
        again == last + 1 || !faster && seconds <= BREAK && self.mean(first, again) >= BRAKING
    }

    /// The largest rise of the speed between two of the told steps without a fall in it.
    pub fn rise(&self) -> Option<Change> {
        self.largest(|place| self.speed(place))
    }

    /// The largest fall of the speed between two of the told steps without a rise in it.
    pub fn fall(&self) -> Option<Change> {
        self.largest(|place| -self.speed(place))
    }

    /// The largest rise of a value between two of the told steps without a notable fall in it.
    fn largest(&self, value: impl Fn(usize) -> f64) -> Option<Change> {
        let (mut from, mut to) = (self.told.start, self.told.start);
        let mut found: Option<(usize, usize)> = None;
        for place in self.told.clone() {
            // The last of those from which it rises.
            if value(place) <= value(from) || value(to) - value(place) >= NOTABLE {
                (from, to) = (place, place);
            }
            if value(place) > value(to) {
                to = place;
            }
            if value(to) - value(from) > found.map_or(0.0, |(from, to)| value(to) - value(from)) {
                found = Some((from, to));
            }
        }
        let (from, to) = found?;
        let is_driven = [from, to].into_iter().all(|place| self.is_driven(place));
        is_driven.then(|| self.change(from, to, 0.0))
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
        let [change] = drive.brakings()[..] else {
            panic!("one braking");
        };
        assert!(change.speeds.0 > 18.0 && change.speeds.1 < 11.0);
        assert!((change.most - 8.0).abs() < 0.1, "{}", change.most);
    }

    #[test]
    fn the_most_of_a_short_braking_is_not_below_its_mean() {
        let mut speeds = vec![2.0; 10];
        speeds.extend([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let [change] = drive(&speeds, 0..=15).brakings()[..] else {
            panic!("one braking");
        };
        let seconds = (change.steps.1 - change.steps.0) as f64 * 0.1;
        assert!(change.most >= -change.gain() / seconds - 1e-9);
        assert!((change.most - 5.0).abs() < 1e-9, "{}", change.most);
    }

    #[test]
    fn a_braking_goes_on_after_a_break_and_not_after_speeding_up() {
        let mut speeds: Vec<f64> = (0..10).map(|i| 20.0 - 0.3 * f64::from(i)).collect();
        speeds.extend([17.3; 6]);
        speeds.extend((0..10).map(|i| 17.3 - 0.3 * f64::from(i)));
        assert_eq!(drive(&speeds, 0..=25).brakings().len(), 1);
        for speed in &mut speeds[16..] {
            *speed += 1.0;
        }
        assert_eq!(drive(&speeds, 0..=25).brakings().len(), 2);
    }

    #[test]
    fn a_rise_ends_where_the_speed_falls() {
        let rising = (0..15).map(|i| 9.0 + 0.2 * f64::from(i));
        let again = (0..15).map(|i| 10.8 + 0.2 * f64::from(i));
        let speeds: Vec<f64> = rising.chain(again).collect();
        let rise = drive(&speeds, 0..=29).rise().expect("it gets faster");
        assert!(rise.steps == (0, 14) || rise.steps == (15, 29));
    }

    #[test]
    fn a_corner_within_a_step_is_a_turn() {
        let mut corner = drive(&[10.0; 30], 0..=29);
        for (step, motion) in corner.all.iter_mut().skip(15) {
            motion.pose = Pose::new(15.0, (*step - 14) as f64, std::f64::consts::FRAC_PI_2);
        }
        assert!(corner.turned().is_some_and(|turned| turned > 1.5));
        // A reversal is none.
        for (step, motion) in corner.all.iter_mut().skip(15) {
            motion.pose = Pose::new(29.0 - *step as f64, 0.0, std::f64::consts::PI);
        }
        assert!(corner.turned().is_some_and(|turned| turned.abs() < 0.1));
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

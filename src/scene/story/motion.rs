//! How one moves over some steps: turns, speeds, and where it slows down.

use crate::scenario::Motion;
use nearmiss_base::geometry::angle_between;

/// Who slows down with less does not brake, m/s².
const BRAKING: f64 = 1.0;

/// Decelerations are those over so many seconds: single steps are noise.
const OVER: f64 = 0.4;

/// Headings of who moves less than this in all are noise, metres.
const LEAST_WAY: f64 = 2.0;

/// Motions at consecutive steps.
pub(super) struct Drive {
    all: Vec<(i64, Motion)>,
    dt: f64,
}

/// The time in which one slows down all the time.
pub(super) struct Slowing {
    /// First and last step.
    pub steps: (i64, i64),
    /// Speeds there, m/s.
    pub speeds: (f64, f64),
    /// The most, m/s².
    pub most: f64,
}

impl Drive {
    pub fn new(all: impl Iterator<Item = (i64, Motion)>, dt: f64) -> Self {
        let all = all.collect();
        Self { all, dt }
    }

    /// The change of heading, radians, positive to the left; nothing of who hardly moves.
    pub fn turned(&self) -> Option<f64> {
        let mut way = 0.0;
        let mut turned = 0.0;
        for pair in self.all.windows(2) {
            let [(_, from), (_, to)] = pair else { continue };
            way += (to.pose.position - from.pose.position).norm();
            turned += angle_between(from.pose.heading, to.pose.heading);
        }
        (way >= LEAST_WAY).then_some(turned)
    }

    /// Lowest and highest speed, m/s.
    pub fn speeds(&self) -> (f64, f64) {
        let speeds = self.all.iter().map(|(_, motion)| motion.velocity.abs());
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

    /// The time around the hardest deceleration in which one slows down all the time.
    pub fn hardest_slowing(&self) -> Option<Slowing> {
        let all: Vec<f64> = { 0..self.all.len() }
            .filter_map(|place| self.slowing(place))
            .collect();
        let (hardest, most) =
            { all.iter().copied().enumerate() }.max_by(|a, b| a.1.total_cmp(&b.1))?;
        if most < BRAKING {
            return None;
        }
        let brakes = |place: &usize| all[*place] >= BRAKING;
        let first = (0..=hardest).rev().take_while(brakes).last()?;
        let last = (hardest..all.len()).take_while(brakes).last()?;
        let at = |place: usize| (self.all[place].0, self.all[place].1.velocity.abs());
        let ((from, from_speed), (to, to_speed)) = (at(first), at(last));
        Some(Slowing {
            steps: (from, to),
            speeds: (from_speed, to_speed),
            most,
        })
    }
}

//! Lower bounds of what candidates cost, before any of their steps is worked out, and candidates in that order.
//!
//! In the frame of the path, of curvature k, the squared speed of a motion with offset d is (ṡ(1 − kd))² + ḋ², and its
//! acceleration along the path s̈(1 − kd) − k′ṡ²d − 2kṡḋ (Werling et al. 2010, appendix I). With bounds on |d| and |ḋ|
//! that hold for all changes of the offset, each step of a profile has a least cost of speed, rules and acceleration;
//! the offset costs the same whatever the profile, where it is planned over time.

use std::ops::Range;

use super::Planner;
use super::evaluate::{self, Candidate, Cost, Judge, RULES, Rejection};
use super::profile::{Lateral, Start};
use super::settings::Level;
use super::state::{Moved, Station};
use super::traffic::CloseTraffic;

/// Bounds are that much lower than what they are worked out as, so that rounding does not matter.
const ROUNDING: f64 = 1.0 - 1e-9;

/// A change of the offset, for all profiles of a level.
#[derive(Debug, Clone, Copy)]
pub(super) struct LateralChange {
    pub lateral: Lateral,
    /// Weighted cost of its jerk.
    jerk: f64,
}

/// The changes of the offset that a level samples: all over time, or all over arc length.
#[derive(Debug, Default)]
pub(super) struct LateralChanges {
    pub list: Vec<LateralChange>,
    /// For each of them, the least weighted cost of what is left after each step.
    rest: Vec<f64>,
    /// For each of them, the offset after each step with its derivatives by time; empty over arc length.
    offsets: Vec<[f64; 3]>,
    /// Bounds of all offsets (m), and of their change: m/s over time, metres by metre over arc length.
    widest: f64,
    steepest: f64,
    by_length: bool,
}

impl LateralChanges {
    /// Becomes those of a level.
    pub fn lay(
        &mut self,
        judge: &Judge<'_>,
        level: Level,
        start: &Start,
        along: [f64; 3],
        by_length: bool,
    ) {
        self.by_length = by_length;
        (self.widest, self.steepest) = (0.0, 0.0);
        self.list.clear();
        self.rest.clear();
        self.offsets.clear();
        let (settings, steps) = (judge.settings, judge.steps);
        let weight = settings.weights.offset * ROUNDING / steps as f64;
        for target in level.offsets(settings.sampling.widest, start.by_length[0]) {
            for change in level.changes(settings.horizon) {
                let lateral = if by_length {
                    // As long as it would be at the present speed: braking does not turn sharper.
                    Lateral::over_length(start, target, along[0], along[1] * change)
                } else {
                    Lateral::over_time(start, target, change)
                };
                let [widest, steepest] = lateral.bounds();
                self.widest = self.widest.max(widest);
                self.steepest = self.steepest.max(steepest);
                let jerk = judge.lateral_jerk(&lateral, along[1]);
                self.list.push(LateralChange { lateral, jerk });
                let first = self.rest.len();
                self.rest.resize(first + steps + 1, 0.0);
                let moments = (0..=steps).map(|step| step as f64 * judge.dt);
                self.offsets
                    .extend(moments.filter_map(|t| lateral.by_time(t)));
                if !by_length {
                    for step in (1..=steps).rev() {
                        let [d, _, _] = self.offsets[first + step];
                        self.rest[first + step - 1] = self.rest[first + step] + weight * d * d;
                    }
                }
            }
        }
    }

    /// The offset of a way after each step (m) with its derivatives by time; empty where it changes over arc length.
    pub fn offsets(&self, way: usize, steps: usize) -> &[[f64; 3]] {
        let from = way * (steps + 1);
        self.offsets.get(from..=from + steps).unwrap_or_default()
    }

    /// The least weighted cost of what a way has left after each step.
    pub fn rest(&self, way: usize, steps: usize) -> &[f64] {
        &self.rest[way * (steps + 1)..][..=steps]
    }
}

impl Judge<'_> {
    /// The least weighted cost of speed, rules and acceleration that any of the `ways` has left after each step of a profile.
    pub fn least(&self, stations: &[Station], ways: &LateralChanges, rest: &mut Vec<f64>) {
        let mean = ROUNDING / self.steps as f64;
        let (speed, acceleration) = (
            self.settings.weights.speed * mean,
            self.settings.weights.acceleration * mean,
        );
        let first = rest.len();
        rest.resize(first + stations.len(), 0.0);
        for (step, at) in stations.iter().enumerate().skip(1).rev() {
            let [_, s1, s2] = at.s;
            let across = if ways.by_length {
                ways.steepest * s1
            } else {
                ways.steepest
            };
            let bend = at.curvature.abs();
            let (near, far) = (1.0 - bend * ways.widest, 1.0 + bend * ways.widest);
            let (slowest, fastest) = (s1 * near.max(0.0), (s1 * far).hypot(across));
            let off = (slowest - at.wanted).max(at.wanted - fastest).max(0.0);
            let drift = at.curvature_rate.abs() * ways.widest * s1 * s1 + 2.0 * bend * s1 * across;
            let along = (s2.abs() * near - drift).max(0.0);
            let too_fast = match slowest - at.allowed {
                excess if excess > 2.0 * evaluate::ROUNDING => excess,
                _ => 0.0,
            };
            rest[first + step - 1] = rest[first + step]
                + speed * off * off
                + acceleration * along * along
                + RULES * mean * too_fast;
        }
    }

    /// The least that a candidate can cost: its profile's jerk costs `along`, and its profile and its way have this
    /// left at the start.
    pub fn least_cost(&self, along: f64, way: &LateralChange, left: [f64; 2]) -> f64 {
        ROUNDING * (along + way.jerk) + left[0] + left[1]
    }
}

impl Planner<'_> {
    /// Follows the candidates of these profiles, those that may cost least first, until all others cost more than the
    /// best one.
    pub(super) fn follow_best(&mut self, profiles: Range<usize>, judge: &Judge<'_>, now: &Moved) {
        let steps = judge.steps;
        let first = profiles.start;
        self.rest.clear();
        self.least.clear();
        for place in profiles {
            let profile = &self.profiles[place];
            let stations = &self.stations[place * (steps + 1)..][..=steps];
            let ways = &self.ways[usize::from(profile.slowest < self.settings.low_speed)];
            let start = self.rest.len();
            judge.least(stations, ways, &mut self.rest);
            let jerk = judge.along_jerk(profile);
            for (i, way) in ways.list.iter().enumerate() {
                let left = [self.rest[start], ways.rest(i, steps)[0]];
                let least = judge.least_cost(jerk, way, left);
                self.least.push((least, self.candidates.len(), i));
                // Where it is not followed, it is because of what it costs.
                self.candidates.push(Candidate {
                    profile: place,
                    lateral: way.lateral,
                    cost: Cost::default(),
                    rejected: Some((0, Rejection::Costlier)),
                });
            }
        }
        self.least
            .sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // The next candidate is of any profile: lists of each would not pay.
        let close = CloseTraffic::default();
        for n in 0..self.least.len() {
            let (least, index, way) = self.least[n];
            let most = self.best.map(|(cost, _)| cost);
            if self.cancel.is_asked() || most.is_some_and(|most| least > most) {
                return;
            }
            let Candidate {
                profile: place,
                lateral,
                ..
            } = self.candidates[index];
            let profile = &self.profiles[place];
            let stations = &self.stations[place * (steps + 1)..][..=steps];
            let ways = &self.ways[usize::from(profile.slowest < self.settings.low_speed)];
            let rest = [
                &self.rest[(place - first) * (steps + 1)..][..=steps],
                ways.rest(way, steps),
            ];
            let lateral = (lateral, ways.offsets(way, steps));
            self.candidates[index] =
                judge.follow(now, place, profile, (stations, &close), lateral, rest, most);
            self.ask_road(index);
        }
    }

    /// Asks the road of a candidate that would be the best one so far whether it is that; of equal ones the first is.
    pub(super) fn ask_road(&mut self, index: usize) {
        let candidate = self.candidates[index];
        let cost = candidate.cost.total();
        let is_best = self
            .best
            .is_none_or(|(least, at)| cost < least || cost == least && index < at);
        if candidate.rejected.is_none() && is_best {
            match self.leaves_road(&candidate) {
                Some(step) => self.candidates[index].rejected = Some((step, Rejection::OffRoad)),
                None => self.best = Some((cost, index)),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::super::evaluate::Allowed;
    use super::super::pace::{Pace, StopAhead};
    use super::super::profile::Profile;
    use super::super::state::Moved;
    use super::super::traffic::CloseTraffic;
    use super::super::{CurvatureSpeedLimit, Polynomial, Settings, Traffic, VehicleState};
    use super::*;
    use nearmiss_base::geometry::{Point, Pose, ReferencePath};

    /// On a winding path, from a state beside it: no candidate costs less than its bound, and many bounds are above what
    /// the best one costs, so that those need not be followed.
    #[test]
    fn no_candidate_costs_less_than_its_bound() {
        let line = (0..80).map(|i| {
            let x = f64::from(i) * 2.0;
            Point::new(x, 6.0 * (x / 25.0).sin())
        });
        let path = ReferencePath::new(line).unwrap();
        let bends = CurvatureSpeedLimit::new(&path);
        let settings = Settings::default();
        let traffic = Traffic::new(40);
        let judge = Judge {
            settings: &settings,
            allowed: Allowed::new(settings.limits(), 0.1),
            traffic: &traffic,
            dt: 0.1,
            steps: 40,
        };
        let pace = |now: f64| Pace {
            wanted: 9.0,
            bends: &bends,
            legal: None,
            stop: Some(StopAhead::new(60.0, 10.0, now)),
            centre: 1.4,
            now,
        };
        let nearby = CloseTraffic::default();
        let start = Start {
            by_time: [0.6, 0.2, -0.1],
            by_length: [0.6, 0.03, -0.01],
        };
        let mut checked = 0;
        for (from, by_length) in [([10.0, 8.0, 0.5], false), ([10.0, 3.0, -0.5], true)] {
            let at = path.at(from[0]);
            let now = Moved::from_state(&VehicleState {
                rear: Pose::new(at.position.x, at.position.y, at.heading),
                velocity: from[1],
                acceleration: from[2],
                curvature: at.curvature,
            });
            let (mut best, mut bounds) = (f64::INFINITY, Vec::new());
            let level = Level::new(&settings.sampling, 0);
            let mut ways = LateralChanges::default();
            ways.lay(&judge, level, &start, from, by_length);
            for end in [1.0, 3.0, 6.0, 9.0, 12.0] {
                for duration in [1.5, 3.0, 4.0] {
                    let along = Polynomial::quartic(from, [end, 0.0], duration);
                    let mut stations = Vec::new();
                    let laid = Profile::new(along, duration, 0.0).lay(
                        &path,
                        &pace(from[1]),
                        40,
                        0.1,
                        &mut stations,
                    );
                    let Some(profile) = laid else { continue };
                    let mut rest = Vec::new();
                    judge.least(&stations, &ways, &mut rest);
                    for (i, way) in ways.list.iter().enumerate() {
                        let left = [rest[0], ways.rest(i, 40)[0]];
                        let least = judge.least_cost(judge.along_jerk(&profile), way, left);
                        bounds.push(least);
                        let all = [rest.as_slice(), ways.rest(i, 40)];
                        let found = judge.follow(
                            &now,
                            0,
                            &profile,
                            (&stations, &nearby),
                            (way.lateral, &[]),
                            all,
                            None,
                        );
                        if found.rejected.is_none() {
                            let cost = found.cost.total();
                            assert!(least <= cost, "{least} for {cost}");
                            checked += 1;
                            best = best.min(cost);
                            // Nothing that costs no more than it does is given up on its way.
                            let most = Some(cost);
                            let again = judge.follow(
                                &now,
                                0,
                                &profile,
                                (&stations, &nearby),
                                (way.lateral, ways.offsets(i, 40)),
                                all,
                                most,
                            );
                            assert_eq!(again, found);
                        }
                    }
                }
            }
            let above = bounds.iter().filter(|bound| **bound > best).count();
            assert!(4 * above > bounds.len(), "{above} of {}", bounds.len());
        }
        assert!(checked > 100, "{checked}");
    }
}

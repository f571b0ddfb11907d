//! Evaluates one sampled trajectory step by step: feasibility, collisions, cost, or why it was rejected.

use super::profile::{Lateral, Profile, by_length};
use super::state::{Moved, Station, state};
use super::traffic::{CloseTraffic, EgoBox, Occupied, Traffic};
use super::{Limit, Limits, Settings};

/// Shared checks for all candidates of a plan.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judge<'a> {
    pub settings: &'a Settings,
    pub allowed: Allowed,
    pub traffic: &'a Traffic,
    /// Seconds between two steps.
    pub dt: f64,
    pub steps: usize,
}

/// Bodies farther than this cost nothing, metres.
pub(super) const CLEAR: f64 = 2.0;

/// The margin around bodies grows to its whole within this time, so that an ego that starts closer can get away,
/// seconds.
const EASING: f64 = 1.0;

/// What a m/s above what the rules allow costs: more than any comfort.
pub(super) const RULES: f64 = 100.0;

/// Differences below this are rounding.
pub(super) const ROUNDING: f64 = 1e-6;

/// Terms that are summed up over the steps.
#[derive(Debug, Default)]
struct Sums {
    acceleration: f64,
    speed: f64,
    offset: f64,
    clearance: f64,
    following: f64,
    risk: f64,
    rules: f64,
}

impl Judge<'_> {
    /// Follows a candidate from `now`, the state it starts from; no farther than to where it is sure to cost more than
    /// `most`. What it costs at least after each step is the sum of both of `rest`; nothing where they are empty. Its
    /// offsets are worked out where they are not given.
    #[allow(clippy::too_many_arguments)]
    pub fn follow(
        &self,
        now: &Moved,
        place: usize,
        profile: &Profile,
        (stations, close): (&[Station], &CloseTraffic),
        (lateral, offsets): (Lateral, &[[f64; 3]]),
        rest: [&[f64]; 2],
        most: Option<f64>,
    ) -> Candidate {
        let effort = self.effort(profile, &lateral, now.velocity);
        let mut sums = Sums::default();
        let mut before = *now;
        let mut rejected = None;
        for (step, at) in stations.iter().enumerate().skip(1) {
            let offset = match offsets.get(step) {
                Some(known) => by_length(*known, at.slower, at.s[2]),
                None => lateral.at(step as f64 * self.dt, at.s),
            };
            let Some(moved) = state(at, offset) else {
                rejected = Some((step, Rejection::InsideCurve));
                break;
            };
            if let Some(limit) = self.allowed.broken(&before, &moved) {
                rejected = Some((step, Rejection::Limit(limit)));
                break;
            }
            let close = close.at(step, moved.velocity, offset[0]);
            let others = close.unwrap_or_else(|| self.traffic.at(step));
            if let Some(id) = self.meet(step, others, &moved, &mut sums) {
                rejected = Some((step, Rejection::Contact(id)));
                break;
            }
            let across = moved.velocity * moved.velocity * moved.curvature;
            sums.acceleration += moved.acceleration * moved.acceleration + across * across;
            sums.speed += (moved.velocity - at.wanted).powi(2);
            if moved.velocity > at.allowed + ROUNDING {
                sums.rules += moved.velocity - at.allowed;
            }
            sums.offset += offset[0] * offset[0];
            before = moved;
            if let Some(most) = most {
                let [along, across] = rest.map(|rest| rest.get(step).copied().unwrap_or(0.0));
                if self.cost(&sums, effort).total() + along + across > most {
                    rejected = Some((step, Rejection::Costlier));
                    break;
                }
            }
        }
        Candidate {
            profile: place,
            lateral,
            cost: self.cost(&sums, effort),
            rejected,
        }
    }

    /// The cost of the jerks.
    fn effort(&self, profile: &Profile, lateral: &Lateral, speed: f64) -> f64 {
        self.along_jerk(profile) + self.lateral_jerk(lateral, speed)
    }

    /// The cost of the jerk along the path.
    pub fn along_jerk(&self, profile: &Profile) -> f64 {
        let horizon = self.steps as f64 * self.dt;
        let end = profile.duration.min(horizon + profile.elapsed);
        let along =
            profile.along.squared_jerk(end) - profile.along.squared_jerk(profile.elapsed.min(end));
        self.settings.weights.longitudinal_jerk * along / horizon
    }

    /// The cost of the jerk across the path, at about `speed` m/s.
    pub fn lateral_jerk(&self, lateral: &Lateral, speed: f64) -> f64 {
        let horizon = self.steps as f64 * self.dt;
        self.settings.weights.lateral_jerk * lateral.squared_jerk(horizon, speed)
    }

    /// The cost with these sums, and so much for jerks.
    fn cost(&self, sums: &Sums, jerk: f64) -> Cost {
        let weights = &self.settings.weights;
        let mean = 1.0 / self.steps as f64;
        Cost {
            jerk,
            acceleration: weights.acceleration * sums.acceleration * mean,
            speed: weights.speed * sums.speed * mean,
            offset: weights.offset * sums.offset * mean,
            clearance: weights.clearance * sums.clearance * mean,
            following: weights.following * sums.following * mean,
            risk: weights.risk * sums.risk * mean,
            rules: RULES * sums.rules * mean,
        }
    }

    /// Adds the cost of proximity to these obstacles at a step; returns the obstacle it would touch.
    #[inline]
    fn meet(
        &self,
        step: usize,
        others: &[Occupied],
        moved: &Moved,
        sums: &mut Sums,
    ) -> Option<i64> {
        let own = self.own(moved);
        let time = step as f64 * self.dt;
        let margin = self.settings.margin * (time / EASING).min(1.0);
        let stopping = self.settings.stopping(moved.velocity);
        for other in others {
            let (dx, dy) = (other.x - own.x, other.y - own.y);
            let near = self.allowed.reach + other.reach + CLEAR;
            let left = dy * own.cos - dx * own.sin;
            let forward = dx * own.cos + dy * own.sin;
            // Most are too far beside, behind or ahead to cost anything: neither near nor in the way.
            if left.abs() >= near || forward <= -near || forward >= stopping + near {
                continue;
            }
            let squared = dx * dx + dy * dy;
            if squared >= (stopping + near) * (stopping + near) {
                continue;
            }
            if squared < near * near {
                let body = &self.traffic.bodies[other.body];
                let gap = other.separation(&own);
                if gap < margin && body.avoided {
                    return Some(body.id);
                }
                if gap < 0.0 {
                    sums.risk += body.likelihood * moved.velocity * moved.velocity;
                }
                let close = 1.0 - (gap / CLEAR).clamp(0.0, 1.0);
                sums.clearance += body.likelihood * close * close;
            }
            // An obstacle that is in front by less than it takes to stop, should it stop as well.
            if forward > 0.0 {
                sums.following += self.missing(&own, other, forward, left, stopping);
            }
        }
        None
    }

    fn own(&self, moved: &Moved) -> EgoBox {
        let limits = &self.allowed.limits;
        EgoBox {
            x: moved.x + moved.cos * limits.rear_to_centre,
            y: moved.y + moved.sin * limits.rear_to_centre,
            cos: moved.cos,
            sin: moved.sin,
            half_length: limits.length / 2.0,
            half_width: limits.width / 2.0,
        }
    }

    /// The share of the wanted gap that is missing behind an obstacle `forward` and `left` metres away, squared; one
    /// stops within `stopping` metres.
    #[inline]
    fn missing(
        &self,
        own: &EgoBox,
        other: &Occupied,
        forward: f64,
        left: f64,
        stopping: f64,
    ) -> f64 {
        let cos = own.cos * other.cos + own.sin * other.sin;
        let sin = (own.cos * other.sin - own.sin * other.cos).abs();
        let wide = other.half_width * cos.abs() + other.half_length * sin + own.half_width;
        if left.abs() >= wide {
            return 0.0;
        }
        let gap =
            forward - own.half_length - other.half_length * cos.abs() - other.half_width * sin;
        let ahead = (other.velocity * cos).max(0.0);
        let wanted = stopping - ahead * ahead / (2.0 * self.settings.braking);
        if wanted <= gap || wanted <= 0.0 {
            return 0.0;
        }
        let share = ((wanted - gap) / wanted).min(1.0);
        self.traffic.bodies[other.body].likelihood * share * share
    }
}

/// The limits with what follows from them, worked out once for all candidates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Allowed {
    pub limits: Limits,
    /// Half of the body's diagonal, metres.
    reach: f64,
    /// The tightest curvature, 1/m.
    tightest: f64,
    /// Tangent of the largest change of the steering angle within a step.
    turned: f64,
    /// Seconds between two steps, and its inverse.
    dt: f64,
    rate: f64,
}

impl Allowed {
    pub fn new(limits: Limits, dt: f64) -> Self {
        Self {
            limits,
            reach: (limits.length / 2.0).hypot(limits.width / 2.0),
            tightest: limits.curvature(),
            turned: (limits.steering_rate * dt).tan(),
            dt,
            rate: dt.recip(),
        }
    }

    /// The limit that is broken at `after`, a step after `before`.
    #[inline]
    fn broken(&self, before: &Moved, after: &Moved) -> Option<Limit> {
        let limits = &self.limits;
        let (v, a, k) = (after.velocity, after.acceleration, after.curvature);
        if v < -ROUNDING || v > limits.speed {
            return Some(Limit::Speed);
        }
        // Between the two steps the mean acceleration is what the inputs have to give.
        let mean = (v - before.velocity) * self.rate;
        let forward = a.max(mean);
        if a.min(mean) < -limits.acceleration || forward > 0.0 && forward > limits.forward(v) {
            return Some(Limit::Acceleration);
        }
        if k.abs() > self.tightest {
            return Some(Limit::Curvature);
        }
        // tan(b − a) of the steering angles, so that no arc tangent is needed.
        let (tan0, tan1) = (before.curvature * limits.wheelbase, k * limits.wheelbase);
        if (tan1 - tan0).abs() > self.turned * (1.0 + tan0 * tan1).max(0.0) {
            return Some(Limit::CurvatureRate);
        }
        let turn = (before.cos * after.sin - before.sin * after.cos).abs();
        let fastest = v.max(before.velocity).max(0.0);
        if turn > fastest * self.tightest * self.dt + ROUNDING {
            return Some(Limit::YawRate);
        }
        let across = (v * v * k).abs().max(fastest * turn * self.rate);
        let along = a.abs().max(mean.abs());
        if across * across + along * along > limits.acceleration * limits.acceleration {
            return Some(Limit::Friction);
        }
        None
    }
}

/// Why a candidate is not driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rejection {
    /// The vehicle cannot do it.
    Limit(Limit),
    /// It is inside the path's curve, where no offset is defined.
    InsideCurve,
    /// The body would leave the road.
    OffRoad,
    /// It would touch the predicted body of this obstacle.
    Contact(i64),
    /// Another one costs less than this one up to here; see [`Planner::only_best`](super::Planner::only_best).
    Costlier,
}

impl Rejection {
    /// In a word or two, the same for all obstacles.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Limit(limit) => limit.name(),
            Self::InsideCurve => "inside the curve",
            Self::OffRoad => "off the road",
            Self::Contact(_) => "contact",
            Self::Costlier => "costlier",
        }
    }
}

/// The terms of the cost, each with its weight already.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cost {
    /// Jerk along and across the path.
    pub jerk: f64,
    /// Acceleration.
    pub acceleration: f64,
    /// Difference from the wanted speed.
    pub speed: f64,
    /// Distance to the path.
    pub offset: f64,
    /// Closeness to others.
    pub clearance: f64,
    /// Too close behind an obstacle.
    pub following: f64,
    /// Contacts that are possible, not likely.
    pub risk: f64,
    /// Faster than the rules of the road allow.
    pub rules: f64,
}

impl Cost {
    /// All terms with their names, in the order of the fields.
    #[must_use]
    pub fn terms(&self) -> [(&'static str, f64); 8] {
        [
            ("jerk", self.jerk),
            ("acceleration", self.acceleration),
            ("speed", self.speed),
            ("offset", self.offset),
            ("clearance", self.clearance),
            ("following", self.following),
            ("risk", self.risk),
            ("rules", self.rules),
        ]
    }

    /// Their sum.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.terms().iter().map(|(_, value)| value).sum()
    }
}

/// A sampled trajectory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Which of the plan's profiles it follows.
    pub(super) profile: usize,
    pub(super) lateral: Lateral,
    /// What it costs, up to where it was rejected.
    pub cost: Cost,
    /// Step (from now) and reason of its end; `None` for one that can be driven.
    pub rejected: Option<(usize, Rejection)>,
}

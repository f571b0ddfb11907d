//! How fast to be where: what is wanted, what the rules of the road allow, and where the goal is.

use nearmiss_base::geometry::{Footprint, Pose, ReferencePath};
use nearmiss_scene::scenario::{Destination, PlanningProblem, Position, Route, Scenario};
use nearmiss_scene::traffic_rules::{Regulations, Rule};

use super::CurvatureSpeedLimit;

/// The legal speed at each metre of a path, with room to slow down to it.
#[derive(Debug, Clone, PartialEq)]
pub struct LegalSpeed {
    /// m/s at 0, 1, 2, … m, with comfortable braking before.
    gentle: Vec<f64>,
    /// The same with firm braking.
    firm: Vec<f64>,
}

/// Deceleration towards a slower stretch or a line that one wants, and that is the latest, m/s².
const GENTLE: f64 = 1.2;
const FIRM: f64 = 2.5;

/// Deceleration of one who starts too fast, m/s².
const SLOWING: f64 = 2.0;

/// Where no limit is, m/s.
const NONE: f64 = 1e3;

impl LegalSpeed {
    /// Those along a path of so many metres; `None` where nothing limits them.
    #[must_use]
    pub fn new(regulations: &Regulations, length: f64) -> Option<Self> {
        if regulations.limits.is_empty() {
            return None;
        }
        let metres = length.ceil().clamp(1.0, 1e5) as usize;
        let limit = |metre: usize| {
            let (from, to) = (metre as f64, metre as f64 + 1.0);
            let here = regulations
                .limits
                .iter()
                .filter(|l| l.from < to && from < l.to);
            here.map(|l| l.speed).fold(NONE, f64::min)
        };
        let raw: Vec<f64> = (0..=metres).map(limit).collect();
        let slowed = |braking: f64| {
            let mut speeds = raw.clone();
            for s in (0..metres).rev() {
                let reached = (speeds[s + 1].powi(2) + 2.0 * braking).sqrt();
                speeds[s] = speeds[s].min(reached);
            }
            speeds
        };
        Some(Self {
            gentle: slowed(GENTLE),
            firm: slowed(FIRM),
        })
    }

    fn at(speeds: &[f64], s: f64) -> f64 {
        let place = s.max(0.0) as usize;
        speeds[place.min(speeds.len() - 1)]
    }

    fn gentle(&self, s: f64) -> f64 {
        Self::at(&self.gentle, s)
    }

    /// The speed (m/s) that is wanted at arc length `s` (m) by a vehicle that has `now` m/s: comfortably to what is
    /// allowed here and a second ahead.
    #[must_use]
    pub fn ahead(&self, s: f64, now: f64) -> f64 {
        let limit = self.gentle(s).min(self.gentle(s + now));
        limit.max(now - SLOWING)
    }
}

/// A rule that asks for a stop ahead, or for waiting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hold {
    /// The rule.
    pub rule: Rule,
    /// From the front of the vehicle to where it is to stand, metres.
    pub distance: f64,
}

/// Where to stand, and how to slow down to it.
#[derive(Debug, Clone, Copy)]
pub(super) struct StopAhead {
    /// Arc length of the rear axle, metres.
    pub s: f64,
    gentle: f64,
    firm: f64,
}

/// Of the braking that is needed, so much more is taken: none gets harder on the way.
const RESERVE: (f64, f64) = (1.05, 1.15);

impl StopAhead {
    /// To stand with the rear axle at arc length `s` (m), from `along` (m) and `velocity` (m/s).
    pub fn new(s: f64, along: f64, velocity: f64) -> Self {
        let needed = velocity * velocity / (2.0 * (s - along).max(NEAREST));
        Self {
            s,
            gentle: GENTLE.max(RESERVE.0 * needed),
            firm: FIRM.max(RESERVE.1 * needed),
        }
    }

    fn speed(&self, s: f64, braking: f64) -> f64 {
        (2.0 * braking * (self.s - s).max(0.0)).sqrt()
    }
}

/// Distances below this do not make braking harder, metres.
const NEAREST: f64 = 0.2;

/// What is wanted and allowed in one cycle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pace<'a> {
    /// m/s, where neither bends nor rules decide.
    pub wanted: f64,
    pub bends: &'a CurvatureSpeedLimit,
    pub legal: Option<&'a LegalSpeed>,
    pub stop: Option<StopAhead>,
    /// From the rear axle to the centre of the body, metres: limits hold for the centre.
    pub centre: f64,
    /// m/s now.
    pub now: f64,
}

impl Pace<'_> {
    /// The speed that is wanted at arc length `s` (m) in `t` seconds, m/s.
    pub fn wanted_at(&self, s: f64, t: f64) -> f64 {
        let mut wanted = self.wanted.min(self.bends.speed(s));
        if let Some(legal) = self.legal {
            wanted = wanted.min(legal.gentle(s + self.centre).max(self.now - SLOWING * t));
        }
        match self.stop {
            Some(stop) => wanted.min(stop.speed(s, stop.gentle)),
            None => wanted,
        }
    }

    /// The speed that the rules allow at arc length `s` (m) in `t` seconds, m/s: one who is too fast slows down firmly.
    pub fn allowed_at(&self, s: f64, t: f64) -> f64 {
        let mut allowed = NONE;
        if let Some(legal) = self.legal {
            let limit = LegalSpeed::at(&legal.firm, s + self.centre);
            allowed = limit.max(self.now - FIRM * t);
        }
        match self.stop {
            Some(stop) => allowed.min(stop.speed(s, stop.firm)),
            None => allowed,
        }
    }
}

/// The stretch of the path on which the goal is reached, and the step until which it has to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// Beginning of the stretch, metres along the path; with a margin.
    pub from: f64,
    /// End of the stretch, metres along the path; with a margin.
    pub to: f64,
    /// The last time step that counts.
    pub step: i64,
}

/// The distance between places along the path that are asked whether they are in the goal, metres.
const SPACING: f64 = 0.5;

/// How far inside the goal is aimed at, where it is long enough, and what is kept from its end, metres.
const INSIDE: f64 = 8.0;
const MARGIN: f64 = 3.0;

impl Arrival {
    /// Of the goal that `route` leads to; nothing where no goal says where.
    #[must_use]
    pub fn new(
        scenario: &Scenario,
        problem: &PlanningProblem,
        route: &Route,
        path: &ReferencePath,
    ) -> Option<Self> {
        let Destination::Goal(place) = route.destination else {
            return None;
        };
        let goal = problem.goals.get(place)?;
        let regions: Vec<Footprint> = goal
            .positions
            .iter()
            .filter_map(|p| match p {
                Position::Region(shape) => Footprint::new(shape.clone()).ok(),
                _ => None,
            })
            .collect();
        let lanelets = goal.lanelets();
        let origin = Pose::new(0.0, 0.0, 0.0);
        let inside = |s: f64| {
            let p = path.pose_at(s).position;
            regions.iter().any(|r| r.at(origin).holds(&p))
                || !lanelets.is_empty()
                    && scenario
                        .network
                        .lanelets_at(&p)
                        .iter()
                        .any(|id| lanelets.contains(id))
        };
        let last = path.project(&route.path.at(route.end).position).ok()?.s;
        let start = path.project(&route.path.at(route.start).position).ok()?.s;
        // The route ends where the goal is reached at the latest; on the smooth path that may be just outside.
        let ends = [0.0, 0.25, SPACING, 2.0 * SPACING, 4.0 * SPACING].map(|back| last - back);
        let to = ends.into_iter().find(|&s| inside(s)).unwrap_or(last);
        let mut from = to;
        while from - SPACING > start && inside(from - SPACING) {
            from -= SPACING;
        }
        let third = (to - from) / 3.0;
        Some(Self {
            from: from + INSIDE.min(third),
            to: to - MARGIN.min(third),
            step: goal.time.to,
        })
    }
}

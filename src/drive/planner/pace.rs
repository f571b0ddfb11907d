//! How fast to be where: what is wanted, what the rules of the road allow or ask for in a cycle, and where the goal is.
//!
//! Lights are obeyed as they show now: what they will show is not known to a driver. Right of way is decided by when
//! others reach the area of conflict at their present speed (R-IN3 to R-IN5, with a reserve on the times of the rules);
//! from a standstill that asks for gaps of about 6 s, like the critical headways of the Highway Capacity Manual (6.2 s to
//! 7.1 s from a minor road).

use nearmiss_base::geometry::{Footprint, Point, Pose, ReferencePath, angle_between};
use nearmiss_scene::scenario::{
    Destination, PlanningProblem, Position, Route, Scenario, SignalColor,
};
use nearmiss_scene::traffic_rules::{
    Passage, Regulations, Rival, Rule, STANDING, STOP_SECONDS, YIELD_AFTER, YIELD_BEFORE,
};

use super::{CurvatureSpeedLimit, Limits, Planner, RuleMode, Traffic, VehicleState};

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
const BRAKING_RESERVE: (f64, f64) = (1.05, 1.15);

impl StopAhead {
    /// To stand with the rear axle at arc length `s` (m), from `along` (m) and `velocity` (m/s).
    pub fn new(s: f64, along: f64, velocity: f64) -> Self {
        let needed = velocity * velocity / (2.0 * (s - along).max(NEAREST));
        Self {
            s,
            gentle: GENTLE.max(BRAKING_RESERVE.0 * needed),
            firm: FIRM.max(BRAKING_RESERVE.1 * needed),
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

/// Which stop signs were obeyed, from cycle to cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct StopMemory {
    /// The line at which the vehicle stands, by place, and the first step there.
    standing: Option<(usize, i64)>,
    /// The last line at which it has stood long enough.
    served: Option<usize>,
}

/// The front stands this far before a line, metres.
const BEFORE_LINE: f64 = 0.8;

/// A vehicle that stands farther before a line has not stopped at it, metres.
const AT_LINE: f64 = 2.0;

/// Braking for a red light or a stop sign, for a yellow light, and for others, at most, m/s²: an ego that could
/// not stop with less goes on. That for yellow is of the ITE (10 ft/s²).
const AT_RED: f64 = 4.5;

const AT_YELLOW: f64 = 3.0;

const FOR_OTHERS: f64 = 4.0;

/// A vehicle that slows down already may brake harder by this: no decision is taken back by rounding, m/s².
const DECIDED: f64 = 1.5;

/// A vehicle that is slower than this (m/s) with its front over a line by no more than so many metres stays there.
const CREEPING: f64 = 1.5;

const OVER: f64 = 1.5;

/// What is added to the times of the rules, seconds: others may be faster than now.
const TIME_RESERVE: f64 = 0.7;

/// Acceleration across an intersection, m/s², and the least speed that is reached there, m/s.
const ACROSS: f64 = 1.5;

const LEAST_SPEED: f64 = 3.0;

/// A vehicle whose middle is farther beside that of a lane is not on it, metres; nor is one that points elsewhere.
const MAX_LATERAL_OFFSET: f64 = 1.75;

const HEADING_TOLERANCE: f64 = std::f64::consts::FRAC_PI_4;

/// One that is so far beside it later leaves the lane, metres.
const LEAVES: f64 = 2.5;

/// Slower others wait themselves, m/s.
const WAITING_SPEED: f64 = 0.5;

/// The vehicle along its way.
#[derive(Debug, Clone, Copy)]
struct Own {
    front: f64,
    length: f64,
    velocity: f64,
    /// It slows down already.
    slows: bool,
    /// The speed that it reaches if it goes on.
    reached: f64,
}

impl Own {
    /// Whether it can stand `BEFORE_LINE` before arc length `s` with no more than this braking, m/s².
    fn can_stop(&self, s: f64, braking: f64) -> bool {
        let most = braking + if self.slows { DECIDED } else { 0.0 };
        let room = s - self.front;
        if room < 0.0 {
            return self.creeps();
        }
        self.velocity * self.velocity <= 2.0 * most * room || self.velocity < STANDING
    }

    /// Seconds until it is `distance` metres farther, if it goes on.
    fn time(&self, distance: f64) -> f64 {
        let (v, most) = (self.velocity, self.reached);
        if distance <= 0.0 {
            return 0.0;
        }
        let gaining = (most * most - v * v) / (2.0 * ACROSS);
        if distance <= gaining {
            return ((v * v + 2.0 * ACROSS * distance).sqrt() - v) / ACROSS;
        }
        (most - v) / ACROSS + (distance - gaining) / most
    }

    /// Whether it is slow enough to stay a little beyond a line rather than go on.
    fn creeps(&self) -> bool {
        self.velocity < CREEPING
    }

    /// Whether a line concerns it: it is ahead, or just behind the front of a vehicle that creeps.
    fn is_before(&self, line: f64) -> bool {
        let least = if self.creeps() { -OVER } else { 0.0 };
        (least..self.looks()).contains(&(line - self.front))
    }

    /// How far ahead lines concern it, metres.
    fn looks(&self) -> f64 {
        self.velocity * self.velocity / 3.0 + 2.0 * self.velocity + 20.0
    }
}

impl<'a> Planner<'a> {
    /// The speed (m/s) that is wanted with the body's centre at `centre` (m) where speeds are limited, and the limits.
    pub(super) fn legal(
        &self,
        wanted: f64,
        centre: f64,
        now: f64,
    ) -> (f64, Option<&'a LegalSpeed>) {
        let legal = self.guide.legal.as_deref();
        let Some(legal) = legal.filter(|_| self.settings.rules == RuleMode::Obey) else {
            return (wanted, None);
        };
        (wanted.min(legal.ahead(centre, now)), Some(legal))
    }

    /// Where the rules ask to stop in this cycle; what is asked for is remembered.
    pub(super) fn stop_ahead(
        &mut self,
        now: &VehicleState,
        along: f64,
        step: i64,
        traffic: &Traffic,
        wanted: f64,
    ) -> Option<StopAhead> {
        if self.settings.rules == RuleMode::Off {
            return None;
        }
        let (hold, stop) = self.obligation(now, along, step, traffic, wanted)?;
        self.hold = Some(hold);
        Some(stop)
    }

    /// What the rules ask for at `step`, with the rear axle at arc length `along`; `wanted` m/s are driven otherwise.
    fn obligation(
        &mut self,
        now: &VehicleState,
        along: f64,
        step: i64,
        traffic: &Traffic,
        wanted: f64,
    ) -> Option<(Hold, StopAhead)> {
        let regulations = std::sync::Arc::clone(&self.guide.regulations);
        let nose = nose(&self.limits);
        let own = Own {
            front: along + nose,
            length: self.limits.length,
            velocity: now.velocity.max(0.0),
            slows: now.acceleration < -0.5,
            reached: wanted.max(now.velocity).max(LEAST_SPEED),
        };
        self.remember_stops(&regulations, &own, step);
        let lights = lights(&regulations, &own, step);
        let signs = self.stop_signs(&regulations, &own);
        let others = regulations.passages.iter().filter_map(|passage| {
            let lit = passage.lights && regulations.is_lit(passage, step);
            for_others(passage, lit, &own, traffic)
        });
        let all = lights.into_iter().chain(signs).chain(others);
        let (line, rule) = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let s = (line - BEFORE_LINE - nose).max(along);
        let hold = Hold {
            rule,
            distance: s - along,
        };
        Some((hold, StopAhead::new(s, along, own.velocity)))
    }

    fn remember_stops(&mut self, regulations: &Regulations, own: &Own, step: i64) {
        let at = |line: f64| (-OVER..=AT_LINE).contains(&(line - own.front));
        let mut lines = regulations.stops.iter();
        let here = lines.position(|line| at(line.s));
        let memory = &mut self.stops;
        let Some(place) = here.filter(|_| own.velocity < STANDING) else {
            memory.standing = None;
            return;
        };
        match memory.standing {
            Some((known, since)) if known == place => {
                let stood = step.saturating_sub(since) as f64 * self.dt;
                if stood + 1e-6 >= STOP_SECONDS {
                    memory.served = Some(place);
                }
            }
            _ => memory.standing = Some((place, step)),
        }
    }

    fn stop_signs(&self, regulations: &Regulations, own: &Own) -> Option<(f64, Rule)> {
        let lines = regulations.stops.iter().enumerate();
        let ahead = { lines }.find(|(place, line)| {
            self.stops.served.is_none_or(|served| *place > served)
                && own.is_before(line.s)
                && own.can_stop(line.s, AT_RED)
        });
        ahead.map(|(_, line)| (line.s, Rule::StopSign))
    }
}

/// From the rear axle to the front of the body, metres.
fn nose(limits: &Limits) -> f64 {
    limits.rear_to_centre + limits.length / 2.0
}

fn lights(regulations: &Regulations, own: &Own, step: i64) -> Option<(f64, Rule)> {
    let lines = regulations.lights.iter();
    let mut ahead = lines.filter(|line| own.is_before(line.s));
    let stops = ahead.find(|line| match line.color_at(step) {
        SignalColor::Red | SignalColor::RedYellow => own.can_stop(line.s, AT_RED),
        SignalColor::Yellow => own.can_stop(line.s, AT_YELLOW),
        SignalColor::Green | SignalColor::Inactive => false,
    });
    stops.map(|line| (line.s, Rule::RedLight))
}

/// Where to wait for those that go first at an intersection.
fn for_others(passage: &Passage, lit: bool, own: &Own, traffic: &Traffic) -> Option<(f64, Rule)> {
    let gone = passage.until < own.front - own.length;
    if gone || passage.line - own.front > own.looks() {
        return None;
    }
    let waits = passage.rivals.iter().filter_map(|rival| {
        let rule = rival.rule(lit)?;
        // A left turn is waited for inside; so is what comes after the line was passed.
        let before = rival.conflict.own.0 - BEFORE_LINE;
        let line = match rule {
            Rule::LeftTurn => before.max(passage.line),
            _ if own.front <= passage.line => passage.line,
            _ => before,
        };
        let may_wait = line >= own.front && own.can_stop(line, FOR_OTHERS);
        (may_wait && comes_first(rival, own, traffic)).then_some((line, rule))
    });
    waits.min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Whether a vehicle on a rival's lane is in the area of conflict when the ego would be, or shortly before or after.
fn comes_first(rival: &Rival, own: &Own, traffic: &Traffic) -> bool {
    let (enters, leaves) = (
        own.time(rival.conflict.own.0 - own.front),
        own.time(rival.conflict.own.1 - own.front + own.length),
    );
    let (from, to) = rival.conflict.other;
    traffic.at(0).iter().any(|other| {
        let body = &traffic.bodies[other.body];
        if !body.avoided || other.velocity < WAITING_SPEED {
            return false;
        }
        let on = rival.centre.project(&Point::new(other.x, other.y));
        let lane = rival.centre.pose_at(on.s).heading;
        let turn = angle_between(lane, other.sin.atan2(other.cos));
        if on.d.abs() > MAX_LATERAL_OFFSET || turn.abs() > HEADING_TOLERANCE {
            return false;
        }
        let (front, rear) = (on.s + other.half_length, on.s - other.half_length);
        let arrives = (from - front).max(0.0) / other.velocity;
        let gone = (to - rear) / other.velocity;
        gone > 0.0
            && arrives < leaves + YIELD_BEFORE + TIME_RESERVE
            && gone + YIELD_AFTER + TIME_RESERVE > enters
            && !turns_off(rival, other.body, on.s, traffic)
    })
}

/// Steps between two looks at a predicted way.
const STRIDE: usize = 5;

/// Whether the predicted way of a body leaves a rival's lane before the area of conflict.
fn turns_off(rival: &Rival, body: usize, from: f64, traffic: &Traffic) -> bool {
    if from > rival.inside + LEAVES {
        return false;
    }
    let steps = (STRIDE..=traffic.horizon()).step_by(STRIDE);
    { steps }.any(|step| {
        let there = traffic.at(step).iter().find(|other| other.body == body);
        there.is_some_and(|other| {
            let on = rival.centre.project(&Point::new(other.x, other.y));
            on.d.abs() > LEAVES && on.s < rival.conflict.other.1
        })
    })
}

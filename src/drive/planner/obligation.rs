//! What the rules of the road ask for in a cycle: to stop at a line, or to let others go first.
//!
//! Lights are obeyed as they show now: what they will show is not known to a driver. Right of way is decided by when
//! others reach the area of conflict at their present speed (R-IN3 to R-IN5, with a reserve on the times of the rules);
//! from a standstill that asks for gaps of about 6 s, like the critical headways of the Highway Capacity Manual (6.2 s to
//! 7.1 s from a minor road).

use super::pace::StopAhead;
use super::{Hold, LegalSpeed, Limits, Planner, RuleMode, Traffic, VehicleState};
use nearmiss_base::geometry::{Point, angle_between};
use nearmiss_scene::scenario::SignalColor;
use nearmiss_scene::traffic_rules::{
    Passage, Regulations, Rival, Rule, STANDING, STOP_SECONDS, YIELD_AFTER, YIELD_BEFORE,
};

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
const RESERVE: f64 = 0.7;

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
            && arrives < leaves + YIELD_BEFORE + RESERVE
            && gone + YIELD_AFTER + RESERVE > enters
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

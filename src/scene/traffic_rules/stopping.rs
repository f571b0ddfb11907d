//! R-IN1 and R-IN2: stop signs and lights, and the lines at which a way may have to stop.

use super::junction::Turn;
use super::{EgoAlong, Finding, Rule, STANDING, STOP_SECONDS, Violation};
use crate::scenario::{SignalColor, TrafficDirection, TrafficLight};

/// A vehicle that stands farther before a line than this does not stand at it, metres.
pub(super) const AT_LINE: f64 = 2.5;

/// Braking that is comfortable enough to stop at yellow, m/s² (ITE, Traffic Engineering Handbook: 10 ft/s²).
pub(super) const COMFORTABLE: f64 = 3.0;

/// An ego that never comes nearer to a line than this has no occasion to stop there, metres.
const OCCASION: f64 = 30.0;

pub(super) fn findings(ego: &EgoAlong<'_>) -> [Finding; 2] {
    [stop_signs(ego), lights(ego)]
}

fn stop_signs(ego: &EgoAlong<'_>) -> Finding {
    let network = &ego.scene.scenario.network;
    if network.signs.is_empty() {
        return Finding::undecided(Rule::StopSign, "the map has no signs");
    }
    let lines = ego.regulations.stops.iter();
    let lines: Vec<_> = lines
        .filter(|line| ego.comes_near(line.s, OCCASION))
        .collect();
    if lines.is_empty() {
        return Finding::not_applicable(Rule::StopSign, "no stop sign on the way");
    }
    let violations = lines.iter().filter_map(|line| not_stopped(ego, line));
    Finding::applied(Rule::StopSign, violations.collect())
}

/// The seconds that are missing to a stop at a line that is passed.
fn not_stopped(ego: &EgoAlong<'_>, line: &StopSignLine) -> Option<Violation> {
    let place = ego.passes(line.s)?;
    let (mut longest, mut now) = (0_usize, 0_usize);
    for moment in &ego.moments[..place] {
        let stands = moment.velocity.abs() < STANDING && moment.front > line.s - AT_LINE;
        now = if stands { now + 1 } else { 0 };
        longest = longest.max(now);
    }
    // Steps between moments, not moments.
    let stood = longest.saturating_sub(1) as f64 * ego.dt();
    let moment = &ego.moments[place];
    (stood + ROUNDING < STOP_SECONDS).then_some(Violation {
        from: moment.step,
        until: moment.step,
        at: moment.position,
        lanelet: Some(line.lanelet),
        obstacle: None,
        amount: STOP_SECONDS - stood,
    })
}

/// Rounding of sums of steps, seconds.
const ROUNDING: f64 = 1e-6;

fn lights(ego: &EgoAlong<'_>) -> Finding {
    if ego.scene.scenario.network.lights.is_empty() {
        return Finding::not_applicable(Rule::RedLight, "the map has no lights");
    }
    let lines = ego.regulations.lights.iter();
    let lines: Vec<_> = lines
        .filter(|line| ego.comes_near(line.s, OCCASION))
        .collect();
    if lines.is_empty() {
        return Finding::not_applicable(Rule::RedLight, "no light on the way");
    }
    let lit = |line: &&LightLine| {
        let mut moments = ego.moments.iter();
        moments.any(|m| line.color_at(m.step) != SignalColor::Inactive)
    };
    if !lines.iter().any(lit) {
        return Finding::not_applicable(Rule::RedLight, "the lights on the way are off");
    }
    let violations = lines.iter().filter_map(|line| crossed(ego, line));
    Finding::applied(Rule::RedLight, violations.collect())
}

fn crossed(ego: &EgoAlong<'_>, line: &LightLine) -> Option<Violation> {
    let place = ego.passes(line.s)?;
    let moment = &ego.moments[place];
    let broken = match line.color_at(moment.step) {
        SignalColor::Red | SignalColor::RedYellow => true,
        SignalColor::Yellow => could_have_stopped(ego, line, place),
        SignalColor::Green | SignalColor::Inactive => false,
    };
    broken.then_some(Violation {
        from: moment.step,
        until: moment.step,
        at: moment.position,
        lanelet: Some(line.lanelet),
        obstacle: None,
        amount: moment.velocity,
    })
}

/// Whether a comfortable stop was possible when the lights became yellow.
fn could_have_stopped(ego: &EgoAlong<'_>, line: &LightLine, place: usize) -> bool {
    let before = line.changed_before(ego.moments[place].step);
    let since = before.map_or(i64::MIN, |step| step.saturating_add(1));
    let Some(then) = ego.moments[..=place].iter().find(|m| m.step >= since) else {
        return false;
    };
    let room = line.s - then.front;
    room > 0.0 && then.velocity * then.velocity / (2.0 * room) <= COMFORTABLE
}

/// Where lights hold on a way.
#[derive(Debug, Clone, PartialEq)]
pub struct LightLine {
    /// Arc length of the stop line, metres.
    pub s: f64,
    /// The lanelet on which they hold.
    pub lanelet: i64,
    /// The lights.
    pub lights: Vec<TrafficLight>,
}

/// Where a stop sign holds on a way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopSignLine {
    /// Arc length of the stop line, metres.
    pub s: f64,
    /// The lanelet on which it holds.
    pub lanelet: i64,
}

impl LightLine {
    /// What the lights show at a step: the strictest of several.
    #[must_use]
    pub fn color_at(&self, step: i64) -> SignalColor {
        let colors = self.lights.iter().map(|light| light.color_at(step));
        colors
            .min_by_key(|color| strictness(*color))
            .unwrap_or(SignalColor::Inactive)
    }

    /// The last step until which the lights have shown another colour than at `step`; `None` where they always show it.
    #[must_use]
    pub fn changed_before(&self, step: i64) -> Option<i64> {
        let color = self.color_at(step);
        let cycle: i64 = self.lights.iter().fold(0, |longest, light| {
            let phases = light.cycle.iter().map(|phase| phase.duration.max(0));
            longest.max(phases.fold(0, i64::saturating_add))
        });
        let look_back = 1..=cycle.min(MAX_STEPS_BACK);
        { look_back }
            .map(|back| step.saturating_sub(back))
            .find(|earlier| self.color_at(*earlier) != color)
    }
}

/// Steps that are looked back for a change of colour.
const MAX_STEPS_BACK: i64 = 100_000;

fn strictness(color: SignalColor) -> u8 {
    match color {
        SignalColor::Red => 0,
        SignalColor::RedYellow => 1,
        SignalColor::Yellow => 2,
        SignalColor::Green => 3,
        SignalColor::Inactive => 4,
    }
}

/// Whether a light is for vehicles that turn so; for all where the turn is not known.
pub(super) fn is_for(light: &TrafficLight, turn: Option<Turn>) -> bool {
    let (Some(direction), Some(turn)) = (light.direction, turn) else {
        return true;
    };
    match direction {
        TrafficDirection::All => true,
        TrafficDirection::Right => turn == Turn::Right,
        TrafficDirection::Straight => turn == Turn::Straight,
        TrafficDirection::Left => turn == Turn::Left,
        TrafficDirection::LeftStraight => turn != Turn::Right,
        TrafficDirection::StraightRight => turn != Turn::Left,
        TrafficDirection::LeftRight => turn != Turn::Straight,
    }
}

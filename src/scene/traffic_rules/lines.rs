//! Lines at which a way may have to stop: those of lights and of stop signs.

use super::junction::Turn;
use crate::scenario::{SignalColor, TrafficDirection, TrafficLight};

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
        let look_back = 1..=cycle.min(LONGEST);
        { look_back }
            .map(|back| step.saturating_sub(back))
            .find(|earlier| self.color_at(*earlier) != color)
    }
}

/// Steps that are looked back for a change of colour.
const LONGEST: i64 = 100_000;

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

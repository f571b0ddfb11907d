//! Traffic lights of a Waymo scenario: what each shows at every step.

use std::collections::BTreeMap;

use super::Recorded;
use crate::commonroad::ReadError;
use crate::recordings::report::Report;
use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{LightPhase, SignalColor, TrafficDirection, TrafficLight};

/// A light by the lane that it is for, as the data set counts lanes.
pub struct LaneLight {
    pub lane: i64,
    pub stop_point: Option<Point>,
    pub cycle: Vec<LightPhase>,
}

/// The colour of a state of a signal.
fn color(state: i32) -> SignalColor {
    match state {
        // Arrows say the same to those they are for; a flashing light is told by its colour.
        1 | 4 | 7 => SignalColor::Red,
        2 | 5 | 8 => SignalColor::Yellow,
        3 | 6 => SignalColor::Green,
        _ => SignalColor::Inactive,
    }
}

/// The lights, by lane.
pub fn read(report: &Report, recorded: &Recorded) -> Result<Vec<LaneLight>, ReadError> {
    let steps = recorded.timestamps_seconds.len();
    let mut lanes: BTreeMap<i64, (Option<Point>, Vec<SignalColor>)> = BTreeMap::new();
    for (step, states) in recorded.dynamic_map_states.iter().take(steps).enumerate() {
        for state in &states.lane_states {
            let Some(lane) = state.lane else { continue };
            let (point, colors) = lanes.entry(lane).or_default();
            if let (None, Some(stop)) = (&point, &state.stop_point) {
                let at = report.at(format!("dynamic_map_states[{step}]"));
                *point = Some(at.point(stop.x.unwrap_or(0.0), stop.y.unwrap_or(0.0))?);
            }
            // Where it is not said, it is not known.
            colors.resize(step, SignalColor::Inactive);
            colors.push(color(state.state.unwrap_or(0)));
        }
    }
    let lights = lanes.into_iter().map(|(lane, (stop_point, mut colors))| {
        colors.resize(steps, SignalColor::Inactive);
        let mut cycle: Vec<LightPhase> = Vec::new();
        for color in colors {
            match cycle.last_mut() {
                Some(phase) if phase.color == color => phase.duration += 1,
                _ => cycle.push(LightPhase { duration: 1, color }),
            }
        }
        LaneLight {
            lane,
            stop_point,
            cycle,
        }
    });
    Ok(lights.collect())
}

impl LaneLight {
    /// The light, under an id of the scenario.
    pub fn light(&self, id: i64) -> TrafficLight {
        TrafficLight {
            id,
            position: self.stop_point,
            active: true,
            direction: Some(TrafficDirection::All),
            offset: 0,
            cycle: self.cycle.clone(),
        }
    }
}

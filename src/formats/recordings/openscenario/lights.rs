//! Phases of traffic lights, from the controllers of a road network.

use std::collections::HashMap;

use crate::commonroad::ReadError;
use crate::recordings::opendrive::tree::Node;
use nearmiss_scene::scenario::{LightPhase, SignalColor, TrafficLight};

/// No phase is longer, steps.
const LONGEST: f64 = 1e6;

/// When controllers begin.
#[derive(Clone, Copy)]
pub struct Clock {
    /// Seconds between two steps.
    pub dt: f64,
    /// The step of time 0.
    pub origin: i64,
}

/// Sets the phases of lights whose signals (by their ids) a controller switches.
pub fn phases(
    root: &Node,
    clock: Clock,
    ids: &HashMap<String, i64>,
    lights: &mut [TrafficLight],
) -> Result<(), ReadError> {
    let Some(signals) = root.at(&["RoadNetwork", "TrafficSignals"]) else {
        return Ok(());
    };
    for controller in signals.all("TrafficSignalController") {
        let mut cycles: HashMap<i64, Vec<LightPhase>> = HashMap::new();
        for phase in controller.all("Phase") {
            let steps = (phase.needed_number("duration")? / clock.dt).round();
            if !(0.0..=LONGEST).contains(&steps) {
                return Err(phase.fail(format!("a phase of {steps} steps")));
            }
            for state in phase.all("TrafficSignalState") {
                let Some(id) = ids.get(state.needed("trafficSignalId")?) else {
                    continue;
                };
                cycles.entry(*id).or_default().push(LightPhase {
                    duration: steps as i64,
                    color: color(state.text("state").unwrap_or_default()),
                });
            }
        }
        for light in lights.iter_mut() {
            if let Some(cycle) = cycles.remove(&light.id) {
                light.active = cycle.iter().any(|p| p.color != SignalColor::Inactive);
                light.cycle = cycle;
                light.offset = clock.origin;
            }
        }
    }
    Ok(())
}

/// The colour of a state: lamps from the top, or a word.
fn color(state: &str) -> SignalColor {
    let lamps: Vec<bool> = state.split(';').map(|lamp| lamp.trim() == "on").collect();
    match (&lamps[..], state) {
        ([true, true, false], _) => SignalColor::RedYellow,
        ([true, false, false], _) | (_, "red") => SignalColor::Red,
        ([false, true, false], _) | (_, "yellow") => SignalColor::Yellow,
        ([false, false, true], _) | (_, "green") => SignalColor::Green,
        _ => SignalColor::Inactive,
    }
}

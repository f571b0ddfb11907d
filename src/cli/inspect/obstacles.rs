//! Obstacles as JSON: type, states, occupancy sets and signals.

use serde_json::{Map, Value, json};

use super::document::all;
use super::shapes::shape;
use super::states::{initial_state, state};
use crate::scenario::{Obstacle, Occupancy, Prediction, SignalState};

pub fn obstacle(obstacle: &Obstacle) -> Value {
    let (prediction, occupancies) = match &obstacle.prediction {
        Prediction::None => (None, &[][..]),
        Prediction::Trajectory(_) => (Some("trajectory"), &[][..]),
        Prediction::Occupancies(occupancies) => (Some("occupancy_set"), occupancies.as_slice()),
    };
    let first = obstacle.initial.iter().map(initial_state);
    let later = obstacle.states().skip(first.len()).map(state);
    let states: Vec<Value> = first.chain(later).collect();
    json!({
        "id": obstacle.id,
        "role": obstacle.role,
        "type": obstacle.kind,
        "shape": obstacle.footprint.as_ref().map(|f| shape(f.shape())),
        "prediction": prediction,
        "states": states,
        "occupancies": occupancies.len(),
        "occupancy_set": all(occupancies, occupancy),
        "signal_series": all(&obstacle.signals, signals),
    })
}

fn occupancy(occupancy: &Occupancy) -> Value {
    json!({
        "time_step": [occupancy.time.from, occupancy.time.to],
        "shape": shape(&occupancy.region),
    })
}

/// What is not said is not there: it is not known.
fn signals(state: &SignalState) -> Value {
    let said = state.signals.iter();
    let said: Map<String, Value> = said
        .map(|(signal, on)| (signal.name().to_string(), json!(on)))
        .collect();
    json!({
        "time_step": [state.time.from, state.time.to],
        "signals": said,
    })
}

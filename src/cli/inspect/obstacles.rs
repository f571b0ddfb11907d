//! Obstacles as JSON: type, states, occupancy sets and signals.

use serde_json::{Value, json};

use super::states::{initial_state, state};
use nearmiss_base::geometry::Footprint;
use nearmiss_scene::scenario::{Obstacle, Prediction};

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
        "shape": obstacle.footprint.as_ref().map(Footprint::shape),
        "prediction": prediction,
        "states": states,
        "occupancies": occupancies.len(),
        "occupancy_set": occupancies,
        "signal_series": obstacle.signals,
    })
}

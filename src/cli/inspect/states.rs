//! States as JSON: numbers or intervals, positions or regions.

use serde_json::{Value, json};

use nearmiss_scene::scenario::{Quantity, State};

/// A state with `x` and `y`, or with the `position` in which it is uncertain where it is; `time_step` is the first,
/// and `time_interval` is there where it is uncertain when.
pub fn state(state: &State) -> Value {
    let mut value = json!({ "time_step": state.time.from });
    let quantity = |quantity: Quantity| json!(quantity);
    let mut put = |name: &str, v: Option<Value>| {
        if let Some(v) = v {
            value[name] = v;
        }
    };
    let (time, point) = (state.time, state.point());
    put("x", point.map(|p| json!(p.x)));
    put("y", point.map(|p| json!(p.y)));
    let uncertain = state.position.as_ref().filter(|_| point.is_none());
    put("position", uncertain.map(|position| json!(position)));
    let interval = (time.to != time.from).then(|| json!(time));
    put("time_interval", interval);
    let direction = state.point_mass_velocity().map(|v| json!(v.y.atan2(v.x)));
    put("orientation", state.orientation.map(quantity).or(direction));
    put("velocity", state.velocity.map(quantity));
    put("acceleration", state.acceleration.map(quantity));
    for (field, v) in &state.more {
        put(field.name(), Some(quantity(*v)));
    }
    value
}

/// An initial state; what it does not say is 0, as the format has it for initial states, and named in `not_said`.
pub fn initial_state(initial: &State) -> Value {
    let mut value = state(initial);
    let mut not_said = Vec::new();
    for name in ["orientation", "velocity"] {
        if value[name].is_null() {
            value[name] = json!(0.0);
            not_said.push(name);
        }
    }
    if !not_said.is_empty() {
        value["not_said"] = json!(not_said);
    }
    value
}

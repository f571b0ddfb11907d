//! States as JSON: numbers or intervals, positions or regions.

use std::collections::BTreeMap;

use serde::Serialize;

use nearmiss_scene::scenario::{Motion, Position, Quantity, State, Steps};

/// A state with `x` and `y`, or with the `position` in which it is uncertain where it is; `time_step` is the first,
/// and `time_interval` is there where it is uncertain when.
#[derive(Default, Serialize)]
pub struct StateDocument<'s> {
    time_step: i64,
    #[serde(skip_serializing_if = "Option::is_none")]
    x: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    y: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    position: Option<&'s Position>,
    #[serde(skip_serializing_if = "Option::is_none")]
    time_interval: Option<Steps>,
    #[serde(skip_serializing_if = "Option::is_none")]
    orientation: Option<Quantity>,
    #[serde(skip_serializing_if = "Option::is_none")]
    velocity: Option<Quantity>,
    #[serde(skip_serializing_if = "Option::is_none")]
    acceleration: Option<Quantity>,
    #[serde(flatten)]
    more: BTreeMap<&'static str, Quantity>,
    /// What an initial state does not say and is 0 therefore.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    not_said: Vec<&'static str>,
}

impl<'s> StateDocument<'s> {
    pub fn new(state: &'s State) -> Self {
        let (time, point) = (state.time, state.point());
        let velocity = state.point_mass_velocity();
        let direction = velocity.map(|v| Quantity::Exact(v.y.atan2(v.x)));
        let more = state.more.iter();
        Self {
            time_step: time.from,
            x: point.map(|p| p.x),
            y: point.map(|p| p.y),
            position: state.position.as_ref().filter(|_| point.is_none()),
            time_interval: (time.to != time.from).then_some(time),
            orientation: state.orientation.or(direction),
            velocity: state.velocity,
            acceleration: state.acceleration,
            more: more.map(|(field, value)| (field.name(), *value)).collect(),
            not_said: Vec::new(),
        }
    }

    /// An initial state; what it does not say is 0, as the format has it for initial states.
    pub fn initial(state: &'s State) -> Self {
        let mut document = Self::new(state);
        for (name, value) in [
            ("orientation", &mut document.orientation),
            ("velocity", &mut document.velocity),
        ] {
            if value.is_none() {
                *value = Some(Quantity::Exact(0.0));
                document.not_said.push(name);
            }
        }
        document
    }

    /// A recorded step.
    pub fn recorded(step: i64, motion: &Motion) -> Self {
        let exact = |value: f64| Some(Quantity::Exact(value));
        Self {
            time_step: step,
            x: Some(motion.pose.position.x),
            y: Some(motion.pose.position.y),
            orientation: exact(motion.pose.heading),
            velocity: exact(motion.velocity),
            acceleration: exact(motion.acceleration),
            ..Self::default()
        }
    }
}

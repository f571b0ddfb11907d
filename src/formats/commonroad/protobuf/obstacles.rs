//! Obstacles: static, dynamic, phantom and environment.

use super::messages::{
    DynamicObstacle, EnvironmentObstacle, PhantomObstacle, SetBasedPrediction, Shape, SignalState,
    StaticObstacle,
};
use super::report::FieldPath;
use super::shapes::{Decode, region};
use super::states::{signal_state, state};
use super::words::OBSTACLE_TYPES;
use crate::commonroad::ReadError;
use crate::commonroad::builder::{self, SourceLocation};
use nearmiss_base::geometry::Footprint;
use nearmiss_scene::scenario::{
    self, ObstacleParts, ObstacleRole, ObstacleType, Occupancy, Prediction,
};

/// A static obstacle; `body` reads its shape.
pub(super) fn fixed(
    at: &FieldPath<'_>,
    message: &StaticObstacle,
    body: Decode,
) -> Result<ObstacleParts, ReadError> {
    let initial = at.need("initial_state", message.initial_state.as_deref());
    let signals = (
        message.initial_signal_state.as_ref(),
        &message.signal_series,
    );
    Ok(ObstacleParts {
        id: at
            .need("static_obstacle_id", message.static_obstacle_id)?
            .into(),
        role: ObstacleRole::Static,
        kind: kind(at, OBSTACLE_TYPES, message.obstacle_type)?,
        footprint: footprint(at, "shape", message.shape.as_ref(), body)?,
        initial: Some(state(&at.field("initial_state"), initial?)?),
        prediction: Prediction::None,
        signals: self::signals(at, signals.0, signals.1)?,
    })
}

/// A dynamic obstacle; `body` reads its shape.
pub(super) fn moving(
    at: &FieldPath<'_>,
    message: &DynamicObstacle,
    body: Decode,
) -> Result<ObstacleParts, ReadError> {
    if message.initial_meta_information_state.is_some() {
        at.no_place_for("initial_meta_information_state");
    }
    if !message.meta_information_series.is_empty() {
        at.no_place_for("meta_information_series");
    }
    if message.external_dataset_id.is_some() {
        at.no_place_for("external_dataset_id");
    }
    let initial = at.need("initial_state", message.initial_state.as_deref());
    let signals = (
        message.initial_signal_state.as_ref(),
        &message.signal_series,
    );
    Ok(ObstacleParts {
        id: at
            .need("dynamic_obstacle_id", message.dynamic_obstacle_id)?
            .into(),
        role: ObstacleRole::Dynamic,
        kind: kind(at, OBSTACLE_TYPES, message.obstacle_type)?,
        footprint: footprint(at, "shape", message.shape.as_ref(), body)?,
        initial: Some(state(&at.field("initial_state"), initial?)?),
        prediction: prediction(at, message)?,
        signals: self::signals(at, signals.0, signals.1)?,
    })
}

/// An environment obstacle; `kinds` are the words of its type, which differ between the versions.
pub(super) fn environment(
    at: &FieldPath<'_>,
    message: &EnvironmentObstacle,
    kinds: &[ObstacleType],
) -> Result<ObstacleParts, ReadError> {
    let id = at.need("environment_obstacle_id", message.environment_obstacle_id)?;
    let shape = message.obstacle_shape.as_ref();
    Ok(ObstacleParts {
        id: id.into(),
        role: ObstacleRole::Environment,
        kind: kind(at, kinds, message.obstacle_type)?,
        footprint: footprint(at, "obstacle_shape", shape, region)?,
        initial: None,
        prediction: Prediction::None,
        signals: Vec::new(),
    })
}

pub(super) fn phantom(
    at: &FieldPath<'_>,
    message: &PhantomObstacle,
) -> Result<ObstacleParts, ReadError> {
    let prediction = message
        .prediction
        .as_ref()
        .map(|p| occupancies(&at.field("prediction"), p));
    Ok(ObstacleParts {
        id: at.need("obstacle_id", message.obstacle_id)?.into(),
        role: ObstacleRole::Phantom,
        kind: ObstacleType::Unknown,
        footprint: None,
        initial: None,
        prediction: prediction.transpose()?.unwrap_or(Prediction::None),
        signals: Vec::new(),
    })
}

fn kind(
    at: &FieldPath<'_>,
    kinds: &[ObstacleType],
    number: Option<i32>,
) -> Result<ObstacleType, ReadError> {
    at.needed_word("obstacle_type", kinds, number, ObstacleType::Unknown)
}

fn footprint(
    at: &FieldPath<'_>,
    name: &str,
    shape: Option<&Shape>,
    body: Decode,
) -> Result<Option<Footprint>, ReadError> {
    let shape = at.need(name, shape)?;
    let at = at.field(name);
    builder::footprint(&at, body(&at, shape)?)
}

fn prediction(at: &FieldPath<'_>, message: &DynamicObstacle) -> Result<Prediction, ReadError> {
    if let Some(set) = &message.set_based_prediction {
        if message.trajectory_prediction.is_some() {
            let message = "a trajectory beside an occupancy set was left out";
            at.field("trajectory_prediction").warn(message);
        }
        return occupancies(&at.field("set_based_prediction"), set);
    }
    let Some(prediction) = &message.trajectory_prediction else {
        return Ok(Prediction::None);
    };
    let at = at.field("trajectory_prediction");
    let trajectory = at.need("trajectory", prediction.trajectory.as_ref())?;
    let shape = at.need("shape", prediction.shape.as_ref())?;
    if Some(shape) != message.shape.as_ref() {
        let message = "shape differs from the obstacle's own, which is used throughout";
        at.field("shape").warn(message);
    }
    let at = at.field("trajectory");
    at.need("initial_time_step", trajectory.initial_time_step)?;
    let states = trajectory
        .states
        .iter()
        .enumerate()
        .map(|(i, bytes)| state(&at.nth("states", i), bytes));
    Ok(Prediction::Trajectory(states.collect::<Result<_, _>>()?))
}

fn occupancies(at: &FieldPath<'_>, message: &SetBasedPrediction) -> Result<Prediction, ReadError> {
    at.need("initial_time_step", message.initial_time_step)?;
    let set = at.need("occupancy_set", message.occupancy_set.as_ref())?;
    let at = at.field("occupancy_set");
    let mut found = Vec::with_capacity(set.occupancies.len());
    for (i, occupancy) in set.occupancies.iter().enumerate() {
        let at = at.nth("occupancies", i);
        let time = at.steps("time_step", occupancy.time_step.as_ref())?;
        let shape = at.need("shape", occupancy.shape.as_ref())?;
        let shape = region(&at.field("shape"), shape)?;
        found.extend(shape.map(|region| Occupancy { time, region }));
    }
    Ok(Prediction::Occupancies(found))
}

fn signals(
    at: &FieldPath<'_>,
    initial: Option<&SignalState>,
    series: &[SignalState],
) -> Result<Vec<scenario::SignalState>, ReadError> {
    let mut found = Vec::new();
    if let Some(initial) = initial {
        found.extend(signal_state(&at.field("initial_signal_state"), initial)?);
    }
    for (i, message) in series.iter().enumerate() {
        found.extend(signal_state(&at.nth("signal_series", i), message)?);
    }
    Ok(found)
}

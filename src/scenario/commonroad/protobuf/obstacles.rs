//! Obstacles: static, dynamic, phantom and environment.

use super::messages::{
    DynamicObstacle, EnvironmentObstacle, PhantomObstacle, SetBasedPrediction, SignalState,
    StaticObstacle,
};
use super::report::{At, Report};
use super::shapes::{BodyMessage, footprint, region};
use super::states::{signal_state, state};
use super::values::steps;
use super::words::{OBSTACLE_TYPES, needed_word};
use crate::scenario::commonroad::ReadError;
use crate::scenario::{
    self, ObstacleParts, ObstacleRole, ObstacleType, Occupancy, Prediction, Severity,
};

pub(super) fn fixed<B: BodyMessage>(
    report: &mut Report,
    at: &At<'_>,
    message: &StaticObstacle<B>,
) -> Result<ObstacleParts, ReadError> {
    let id = report.need(at, "static_obstacle_id", message.static_obstacle_id)?;
    let kind = kind(report, at, message.obstacle_type)?;
    let body = report.need(at, "shape", message.shape.as_ref())?;
    let initial = report.need(at, "initial_state", message.initial_state.as_ref())?;
    let parts = ObstacleParts {
        id: id.into(),
        role: ObstacleRole::Static,
        kind,
        footprint: footprint(report, &at.field("shape"), body)?,
        initial: Some(state(report, &at.field("initial_state"), initial)?),
        prediction: Prediction::None,
        signals: signals(
            report,
            at,
            message.initial_signal_state.as_ref(),
            &message.signal_series,
        )?,
    };
    if let Some(message) = parts.uncertainty() {
        report.warn(at, message);
    }
    Ok(parts)
}

pub(super) fn moving<B: BodyMessage>(
    report: &mut Report,
    at: &At<'_>,
    message: &DynamicObstacle<B>,
) -> Result<ObstacleParts, ReadError> {
    let id = report.need(at, "dynamic_obstacle_id", message.dynamic_obstacle_id)?;
    let kind = kind(report, at, message.obstacle_type)?;
    let body = report.need(at, "shape", message.shape.as_ref())?;
    let initial = report.need(at, "initial_state", message.initial_state.as_ref())?;
    let held_back = [
        (
            message.initial_meta_information_state.is_some(),
            "initial_meta_information_state",
        ),
        (
            !message.meta_information_series.is_empty(),
            "meta_information_series",
        ),
        (message.external_dataset_id.is_some(), "external_dataset_id"),
    ];
    for (_, name) in held_back.iter().filter(|(there, _)| *there) {
        report.note(
            Severity::Note,
            at,
            format!("`{name}` has no place here and was left out"),
        );
    }
    let parts = ObstacleParts {
        id: id.into(),
        role: ObstacleRole::Dynamic,
        kind,
        footprint: footprint(report, &at.field("shape"), body)?,
        initial: Some(state(report, &at.field("initial_state"), initial)?),
        prediction: prediction(report, at, message, body)?,
        signals: signals(
            report,
            at,
            message.initial_signal_state.as_ref(),
            &message.signal_series,
        )?,
    };
    if let Some(message) = parts.uncertainty() {
        report.warn(at, message);
    }
    Ok(parts)
}

/// `kinds` are the words of its type, which differ between the versions.
pub(super) fn environment(
    report: &mut Report,
    at: &At<'_>,
    message: &EnvironmentObstacle,
    kinds: &[ObstacleType],
) -> Result<ObstacleParts, ReadError> {
    let id = report.need(
        at,
        "environment_obstacle_id",
        message.environment_obstacle_id,
    )?;
    let unknown = ObstacleType::Unknown;
    let kind = needed_word(
        report,
        at,
        "obstacle_type",
        kinds,
        message.obstacle_type,
        unknown,
    )?;
    let body = report.need(at, "obstacle_shape", message.obstacle_shape.as_ref())?;
    Ok(ObstacleParts {
        id: id.into(),
        role: ObstacleRole::Environment,
        kind,
        footprint: footprint(report, &at.field("obstacle_shape"), body)?,
        initial: None,
        prediction: Prediction::None,
        signals: Vec::new(),
    })
}

pub(super) fn phantom(
    report: &mut Report,
    at: &At<'_>,
    message: &PhantomObstacle,
) -> Result<ObstacleParts, ReadError> {
    let id = report.need(at, "obstacle_id", message.obstacle_id)?;
    let prediction = message.prediction.as_ref();
    let prediction = prediction.map(|p| occupancies(report, &at.field("prediction"), p));
    Ok(ObstacleParts {
        id: id.into(),
        role: ObstacleRole::Phantom,
        kind: ObstacleType::Unknown,
        footprint: None,
        initial: None,
        prediction: prediction.transpose()?.unwrap_or(Prediction::None),
        signals: Vec::new(),
    })
}

fn kind(report: &mut Report, at: &At<'_>, number: Option<i32>) -> Result<ObstacleType, ReadError> {
    let unknown = ObstacleType::Unknown;
    needed_word(report, at, "obstacle_type", OBSTACLE_TYPES, number, unknown)
}

fn prediction<B: BodyMessage>(
    report: &mut Report,
    at: &At<'_>,
    message: &DynamicObstacle<B>,
    body: &B,
) -> Result<Prediction, ReadError> {
    if let Some(set) = &message.set_based_prediction {
        if message.trajectory_prediction.is_some() {
            let message = "a trajectory beside a set of occupancies was left out";
            report.warn(&at.field("trajectory_prediction"), message);
        }
        return occupancies(report, &at.field("set_based_prediction"), set);
    }
    let Some(prediction) = &message.trajectory_prediction else {
        return Ok(Prediction::None);
    };
    let at = at.field("trajectory_prediction");
    let trajectory = report.need(&at, "trajectory", prediction.trajectory.as_ref())?;
    if report.need(&at, "shape", prediction.shape.as_ref())? != body {
        let message = "another shape than the obstacle's own; its own is taken at all times";
        report.warn(&at.field("shape"), message);
    }
    let at = at.field("trajectory");
    report.need(&at, "initial_time_step", trajectory.initial_time_step)?;
    let mut states = Vec::with_capacity(trajectory.states.len());
    for (i, message) in trajectory.states.iter().enumerate() {
        states.push(state(report, &at.nth("states", i), message)?);
    }
    Ok(Prediction::Trajectory(states))
}

fn occupancies(
    report: &mut Report,
    at: &At<'_>,
    message: &SetBasedPrediction,
) -> Result<Prediction, ReadError> {
    report.need(at, "initial_time_step", message.initial_time_step)?;
    let set = report.need(at, "occupancy_set", message.occupancy_set.as_ref())?;
    let at = at.field("occupancy_set");
    let mut found = Vec::with_capacity(set.occupancies.len());
    for (i, occupancy) in set.occupancies.iter().enumerate() {
        let at = at.nth("occupancies", i);
        let time = report.need(&at, "time_step", occupancy.time_step.as_ref())?;
        let time = steps(report, &at.field("time_step"), time)?;
        let shape = report.need(&at, "shape", occupancy.shape.as_ref())?;
        let shape = region(report, &at.field("shape"), shape)?;
        found.extend(shape.map(|region| Occupancy { time, region }));
    }
    Ok(Prediction::Occupancies(found))
}

fn signals(
    report: &mut Report,
    at: &At<'_>,
    initial: Option<&SignalState>,
    series: &[SignalState],
) -> Result<Vec<scenario::SignalState>, ReadError> {
    let mut found = Vec::new();
    if let Some(initial) = initial {
        let at = at.field("initial_signal_state");
        found.extend(signal_state(report, &at, initial)?);
    }
    for (i, message) in series.iter().enumerate() {
        found.extend(signal_state(report, &at.nth("signal_series", i), message)?);
    }
    Ok(found)
}

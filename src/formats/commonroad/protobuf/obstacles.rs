//! Obstacles and planning problems with their states.

use nearmiss_base::geometry::Footprint;
use nearmiss_scene::scenario::{
    self, Goal, ObstacleParts, ObstacleRole, ObstacleType, Occupancy, PlanningProblem, Position,
    Prediction, Signal, State, StateField, StateField as F,
};

use super::messages::{
    self, DynamicObstacle, EnvironmentObstacle, GoalState, PhantomObstacle, SetBasedPrediction,
    Shape, SignalState, StaticObstacle,
};
use super::report::FieldPath;
use super::shapes::{Decode, region};
use super::values::{OBSTACLE_TYPES, TAGS, ids};
use crate::commonroad::ReadError;
use crate::commonroad::builder::{self, SourceLocation, is_needed, set_quantity};

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

/// The state in the bytes of a field.
pub(super) fn state(at: &FieldPath<'_>, bytes: &[u8]) -> Result<State, ReadError> {
    let message: messages::State = at.decode(bytes)?;
    let mut state = State::at(at.steps("time_step", message.time_step.as_ref())?);
    state.position = position(at, &message)?;
    for (field, value) in quantities(&message) {
        if let Some(value) = value {
            let place = at.field(field.name());
            let value = if is_needed(field) {
                place.quantity(value)?
            } else {
                place.optional_quantity(value)?
            };
            set_quantity(&mut state, field, value);
        }
    }
    // No XML has these.
    if message.front_wheel_angular_speed.is_some() {
        at.no_place_for("front_wheel_angular_speed");
    }
    if message.rear_wheel_angular_speed.is_some() {
        at.no_place_for("rear_wheel_angular_speed");
    }
    Ok(state)
}

fn position(at: &FieldPath<'_>, message: &messages::State) -> Result<Option<Position>, ReadError> {
    if let Some(here) = at.optional_point("point", message.point.as_ref())? {
        return Ok(Some(Position::Point(here)));
    }
    let Some(shape) = &message.shape else {
        return Ok(None);
    };
    Ok(region(&at.field("shape"), shape)?.map(Position::Region))
}

/// The quantities of a state.
fn quantities(m: &messages::State) -> [(F, Option<&messages::FloatExactOrInterval>); 34] {
    [
        (F::Orientation, m.orientation.as_ref()),
        (F::Velocity, m.velocity.as_ref()),
        (F::SteeringAngle, m.steering_angle.as_ref()),
        (F::SteeringAngleSpeed, m.steering_angle_speed.as_ref()),
        (F::YawRate, m.yaw_rate.as_ref()),
        (F::SlipAngle, m.slip_angle.as_ref()),
        (F::RollAngle, m.roll_angle.as_ref()),
        (F::RollRate, m.roll_rate.as_ref()),
        (F::PitchAngle, m.pitch_angle.as_ref()),
        (F::PitchRate, m.pitch_rate.as_ref()),
        (F::VelocityY, m.velocity_y.as_ref()),
        (F::PositionZ, m.position_z.as_ref()),
        (F::VelocityZ, m.velocity_z.as_ref()),
        (F::RollAngleFront, m.roll_angle_front.as_ref()),
        (F::RollRateFront, m.roll_rate_front.as_ref()),
        (F::VelocityYFront, m.velocity_y_front.as_ref()),
        (F::PositionZFront, m.position_z_front.as_ref()),
        (F::VelocityZFront, m.velocity_z_front.as_ref()),
        (F::RollAngleRear, m.roll_angle_rear.as_ref()),
        (F::RollRateRear, m.roll_rate_rear.as_ref()),
        (F::VelocityYRear, m.velocity_y_rear.as_ref()),
        (F::PositionZRear, m.position_z_rear.as_ref()),
        (F::VelocityZRear, m.velocity_z_rear.as_ref()),
        (
            F::LeftFrontWheelAngularSpeed,
            m.left_front_wheel_angular_speed.as_ref(),
        ),
        (
            F::RightFrontWheelAngularSpeed,
            m.right_front_wheel_angular_speed.as_ref(),
        ),
        (
            F::LeftRearWheelAngularSpeed,
            m.left_rear_wheel_angular_speed.as_ref(),
        ),
        (
            F::RightRearWheelAngularSpeed,
            m.right_rear_wheel_angular_speed.as_ref(),
        ),
        (F::DeltaYFront, m.delta_y_front.as_ref()),
        (F::DeltaYRear, m.delta_y_rear.as_ref()),
        (F::Acceleration, m.acceleration.as_ref()),
        (F::AccelerationY, m.acceleration_y.as_ref()),
        (F::Jerk, m.jerk.as_ref()),
        (F::Curvature, m.curvature.as_ref()),
        (F::CurvatureChange, m.curvature_change.as_ref()),
    ]
}

/// A signal state; nothing, with a diagnostic, for one without time.
///
/// Writers write an empty message where there is no signal state; it says nothing, and nothing is said about it.
pub(super) fn signal_state(
    at: &FieldPath<'_>,
    message: &messages::SignalState,
) -> Result<Option<nearmiss_scene::scenario::SignalState>, ReadError> {
    let all = [
        (Signal::Horn, message.horn),
        (Signal::IndicatorLeft, message.indicator_left),
        (Signal::IndicatorRight, message.indicator_right),
        (Signal::BrakingLights, message.braking_lights),
        (Signal::HazardWarningLights, message.hazard_warning_lights),
        (Signal::FlashingBlueLights, message.flashing_blue_lights),
    ]
    .into_iter();
    let signals: Vec<_> = all.filter_map(|(signal, on)| Some((signal, on?))).collect();
    if message.time_step.is_none() {
        if !signals.is_empty() {
            at.warn("a signal state without a time was left out");
        }
        return Ok(None);
    }
    let time = at.steps("time_step", message.time_step.as_ref())?;
    Ok(Some(nearmiss_scene::scenario::SignalState {
        time,
        signals,
    }))
}

pub(super) fn problem(
    at: &FieldPath<'_>,
    message: &messages::PlanningProblem,
) -> Result<PlanningProblem, ReadError> {
    let id = at.need("planning_problem_id", message.planning_problem_id)?;
    let initial = at.need("initial_state", message.initial_state.as_deref())?;
    let initial = state(&at.field("initial_state"), initial)?;
    let goals = message
        .goal_states
        .iter()
        .enumerate()
        .map(|(i, message)| goal(&at.nth("goal_states", i), message))
        .collect::<Result<_, _>>()?;
    if message.ego_id.is_some() {
        at.no_place_for("ego_id");
    }
    Ok(PlanningProblem {
        id: id.into(),
        initial,
        goals,
    })
}

/// A goal. Where it names lanelets, a shape in its state is their area, worked out by the writer: the names count.
fn goal(at: &FieldPath<'_>, message: &GoalState) -> Result<Goal, ReadError> {
    let bytes = at.need("state", message.state.as_deref())?;
    let lanelets = ids(&message.goal_position_lanelets);
    let at = at.field("state");
    let state = state(&at, bytes)?;
    let positions = if lanelets.is_empty() {
        state.position.into_iter().collect()
    } else {
        vec![Position::Lanelets(lanelets)]
    };
    let acceleration = state.acceleration.map(|_| StateField::Acceleration);
    let rest = state.more.iter().map(|(field, _)| *field);
    for field in acceleration.into_iter().chain(rest) {
        at.no_place_for(field.name());
    }
    Ok(Goal {
        time: state.time,
        positions,
        orientation: state.orientation,
        velocity: state.velocity,
    })
}

/// The tags of a scenario.
pub(super) fn tags(at: &FieldPath<'_>, message: &messages::ScenarioTags) -> Vec<String> {
    let numbered = message.tags.iter().enumerate();
    let words = numbered.filter_map(|(i, number)| at.nth("tags", i).word(TAGS, *number));
    words.map(str::to_string).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_quantity_is_read_once() {
        let all = quantities(&messages::State::default()).map(|(field, _)| field);
        let distinct: std::collections::HashSet<_> = all.iter().collect();
        assert_eq!(distinct.len(), all.len());
    }
}

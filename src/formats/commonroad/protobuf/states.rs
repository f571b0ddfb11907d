//! States and signal states.

use super::messages;
use super::report::FieldPath;
use super::shapes::region;
use crate::commonroad::ReadError;
use crate::commonroad::builder::{SourceLocation, is_needed, set_quantity};
use nearmiss_scene::scenario::{Position, Signal, SignalState, State, StateField as F};

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
) -> Result<Option<SignalState>, ReadError> {
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
    Ok(Some(SignalState { time, signals }))
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

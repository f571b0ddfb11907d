//! States and signal states.

use super::messages;
use super::report::{At, Report};
use super::shapes::region;
use super::values::{point, quantity, steps};
use super::words::state_field;
use crate::scenario::commonroad::ReadError;
use crate::scenario::{Position, Quantity, Severity, Signal, SignalState, State, StateField};

pub(super) fn state(
    report: &mut Report,
    at: &At<'_>,
    message: &messages::State,
) -> Result<State, ReadError> {
    let time = report.need(at, "time_step", message.time_step.as_ref())?;
    let mut state = State::at(steps(report, &at.field("time_step"), time)?);
    state.position = position(report, at, message)?;
    for (number, value) in &message.quantities {
        let Some(field) = state_field(*number) else {
            let message = format!("`{}` has no place here and was left out", unheld(*number));
            report.note(Severity::Note, at, message);
            continue;
        };
        let value = quantity(report, &at.field(field.name()), value)?;
        match field {
            StateField::Orientation => state.orientation = value,
            StateField::Velocity => state.velocity = value,
            StateField::Acceleration => state.acceleration = value,
            _ => state.more.extend(value.map(|v: Quantity| (field, v))),
        }
    }
    Ok(state)
}

/// The name of a quantity without a [`StateField`]: no XML has it.
fn unheld(number: u32) -> &'static str {
    if number == 26 {
        "front_wheel_angular_speed"
    } else {
        "rear_wheel_angular_speed"
    }
}

fn position(
    report: &mut Report,
    at: &At<'_>,
    message: &messages::State,
) -> Result<Option<Position>, ReadError> {
    if let Some(here) = &message.point {
        let here = point(report, &at.field("point"), here)?;
        return Ok(Some(Position::Point(here)));
    }
    let Some(shape) = &message.shape else {
        return Ok(None);
    };
    Ok(region(report, &at.field("shape"), shape)?.map(Position::Region))
}

/// A signal state; nothing, with a diagnostic, for one without time.
///
/// Writers write an empty message where there is no signal state; it says nothing, and nothing is said about it.
pub(super) fn signal_state(
    report: &mut Report,
    at: &At<'_>,
    message: &messages::SignalState,
) -> Result<Option<SignalState>, ReadError> {
    let all = [
        (Signal::Horn, message.horn),
        (Signal::IndicatorLeft, message.indicator_left),
        (Signal::IndicatorRight, message.indicator_right),
        (Signal::BrakingLights, message.braking_lights),
        (Signal::HazardWarningLights, message.hazard_warning_lights),
        (Signal::FlashingBlueLights, message.flashing_blue_lights),
    ];
    let said = all
        .into_iter()
        .filter_map(|(signal, on)| Some((signal, on?)));
    let signals: Vec<_> = said.collect();
    let Some(time) = &message.time_step else {
        if !signals.is_empty() {
            report.warn(at, "a signal state without time was left out");
        }
        return Ok(None);
    };
    let time = steps(report, &at.field("time_step"), time)?;
    Ok(Some(SignalState { time, signals }))
}

//! Checks numbers, and turns them into quantities and time steps.

use super::SourceLocation;
use crate::commonroad::ReadError;
use nearmiss_scene::scenario::plausibility::limits::{
    LARGEST_NUMBER, LATEST_STEP, is_tiny, refused_coordinate, refused_size,
};
use nearmiss_scene::scenario::{Quantity, StateField, Steps};

/// A number; `written` is how the file has it.
///
/// # Errors
/// It is not finite, or larger than any quantity of a scenario.
pub fn finite(
    at: &impl SourceLocation,
    value: f64,
    written: impl FnOnce() -> String,
) -> Result<f64, ReadError> {
    if is_tiny(value) {
        at.warn_tiny(value);
    }
    if value.abs() <= LARGEST_NUMBER {
        Ok(value)
    } else if value.is_finite() {
        Err(at.fail(format!("`{}` is implausible", written())))
    } else {
        Err(at.fail(format!("`{}` is not a finite number", written())))
    }
}

/// A coordinate, metres.
///
/// # Errors
/// No map has it.
pub fn coordinate(at: &impl SourceLocation, value: f64) -> Result<f64, ReadError> {
    refused_coordinate(value).map_or(Ok(value), |message| Err(at.fail(message)))
}

/// A length, width or radius, metres.
///
/// # Errors
/// No shape is that large.
pub fn size(at: &impl SourceLocation, value: f64) -> Result<f64, ReadError> {
    refused_size(value).map_or(Ok(value), |message| Err(at.fail(message)))
}

/// A quantity, exact or an interval; nothing, with a diagnostic, where it is neither.
///
/// # Errors
/// The interval is empty, or one of its ends is missing.
pub fn quantity(
    at: &impl SourceLocation,
    exact: Option<f64>,
    start: Option<f64>,
    end: Option<f64>,
) -> Result<Option<Quantity>, ReadError> {
    match (exact, start, end) {
        (Some(value), ..) => Ok(Some(Quantity::Exact(value))),
        (None, Some(from), Some(to)) if from <= to => Ok(Some(Quantity::Interval(from, to))),
        (None, Some(from), Some(to)) => {
            Err(at.fail(format!("the interval from {from} to {to} is empty")))
        }
        (None, None, None) => {
            at.warn("empty; left out");
            Ok(None)
        }
        _ => Err(at.fail("an interval needs both its start and its end")),
    }
}

/// Whether a quantity of a state is one that motion or the body is worked out from.
pub fn is_needed(field: StateField) -> bool {
    matches!(
        field,
        StateField::Orientation
            | StateField::Velocity
            | StateField::VelocityY
            | StateField::HitchAngle
    )
}

/// A quantity that nothing needs: one with a number that is not finite, or larger than any, is left out, with a
/// diagnostic.
///
/// # Errors
/// See [`quantity`].
pub fn optional_quantity(
    at: &impl SourceLocation,
    exact: Option<f64>,
    start: Option<f64>,
    end: Option<f64>,
) -> Result<Option<Quantity>, ReadError> {
    let numbers = || [exact, start, end].into_iter().flatten();
    if let Some(odd) = numbers().find(|v| v.is_nan() || v.abs() > LARGEST_NUMBER) {
        at.warn(if odd.is_finite() {
            format!("`{odd:e}` is implausible; left out")
        } else {
            format!("`{odd}` is not a finite number; left out")
        });
        return Ok(None);
    }
    numbers()
        .filter(|v| is_tiny(*v))
        .for_each(|v| at.warn_tiny(v));
    quantity(at, exact, start, end)
}

/// Why time steps are not read; `None` for those that are.
pub fn refused_step(steps: Steps) -> Option<String> {
    let far = [steps.to, steps.from]
        .into_iter()
        .find(|step| step.abs() > LATEST_STEP)?;
    Some(format!(
        "time step {far} is implausible; steps up to {LATEST_STEP} are read"
    ))
}

//! Checks numbers, and turns them into quantities and time steps.

use nearmiss_scene::scenario::plausibility::{
    LARGEST_NUMBER, LATEST_STEP, is_tiny, refused_coordinate, refused_size,
};
use nearmiss_scene::scenario::{Quantity, Severity, StateField, Steps};

use super::SourceLocation;
use crate::commonroad::ReadError;

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

/// How a file counts time. Nothing is rounded: what is no time step is an error.
#[derive(Debug, Clone, Copy)]
pub struct TimeScale {
    /// Seconds between two steps.
    step: f64,
    is_seconds: bool,
}

impl Default for TimeScale {
    /// In steps, of a length that is not known yet.
    fn default() -> Self {
        Self::in_steps(f64::NAN)
    }
}

/// What a file writes in whole steps may be so far from them, steps.
const ROUNDING: f64 = 1e-6;

/// Seconds in decimals may be so far from whole steps, steps; and for each of these, as the length of a step is in
/// decimals too; together no more than the last.
const DECIMALS: (f64, f64, f64) = (0.01, 1e-5, 0.1);

impl TimeScale {
    /// Times in steps of `step` seconds.
    #[must_use]
    pub fn in_steps(step: f64) -> Self {
        Self {
            step,
            is_seconds: false,
        }
    }

    /// Times in seconds, of which a step has `step`.
    #[must_use]
    pub fn in_seconds(step: f64) -> Self {
        Self {
            step,
            is_seconds: true,
        }
    }

    /// The time step of a number.
    ///
    /// # Errors
    /// It is none: what it looks like.
    pub fn step(&self, number: f64) -> Result<i64, String> {
        let steps = self.steps_in(number);
        if steps.is_nan() {
            return Err(format!("`{number}` is not a time"));
        }
        if steps.abs() > LATEST_STEP as f64 {
            return Err(format!(
                "time step {steps} is implausible; steps up to {LATEST_STEP} are read"
            ));
        }
        let whole = steps.round();
        if (steps - whole).abs() <= self.tolerance(steps) {
            return Ok(whole as i64);
        }
        if self.is_seconds {
            return Err(format!(
                "`{number}` s is no whole number of time steps of {} s",
                self.step
            ));
        }
        let mut message = format!("`{number}` is no time step");
        if let Ok(step) = Self::in_seconds(self.step).step(number) {
            let plural = if step == 1 { "" } else { "s" };
            let length = self.step;
            message.push_str(&format!(
                "; it looks like seconds, {step} step{plural} at {length} s"
            ));
        } else {
            message.push_str(", which is a whole number");
        }
        Err(message)
    }

    /// The steps of an exact time, or from a start to an end. An end or a start that is infinite, or later or earlier
    /// than any step that is read, is open, and noted. Of seconds those steps whose times lie in the interval.
    ///
    /// # Errors
    /// They are missing or no time steps.
    pub fn steps(
        &self,
        at: &impl SourceLocation,
        exact: Option<f64>,
        start: Option<f64>,
        end: Option<f64>,
    ) -> Result<Steps, ReadError> {
        let all = [exact, start, end].into_iter().flatten();
        all.filter(|v| is_tiny(*v)).for_each(|v| at.warn_tiny(v));
        let (from, to) = match (exact, start, end) {
            (Some(value), ..) => {
                let step = self.step(value).map_err(|message| at.fail(message))?;
                return Ok(Steps::exact(step));
            }
            (None, Some(from), Some(to)) => (from, to),
            (None, None, None) => return Err(at.fail("no time step in it")),
            _ => return Err(at.fail("an interval needs both its start and its end")),
        };
        if from > to {
            return Err(at.fail(format!("the interval from {from} to {to} is empty")));
        }
        let latest = LATEST_STEP as f64;
        let first = if self.steps_in(from) < -latest {
            let message = format!("starts at {from}; taken as open, from step -{LATEST_STEP}");
            at.note(Severity::Note, message);
            Ok(-LATEST_STEP)
        } else {
            self.end(from, f64::ceil)
        };
        let last = if self.steps_in(to) > latest {
            let message = format!("ends at {to}; taken as open, to step {LATEST_STEP}");
            at.note(Severity::Note, message);
            Ok(LATEST_STEP)
        } else {
            self.end(to, f64::floor)
        };
        let (from_step, to_step) = (
            first.map_err(|message| at.fail(message))?,
            last.map_err(|message| at.fail(message))?,
        );
        if from_step > to_step {
            let length = self.step;
            let message = format!("from {from} s to {to} s there is no time step of {length} s");
            return Err(at.fail(message));
        }
        Ok(Steps {
            from: from_step,
            to: to_step,
        })
    }

    /// The step of an end of an interval; of seconds between two steps the one inside.
    fn end(&self, number: f64, inside: fn(f64) -> f64) -> Result<i64, String> {
        let steps = self.steps_in(number);
        let is_between = (steps - steps.round()).abs() > self.tolerance(steps);
        if self.is_seconds && is_between && steps.abs() <= LATEST_STEP as f64 {
            Ok(inside(steps) as i64)
        } else {
            self.step(number)
        }
    }

    fn steps_in(&self, number: f64) -> f64 {
        if self.is_seconds {
            number / self.step
        } else {
            number
        }
    }

    fn tolerance(&self, steps: f64) -> f64 {
        let (decimals, each, most) = DECIMALS;
        if self.is_seconds {
            (decimals + each * steps.abs()).min(most)
        } else {
            ROUNDING
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    #[test]
    fn seconds_become_whole_steps_or_an_error() {
        for (seconds, step, expected) in [
            (0.0, 0.1, 0),
            (0.3, 0.1, 3),
            (7.7, 0.1, 77),
            (4.0, 0.100_000_001, 40),
            (10.0, 0.033_333, 300),
            (1.24, 0.04, 31),
            (-0.5, 0.1, -5),
            (180.0, 0.25, 720),
        ] {
            assert_eq!(TimeScale::in_seconds(step).step(seconds), Ok(expected));
        }
        let said = TimeScale::in_seconds(0.1).step(0.15).unwrap_err();
        assert_eq!(said, "`0.15` s is no whole number of time steps of 0.1 s");
        assert!(TimeScale::in_seconds(0.1).step(2e6).is_err());
    }

    #[test]
    fn steps_are_whole_and_fractions_are_told() {
        let scale = TimeScale::in_steps(0.1);
        assert_eq!(scale.step(10.0), Ok(10));
        assert_eq!(scale.step(10.000_000_001), Ok(10));
        for (number, said) in [
            (
                0.1,
                "`0.1` is no time step; it looks like seconds, 1 step at 0.1 s",
            ),
            (
                1.2,
                "`1.2` is no time step; it looks like seconds, 12 steps at 0.1 s",
            ),
            (0.15, "`0.15` is no time step, which is a whole number"),
            (f64::NAN, "`NaN` is not a time"),
            (
                f64::INFINITY,
                "time step inf is implausible; steps up to 10000000 are read",
            ),
        ] {
            assert_eq!(scale.step(number).unwrap_err(), said);
        }
    }
}

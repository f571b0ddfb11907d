//! Bounds of quantities: beyond which a value is an error, and beyond which it is reported.

use std::f64::consts::{PI, TAU};

use crate::scenario::{Quantity, StateField};

/// The shortest and the longest time step that is read, seconds.
pub const TIME_STEPS: (f64, f64) = (0.001, 10.0);

/// Longer time steps are unusual, seconds.
pub const LONG_TIME_STEP: f64 = 1.0;

/// Later or earlier time steps are a mistake in the file.
pub const LATEST_STEP: i64 = 10_000_000;

/// Coordinates of no map projection are larger, metres: half the equator is 20,038 km long.
pub const LARGEST_COORDINATE: f64 = 2.5e7;

/// No quantity of a scenario is larger, whatever its unit.
pub const LARGEST_NUMBER: f64 = 1e9;

/// No shape is larger, metres.
pub const LARGEST_SHAPE: f64 = 1e5;

/// More points, states or members than this are not read.
pub const MOST_PARTS: usize = 1_000_000;

/// No measured value other than 0 is nearer to 0.
pub const SMALLEST_NUMBER: f64 = 1e-100;

/// No road user is faster, m/s.
pub const FASTEST: f64 = 100.0;

/// No vehicle reverses faster, m/s.
pub const FASTEST_BACKWARDS: f64 = 20.0;

/// Headings beyond this many turns look like degrees.
pub const MOST_TURNS: f64 = 3.0;

/// Why a time step of `seconds` is refused; `None` if it is valid.
pub fn refused_time_step(seconds: f64) -> Option<String> {
    let (shortest, longest) = TIME_STEPS;
    if seconds.is_nan() || seconds <= 0.0 {
        return Some("is not a positive number of seconds".into());
    }
    (!(shortest..=longest).contains(&seconds)).then(|| {
        format!(
            "is out of range: {shortest} s to {longest} s are supported; is it in another unit?"
        )
    })
}

/// Why a coordinate is refused; `None` if it is valid.
pub fn refused_coordinate(metres: f64) -> Option<String> {
    (metres.abs() > LARGEST_COORDINATE).then(|| {
        format!(
            "`{metres}` is implausible: coordinates are limited to ±{:.0} km",
            LARGEST_COORDINATE / 1e3
        )
    })
}

/// Why a length, width or radius is refused; `None` if it is valid.
pub fn refused_size(metres: f64) -> Option<String> {
    (metres.abs() > LARGEST_SHAPE).then(|| {
        format!(
            "`{metres}` is implausible: shapes are limited to {:.0} km",
            LARGEST_SHAPE / 1e3
        )
    })
}

/// The diagnostic for a number smaller than any measured one, if it is one.
pub fn is_tiny(value: f64) -> bool {
    value != 0.0 && value.abs() < SMALLEST_NUMBER
}

/// Why a quantity of a state is implausible, with its value; `None` if it is plausible.
pub fn doubtful(field: StateField, quantity: Quantity) -> Option<String> {
    let (from, to) = match quantity {
        Quantity::Exact(value) => (value, value),
        Quantity::Interval(from, to) => (from, to),
    };
    let value = if from.abs() > to.abs() { from } else { to };
    let (most, unit) = most(field)?;
    if value.abs() > most {
        let name = field.name();
        return Some(match field {
            StateField::Orientation => format!(
                "heading {value}, read as radians, is more than {MOST_TURNS} turns; is it in degrees?"
            ),
            _ => {
                let digits = if most.fract() == 0.0 { 0 } else { 2 };
                format!("{name} is {value} {unit}; no road user exceeds {most:.digits$} {unit}")
            }
        });
    }
    let backwards = field == StateField::Velocity && from < -FASTEST_BACKWARDS;
    backwards.then(|| format!("drives backwards at {} m/s", -from))
}

/// The largest magnitude that a quantity can have, and its unit; `None` if anything is possible.
fn most(field: StateField) -> Option<(f64, &'static str)> {
    use StateField as F;
    Some(match field {
        F::Orientation => (MOST_TURNS * TAU, "rad"),
        F::Velocity | F::VelocityY | F::VelocityYFront | F::VelocityYRear => (FASTEST, "m/s"),
        F::VelocityZ | F::VelocityZFront | F::VelocityZRear => (FASTEST, "m/s"),
        F::Acceleration | F::AccelerationY => (50.0, "m/s²"),
        F::YawRate | F::RollRate | F::PitchRate | F::RollRateFront | F::RollRateRear => {
            (20.0, "rad/s")
        }
        F::SlipAngle | F::HitchAngle => (PI, "rad"),
        F::SteeringAngle | F::RollAngle | F::PitchAngle | F::RollAngleFront | F::RollAngleRear => {
            (PI / 2.0, "rad")
        }
        F::SteeringAngleSpeed => (20.0, "rad/s"),
        F::PositionZ | F::PositionZFront | F::PositionZRear => (1e4, "m"),
        F::LeftFrontWheelAngularSpeed
        | F::RightFrontWheelAngularSpeed
        | F::LeftRearWheelAngularSpeed
        | F::RightRearWheelAngularSpeed
        | F::FrontWheelAngularSpeed
        | F::RearWheelAngularSpeed => (1e3, "rad/s"),
        F::DeltaYFront | F::DeltaYRear => (10.0, "m"),
        F::Curvature => (10.0, "1/m"),
        F::Jerk => (1e4, "m/s³"),
        F::LongitudinalPosition | F::LateralPosition => (1e6, "m"),
        F::CurvatureChange | F::CurvatureRate | F::Jounce | F::JerkDot | F::KappaDotDot => {
            return None;
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_steps_have_a_range() {
        for fine in [0.001, 0.04, 0.1, 1.0, 10.0] {
            assert_eq!(refused_time_step(fine), None, "{fine}");
        }
        for absurd in [
            0.0,
            -0.1,
            1e-6,
            9.9e-4,
            10.1,
            1e9,
            f64::NAN,
            f64::INFINITY,
            1e-320,
        ] {
            assert!(refused_time_step(absurd).is_some(), "{absurd}");
        }
    }

    #[test]
    fn each_quantity_has_its_own_limit() {
        let doubt = |field, value| doubtful(field, Quantity::Exact(value));
        assert_eq!(doubt(StateField::Orientation, -4.7), None);
        assert!(doubt(StateField::Orientation, 90.0).is_some_and(|said| said.contains("degrees")));
        assert_eq!(doubt(StateField::Velocity, 60.0), None);
        assert_eq!(doubt(StateField::Velocity, -3.0), None);
        assert!(
            doubt(StateField::Velocity, -45.0).is_some_and(|said| said.contains("backwards at 45"))
        );
        assert!(doubt(StateField::SteeringAngle, 30.0).is_some());
        let wide = Quantity::Interval(-400.0, 3.0);
        assert!(doubtful(StateField::Velocity, wide).is_some_and(|said| said.contains("-400")));
    }
}

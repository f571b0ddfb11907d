//! States and positions after a change of the plane.

use super::plane::Plane;
use crate::scenario::{Position, State, StateField};

impl Plane {
    pub(super) fn position(&self, position: &Position) -> Position {
        match position {
            Position::Point(p) => Position::Point(self.point(p)),
            Position::Region(shape) => Position::Region(self.region(shape)),
            Position::Lanelets(ids) => Position::Lanelets(ids.clone()),
        }
    }

    pub(super) fn state(&self, state: &State) -> State {
        let mut placed = state.clone();
        placed.position = state.position.as_ref().map(|p| self.position(p));
        placed.orientation = state.orientation.map(|q| self.heading_of(q));
        for (field, value) in &mut placed.more {
            if *field == StateField::Orientation {
                *value = self.heading_of(*value);
            } else if counts_to_the_left(*field) {
                *value = self.side_of(*value);
            }
            if self.mirrored {
                *field = other_side(*field);
            }
        }
        if state.point_mass_velocity().is_some() {
            self.along_axes(state, &mut placed);
        }
        placed
    }

    /// A point mass has no heading: its velocity and acceleration are told along the axes of the world.
    fn along_axes(&self, state: &State, placed: &mut State) {
        if let Some(y) = state.quantity(StateField::VelocityY)
            && let Some(x) = state.velocity
        {
            let (x, y) = self.vector_of((x, y));
            placed.velocity = Some(x);
            placed.set(StateField::VelocityY, y);
        }
        if let Some(y) = state.quantity(StateField::AccelerationY)
            && let Some(x) = state.acceleration
        {
            let (x, y) = self.vector_of((x, y));
            placed.acceleration = Some(x);
            placed.set(StateField::AccelerationY, y);
        }
    }
}

impl State {
    fn set(&mut self, field: StateField, value: crate::scenario::Quantity) {
        for (_, old) in self.more.iter_mut().filter(|(f, _)| *f == field) {
            *old = value;
        }
    }
}

/// Whether a quantity is positive to the left of the vehicle or counter-clockwise.
fn counts_to_the_left(field: StateField) -> bool {
    use StateField as F;
    match field {
        F::YawRate
        | F::SlipAngle
        | F::SteeringAngle
        | F::SteeringAngleSpeed
        | F::VelocityY
        | F::AccelerationY
        | F::RollAngle
        | F::RollRate
        | F::RollAngleFront
        | F::RollRateFront
        | F::VelocityYFront
        | F::RollAngleRear
        | F::RollRateRear
        | F::VelocityYRear
        | F::DeltaYFront
        | F::DeltaYRear
        | F::Curvature
        | F::CurvatureChange
        | F::CurvatureRate
        | F::KappaDotDot
        | F::HitchAngle
        | F::LateralPosition => true,
        F::Orientation
        | F::Velocity
        | F::Acceleration
        | F::PitchAngle
        | F::PitchRate
        | F::PositionZ
        | F::VelocityZ
        | F::PositionZFront
        | F::VelocityZFront
        | F::PositionZRear
        | F::VelocityZRear
        | F::LeftFrontWheelAngularSpeed
        | F::RightFrontWheelAngularSpeed
        | F::LeftRearWheelAngularSpeed
        | F::RightRearWheelAngularSpeed
        | F::Jerk
        | F::Jounce
        | F::FrontWheelAngularSpeed
        | F::RearWheelAngularSpeed
        | F::LongitudinalPosition
        | F::JerkDot => false,
    }
}

/// The same quantity of the wheel on the other side.
fn other_side(field: StateField) -> StateField {
    match field {
        StateField::LeftFrontWheelAngularSpeed => StateField::RightFrontWheelAngularSpeed,
        StateField::RightFrontWheelAngularSpeed => StateField::LeftFrontWheelAngularSpeed,
        StateField::LeftRearWheelAngularSpeed => StateField::RightRearWheelAngularSpeed,
        StateField::RightRearWheelAngularSpeed => StateField::LeftRearWheelAngularSpeed,
        other => other,
    }
}

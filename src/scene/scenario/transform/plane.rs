//! Rigid changes of the plane, mirrored or not: of points, directions, angles, shapes and states.

use std::borrow::Cow;

use nearmiss_base::geometry::{Footprint, Point, Pose, Shape, ShapeError, Vector, normalize_angle};

use crate::scenario::{Position, Quantity, State, StateField};

/// Mirrored at the x axis, if at all, or turned about a centre, or shifted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    pub mirrored: bool,
    /// Radians, counter-clockwise.
    pub angle: f64,
    centre: Point,
    shift: Vector,
}

impl Plane {
    pub fn mirror() -> Self {
        Self {
            mirrored: true,
            ..Self::shift(Vector::zeros())
        }
    }

    pub fn turn(angle: f64, centre: Point) -> Self {
        Self {
            angle,
            centre,
            ..Self::shift(Vector::zeros())
        }
    }

    pub fn shift(shift: Vector) -> Self {
        Self {
            mirrored: false,
            angle: 0.0,
            centre: Point::origin(),
            shift,
        }
    }

    /// From the world into the frame of something at `pose`.
    fn into_frame(pose: &Pose) -> Self {
        Self {
            shift: -pose.position.coords,
            ..Self::turn(-pose.heading, pose.position)
        }
    }

    /// What counts to the left or counter-clockwise.
    pub fn side(&self, value: f64) -> f64 {
        if self.mirrored { -value } else { value }
    }

    /// The same of an interval.
    pub fn side_of(&self, quantity: Quantity) -> Quantity {
        match quantity {
            Quantity::Interval(from, to) if self.mirrored => Quantity::Interval(-to, -from),
            Quantity::Interval(..) => quantity,
            Quantity::Exact(value) => Quantity::Exact(self.side(value)),
        }
    }

    /// A direction with a length, in the world's axes.
    pub fn vector(&self, v: &Vector) -> Vector {
        let (sin, cos) = self.angle.sin_cos();
        let (x, y) = (v.x, self.side(v.y));
        Vector::new(x * cos - y * sin, x * sin + y * cos)
    }

    pub fn point(&self, p: &Point) -> Point {
        if self.angle == 0.0 {
            // Not through the centre, so that no digit is lost.
            return Point::new(p.x, self.side(p.y)) + self.shift;
        }
        self.centre + self.vector(&(p - self.centre)) + self.shift
    }

    /// A heading in the world; one that stays is not touched.
    pub fn heading(&self, heading: f64) -> f64 {
        if self.angle == 0.0 {
            self.side(heading)
        } else {
            normalize_angle(self.side(heading) + self.angle)
        }
    }

    /// A heading that may be an interval, whose middle is brought into (−π, π] where it is turned.
    pub fn heading_of(&self, heading: Quantity) -> Quantity {
        match self.side_of(heading) {
            Quantity::Exact(_) => Quantity::Exact(self.heading(heading.middle())),
            Quantity::Interval(from, to) => {
                let by = self.heading(heading.middle()) - f64::midpoint(from, to);
                Quantity::Interval(from + by, to + by)
            }
        }
    }

    /// A velocity or an acceleration along the world's axes; of intervals the smallest that hold what comes of them.
    pub fn vector_of(&self, (x, y): (Quantity, Quantity)) -> (Quantity, Quantity) {
        let middle = self.vector(&Vector::new(x.middle(), y.middle()));
        let half = |q: Quantity| match q {
            Quantity::Exact(_) => None,
            Quantity::Interval(from, to) => Some((to - from) / 2.0),
        };
        let (sin, cos) = self.angle.sin_cos();
        let around = |middle: f64, by_x: f64, by_y: f64| match (half(x), half(y)) {
            (None, None) => Quantity::Exact(middle),
            (a, b) => {
                let half = a.unwrap_or(0.0) * by_x.abs() + b.unwrap_or(0.0) * by_y.abs();
                Quantity::Interval(middle - half, middle + half)
            }
        };
        (around(middle.x, cos, sin), around(middle.y, sin, cos))
    }

    /// A shape in the frame of something that is itself turned and shifted.
    pub fn body(&self, shape: &Shape) -> Shape {
        let own = Self {
            angle: 0.0,
            shift: Vector::zeros(),
            ..*self
        };
        match shape {
            Shape::Truck(truck) => Shape::Truck(*truck),
            Shape::SemiTrailerTruck {
                tractor,
                trailer,
                hitch_angle,
            } => Shape::SemiTrailerTruck {
                tractor: *tractor,
                trailer: *trailer,
                hitch_angle: self.side(*hitch_angle),
            },
            Shape::Group(members) => Shape::Group(members.iter().map(|m| own.body(m)).collect()),
            other => own.region(other),
        }
    }

    /// A shape in the world. Trucks stand in the world's origin and are told by their boxes.
    pub fn region(&self, shape: &Shape) -> Shape {
        let shape: Cow<'_, Shape> = shape.plain();
        match &*shape {
            Shape::Rectangle {
                length,
                width,
                center,
                orientation,
                origin_x_shift,
            } => Shape::Rectangle {
                length: *length,
                width: *width,
                center: self.point(center),
                orientation: self.heading(*orientation),
                origin_x_shift: *origin_x_shift,
            },
            Shape::Circle { radius, center } => Shape::Circle {
                radius: *radius,
                center: self.point(center),
            },
            Shape::Polygon { vertices } => Shape::Polygon {
                vertices: vertices.iter().map(|p| self.point(p)).collect(),
            },
            Shape::Group(members) => Shape::Group(members.iter().map(|m| self.region(m)).collect()),
            Shape::Truck(_) | Shape::SemiTrailerTruck { .. } => shape.into_owned(),
        }
    }

    /// A body of something that is itself turned and shifted.
    pub fn footprint(&self, footprint: &Footprint) -> Footprint {
        if self.mirrored {
            again(footprint, Footprint::new(self.body(footprint.shape())))
        } else {
            footprint.clone()
        }
    }

    /// A body that is told in the world's coordinates.
    pub fn standing(&self, footprint: &Footprint) -> Footprint {
        again(footprint, Footprint::new(self.region(footprint.shape())))
    }
}

/// A region of the world in the frame of something at `pose`.
pub fn in_frame(region: &Shape, pose: &Pose) -> Shape {
    Plane::into_frame(pose).region(region)
}

/// What encloses an area does so wherever it is; only one at the very limit of what counts as flat may not.
fn again(before: &Footprint, after: Result<Footprint, ShapeError>) -> Footprint {
    after.unwrap_or_else(|_| before.clone())
}

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

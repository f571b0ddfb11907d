//! States as files give them: numbers that may be intervals, positions that may be regions.

use serde::{Serialize, Serializer};
use serde_json::json;

use super::StateField;
use nearmiss_base::geometry::{Point, Shape, Vector};

/// A number, exact or known to lie in an interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Quantity {
    /// The number.
    Exact(f64),
    /// An interval, ends included.
    Interval(f64, f64),
}

impl Quantity {
    /// The number, or the middle of the interval.
    #[must_use]
    pub fn middle(&self) -> f64 {
        match self {
            Self::Exact(value) => *value,
            Self::Interval(from, to) => f64::midpoint(*from, *to),
        }
    }
}

/// A time step or a span of them, ends included.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(into = "(i64, i64)")]
pub struct Steps {
    /// First.
    pub from: i64,
    /// Last; the same as the first for an exact time.
    pub to: i64,
}

impl From<Steps> for (i64, i64) {
    fn from(steps: Steps) -> Self {
        (steps.from, steps.to)
    }
}

impl Steps {
    /// Exactly one step.
    #[must_use]
    pub fn exact(step: i64) -> Self {
        Self {
            from: step,
            to: step,
        }
    }
}

/// Where something is, exactly or not.
/// In JSON an object with its `kind`; shapes are in world coordinates.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Position {
    /// Here.
    #[serde(serialize_with = "point")]
    Point(Point),
    /// Within this region of the world.
    Region(Shape),
    /// Somewhere on these lanelets.
    #[serde(serialize_with = "lanelets")]
    Lanelets(Vec<i64>),
}

fn point<S: Serializer>(point: &Point, to: S) -> Result<S::Ok, S::Error> {
    json!({ "kind": "point", "x": point.x, "y": point.y }).serialize(to)
}

fn lanelets<S: Serializer>(ids: &[i64], to: S) -> Result<S::Ok, S::Error> {
    json!({ "kind": "lanelets", "lanelets": ids }).serialize(to)
}

/// One state of an obstacle, a planning problem or a goal.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// When, in time steps.
    pub time: Steps,
    /// Where, if it is said.
    pub position: Option<Position>,
    /// Heading, radians.
    pub orientation: Option<Quantity>,
    /// Speed along the heading, m/s.
    pub velocity: Option<Quantity>,
    /// Acceleration along the heading, m/s².
    pub acceleration: Option<Quantity>,
    /// Every other quantity, in the file's order.
    pub more: Vec<(StateField, Quantity)>,
}

impl State {
    /// A state that says only when.
    #[must_use]
    pub fn at(time: Steps) -> Self {
        Self {
            time,
            position: None,
            orientation: None,
            velocity: None,
            acceleration: None,
            more: Vec::new(),
        }
    }

    /// Another quantity, where it is said.
    #[must_use]
    pub fn quantity(&self, field: StateField) -> Option<Quantity> {
        let found = self.more.iter().find(|(f, _)| *f == field);
        found.map(|(_, value)| *value)
    }

    /// The velocity in the world's axes, m/s, of a point-mass state: one that has a second velocity and no heading.
    #[must_use]
    pub fn point_mass_velocity(&self) -> Option<Vector> {
        let across = self.quantity(StateField::VelocityY)?;
        let along = self.velocity.filter(|_| self.orientation.is_none())?;
        Some(Vector::new(along.middle(), across.middle()))
    }

    /// The position, or the centroid of the region in which it is; nothing on lanelets.
    #[must_use]
    pub fn middle(&self) -> Option<Point> {
        match self.position.as_ref()? {
            Position::Point(p) => Some(*p),
            Position::Region(region) => region.centroid(),
            Position::Lanelets(_) => None,
        }
    }

    /// The position, where it is a point.
    #[must_use]
    pub fn point(&self) -> Option<Point> {
        match &self.position {
            Some(Position::Point(p)) => Some(*p),
            _ => None,
        }
    }
}

//! Planning problems, and states as files give them: numbers that may be intervals, positions that may be regions.

use nearmiss_base::geometry::{Footprint, Point, Pose, Shape, Vector, angle_between};
use serde::{Serialize, Serializer};
use serde_json::json;

use super::{LaneletNetwork, Motion, StateField};

/// The task of an ego vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanningProblem {
    /// Unique in the scenario; recorded egos carry it as their id.
    pub id: i64,
    /// The initial state.
    pub initial: State,
    /// Any one of these is an arrival.
    pub goals: Vec<Goal>,
}

/// One goal: all of its conditions must hold.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Goal {
    /// When, in time steps.
    #[serde(rename = "time_step")]
    pub time: Steps,
    /// Where; several regions are alternatives.
    pub positions: Vec<Position>,
    /// Heading, radians.
    pub orientation: Option<Quantity>,
    /// Speed, m/s.
    pub velocity: Option<Quantity>,
}

impl Goal {
    /// Ids of the lanelets among the goal's positions.
    #[must_use]
    pub fn lanelets(&self) -> Vec<i64> {
        let ids = self.positions.iter().filter_map(|p| match p {
            Position::Lanelets(ids) => Some(ids.as_slice()),
            _ => None,
        });
        ids.flatten().copied().collect()
    }
}

impl PlanningProblem {
    /// The place of the goal that a vehicle has reached whose centre moves like this at `step`, if any: all that the
    /// goal says holds, as CommonRoad defines it.
    #[must_use]
    pub fn reached(&self, step: i64, motion: &Motion, network: &LaneletNetwork) -> Option<usize> {
        let mut goals = self.goals.iter();
        goals.position(|goal| goal.is_reached(step, motion, network))
    }

    /// The last time step at which a goal can be reached; `None` without goals.
    #[must_use]
    pub fn deadline(&self) -> Option<i64> {
        self.goals.iter().map(|goal| goal.time.to).max()
    }
}

impl Goal {
    fn is_reached(&self, step: i64, motion: &Motion, network: &LaneletNetwork) -> bool {
        let within = |wanted: Option<Quantity>, value: f64| match wanted {
            None => true,
            Some(Quantity::Exact(exact)) => (value - exact).abs() <= ROUNDING,
            Some(Quantity::Interval(from, to)) => (from..=to).contains(&value),
        };
        let turned = |wanted: Quantity| match wanted {
            Quantity::Exact(exact) => angle_between(exact, motion.pose.heading).abs() <= ROUNDING,
            Quantity::Interval(from, to) => {
                let off = angle_between(f64::midpoint(from, to), motion.pose.heading);
                off.abs() <= (to - from) / 2.0
            }
        };
        (self.time.from..=self.time.to).contains(&step)
            && within(self.velocity, motion.velocity)
            && self.orientation.is_none_or(turned)
            && self.holds(motion, network)
    }

    /// Whether its position, where it has one, holds a vehicle's centre.
    fn holds(&self, motion: &Motion, network: &LaneletNetwork) -> bool {
        let at = &motion.pose.position;
        self.positions.is_empty()
            || self.positions.iter().any(|position| match position {
                Position::Point(p) => (p - at).norm() <= ROUNDING,
                Position::Region(shape) => Footprint::new(shape.clone())
                    .is_ok_and(|region| region.at(Pose::new(0.0, 0.0, 0.0)).holds(at)),
                Position::Lanelets(ids) => {
                    network.lanelets_at(at).iter().any(|id| ids.contains(id))
                }
            })
    }
}

/// Exact values are met within this.
const ROUNDING: f64 = 1e-6;

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

//! Planning problems: the ego's initial state and its goals.

use serde::Serialize;

use super::{LaneletNetwork, Motion, Position, Quantity, State, Steps};
use nearmiss_base::geometry::{Footprint, Pose, angle_between};

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

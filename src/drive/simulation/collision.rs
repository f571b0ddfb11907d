//! What ends a drive: the edge of the road, the goal, or contact, with whom and which side of the body.

use nearmiss_base::geometry::{Placed, Pose, Sweep};
use nearmiss_scene::metrics::{ContactSide, DEEP, sides};
use nearmiss_scene::scenario::{Obstacle, ObstacleRole, Scenario, driven_way};

use super::{Driver, Outcome};
use crate::planner::VehicleState;

/// The first contact of the ego.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Collision {
    /// The obstacle.
    pub with: i64,
    /// When, in time steps: the first step at or after it.
    pub step: i64,
    /// Whether they touch only between the step before and this one, and are apart at it.
    pub between: bool,
    /// The side of the ego that is touched.
    pub ego: ContactSide,
    /// The side of the obstacle that is touched.
    pub other: ContactSide,
    /// Whether the obstacle is a region of an occupancy set there, which it may cover or not.
    pub is_possible: bool,
}

impl std::fmt::Display for Collision {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (ego, other) = (self.ego.name(), self.other.name());
        write!(f, "{} ", self.with)?;
        if self.between {
            write!(f, "between steps {} and {}", self.step - 1, self.step)?
        } else {
            write!(f, "at step {}", self.step)?
        }
        if self.is_possible {
            write!(
                f,
                ", a possible contact: the ego's {ego} with its predicted occupancy"
            )
        } else {
            write!(f, ": the ego's {ego}, the other's {other}")
        }
    }
}

impl Collision {
    /// The collision of a body with anyone of `scenario` but `without` at a step: exact distance 0. Of several the
    /// first in the file's order; see [`Self::first`].
    #[must_use]
    pub fn at(
        scenario: &Scenario,
        ego: &Placed<'_>,
        step: i64,
        without: Option<i64>,
    ) -> Option<Self> {
        let mut all = solid(scenario, without);
        all.find_map(|obstacle| Self::with(obstacle, ego, step))
    }

    /// The same for a body that was at `before` a step earlier, also where it touches only on the way from there: of
    /// several who are touched, the one that was touched first. The sides are those of the first touch: at the step
    /// itself fast bodies are already in each other, and the front that ran into a rear may seem to touch a side.
    #[must_use]
    pub fn first(
        scenario: &Scenario,
        ego: &Placed<'_>,
        before: Option<Pose>,
        step: i64,
        without: Option<i64>,
    ) -> Option<Self> {
        let Some(before) = before else {
            return Self::at(scenario, ego, step, without);
        };
        let own = Sweep::new(ego.footprint.at(before), *ego);
        let touched = solid(scenario, without)
            .filter_map(|obstacle| Self::on_the_way(obstacle, &own, ego, step, scenario.dt()));
        let first = touched.min_by(|a, b| a.0.total_cmp(&b.0));
        first.map(|(_, collision)| collision)
    }

    /// With one obstacle at a step or on the way there, and after which share of the way.
    fn on_the_way(
        obstacle: &Obstacle,
        own: &Sweep<'_>,
        ego: &Placed<'_>,
        step: i64,
        dt: f64,
    ) -> Option<(f64, Self)> {
        let at_step = Self::with(obstacle, ego, step);
        let way = way_to(obstacle, step, dt);
        let touch = way.and_then(|way| Some((way, own.first_touch(&way)?)));
        let Some((way, share)) = touch.filter(|(_, share)| *share > 0.0) else {
            return at_step.map(|collision| (1.0, collision));
        };
        let deep = (share + DEEP).min(1.0);
        let [ego, other] = sides(&own.at(deep), &way.at(deep));
        let collision = Self {
            with: obstacle.id,
            step,
            between: at_step.is_none(),
            ego,
            other,
            is_possible: obstacle.is_occupancy_at(step),
        };
        Some((share, collision))
    }

    /// With one obstacle at a step.
    fn with(obstacle: &Obstacle, ego: &Placed<'_>, step: i64) -> Option<Self> {
        let other = obstacle.placed_at(step)?;
        let far = ego.footprint.reach() + other.footprint.reach();
        let apart = (ego.pose.position - other.pose.position).norm();
        if apart > far || ego.distance(&other) > 0.0 {
            return None;
        }
        let [own, others] = sides(ego, &other);
        Some(Self {
            with: obstacle.id,
            step,
            between: false,
            ego: own,
            other: others,
            is_possible: obstacle.is_occupancy_at(step),
        })
    }
}

fn solid(scenario: &Scenario, without: Option<i64>) -> impl Iterator<Item = &Obstacle> {
    let others = scenario.obstacles.iter();
    others.filter(move |o| {
        matches!(o.role, ObstacleRole::Static | ObstacleRole::Dynamic) && Some(o.id) != without
    })
}

/// The way of an obstacle to a step from the one before, `dt` seconds earlier; `None` where it is absent at one of them.
fn way_to(obstacle: &Obstacle, step: i64, dt: f64) -> Option<Sweep<'_>> {
    let before = obstacle.placed_at(step.checked_sub(1)?)?;
    driven_way(before, obstacle.placed_at(step)?, dt)
}

/// What ends a drive, state by state.
#[derive(Debug, Clone)]
pub struct EndOfDriveCheck<'a> {
    driver: &'a Driver,
    scenario: &'a Scenario,
    goal_from: i64,
    /// An ego that starts off the road may first get onto it.
    was_on: bool,
    /// A goal that was reached before it may end the drive.
    reached: Option<usize>,
    /// Where the ego was a step before.
    before: Option<(i64, Pose)>,
}

impl<'a> EndOfDriveCheck<'a> {
    /// A look at the states of one drive through `scenario`, in order; goals end it from step `goal_from` on.
    #[must_use]
    pub fn new(driver: &'a Driver, scenario: &'a Scenario, goal_from: i64) -> Self {
        Self {
            driver,
            scenario,
            goal_from,
            was_on: false,
            reached: None,
            before: None,
        }
    }

    /// How the drive ends with this state, if it does.
    pub fn at(&mut self, step: i64, state: &VehicleState) -> Option<Outcome> {
        self.at_in(self.scenario, step, state)
    }

    /// The same among the traffic of another scenario on the same road.
    pub fn at_in(
        &mut self,
        scenario: &Scenario,
        step: i64,
        state: &VehicleState,
    ) -> Option<Outcome> {
        let driver = self.driver;
        let motion = state.centre(driver.limits());
        let body = driver.road().body().at(motion.pose);
        let without = driver.settings().without;
        let before = self
            .before
            .replace((step, motion.pose))
            .filter(|(earlier, _)| earlier + 1 == step)
            .map(|(_, pose)| pose);
        if let Some(collision) = Collision::first(scenario, &body, before, step, without) {
            return Some(Outcome::Collision(collision));
        }
        let on = driver.road().holds(state, driver.limits());
        if self.was_on && !on {
            return Some(Outcome::OffRoad);
        }
        self.was_on |= on;
        if self.reached.is_none() {
            let network = &self.scenario.network;
            self.reached = driver.problem().reached(step, &motion, network);
        }
        let reached = self.reached.filter(|_| step >= self.goal_from);
        reached.map(Outcome::Goal)
    }
}

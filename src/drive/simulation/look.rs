//! What ends a drive: contact, the edge of the road, the goal.

use super::{Collision, Driver, Outcome};
use crate::planner::VehicleState;
use nearmiss_base::geometry::Pose;
use nearmiss_scene::scenario::Scenario;

/// What ends a drive, state by state.
#[derive(Debug, Clone)]
pub struct Look<'a> {
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

impl<'a> Look<'a> {
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

//! What an evasive trajectory asks of its driver: how hard it brakes and steers, which rules it breaks, and whether it
//! leaves the lanelets of cars.

use super::{ClosedLoop, Effect, EvasiveTrajectory};
use crate::planner::VehicleState;
use crate::scenario::RoadUser;
use crate::traffic_rules::RuleReport;

/// What it asks.
#[derive(Debug, Clone)]
pub struct EvasiveReview {
    /// The largest acceleration after the reaction, along and across together, m/s².
    pub acceleration: f64,
    /// Which traffic rules apply to it, and which it breaks.
    pub rules: RuleReport,
    /// The first step after the reaction at which the body, until then on lanelets of cars, is partly on one that no car
    /// may use: a sidewalk or a bicycle path.
    pub leaves_roadway: Option<i64>,
}

impl EvasiveTrajectory {
    /// Reviews it in the scenario of `effect`.
    #[must_use]
    pub fn review(&self, closed: &ClosedLoop, effect: &Effect) -> EvasiveReview {
        let driver = closed.driver();
        let roadway = effect.scenario.network.drivable_area(Some(RoadUser::Car));
        let body = driver.road().body();
        let mut later = self
            .drive
            .states
            .iter()
            .filter(|(step, _)| *step > self.reaction);
        let squares = later.clone().map(|(_, state)| {
            let across = state.velocity * state.velocity * state.curvature;
            state.acceleration.hypot(across)
        });
        let on_roadway =
            |state: &VehicleState| roadway.covers(&body.at(state.centre(&self.drive.limits).pose));
        let mut until = { self.drive.states.iter() }.filter(|(step, _)| *step <= self.reaction);
        let was_on = until
            .next_back()
            .is_some_and(|(_, state)| on_roadway(state));
        EvasiveReview {
            acceleration: squares.fold(0.0, f64::max),
            rules: self
                .drive
                .rules(&effect.scenario, driver.problem(), driver.settings()),
            leaves_roadway: { later.find(|(_, state)| was_on && !on_roadway(state)) }
                .map(|(step, _)| *step),
        }
    }
}

impl EvasiveReview {
    /// The names of the rules that it breaks.
    #[must_use]
    pub fn broken(&self) -> Vec<&'static str> {
        self.rules.broken().map(|rule| rule.name()).collect()
    }

    /// The names of the rules that cannot be judged.
    #[must_use]
    pub fn undecided(&self) -> Vec<&'static str> {
        self.rules.undecided().map(|rule| rule.name()).collect()
    }
}

//! What an evasive trajectory asks of its driver: how hard it brakes and steers, which rules it breaks, and whether it
//! leaves the lanelets of cars.

use super::{ClosedLoop, Effect, EvasiveTrajectory};
use crate::planner::VehicleState;
use nearmiss_scene::scenario::RoadUser;
use nearmiss_scene::traffic_rules::RuleReport;

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
        let later = { self.drive.states.iter() }.filter(|(step, _)| *step > self.reaction);
        let used = later.map(|(_, state)| {
            let across = state.velocity * state.velocity * state.curvature;
            state.acceleration.hypot(across)
        });
        EvasiveReview {
            acceleration: used.fold(0.0, f64::max),
            rules: self
                .drive
                .rules(&effect.scenario, driver.problem(), driver.settings()),
            leaves_roadway: self.leaves_roadway(closed, effect),
        }
    }

    fn leaves_roadway(&self, closed: &ClosedLoop, effect: &Effect) -> Option<i64> {
        let network = &effect.scenario.network;
        if network.lanelets.iter().all(|l| l.may_use(RoadUser::Car)) {
            // It is on the road all the time.
            return None;
        }
        let roadway = network.drivable_area(Some(RoadUser::Car));
        let body = closed.driver().road().body();
        let is_on =
            |state: &VehicleState| roadway.covers(&body.at(state.centre(&self.drive.limits).pose));
        let (until, later): (Vec<_>, Vec<_>) =
            { self.drive.states.iter() }.partition(|(step, _)| *step <= self.reaction);
        until.last().filter(|(_, state)| is_on(state))?;
        let left = later.iter().find(|(_, state)| !is_on(state));
        left.map(|(step, _)| *step)
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

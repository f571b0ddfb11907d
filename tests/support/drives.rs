//! Drives of the planner through a scenario, without anything around them.

use nearmiss::scenario::{PlanningProblem, Scenario};
use nearmiss::simulation::{DriveError, Driver, Rollout, Settings};

/// Drives the ego of a planning problem to the end.
pub fn drive(
    scenario: &Scenario,
    problem: &PlanningProblem,
    settings: &Settings,
) -> Result<Rollout, DriveError> {
    let driver = Driver::new(scenario, problem, settings)?;
    Ok(driver.drive(scenario, &driver.full_span()))
}

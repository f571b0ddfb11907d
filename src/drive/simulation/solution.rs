//! A drive as a CommonRoad solution.

use super::Rollout;
use nearmiss_formats::commonroad::{ProblemSolution, Solution, SolutionError};
use nearmiss_scene::scenario::{Header, VehicleModel, VehicleType};

impl Rollout {
    /// The solution of planning problem `problem` of the scenario with this header: states of `model` for `vehicle`.
    ///
    /// # Errors
    /// The model has states that do not follow from the motion of a body.
    pub fn solution(
        &self,
        header: &Header,
        problem: i64,
        model: VehicleModel,
        vehicle: VehicleType,
    ) -> Result<Solution, SolutionError> {
        let solved = ProblemSolution::of_track(&self.track(), self.dt, problem, model, vehicle)?;
        Ok(Solution::of_problem(header, solved))
    }
}

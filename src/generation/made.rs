//! From a scenario to its dangerous variant, without any model.

use std::sync::Arc;

use super::attack::Ground;
use super::closed_loop::NEAR_MISS;
use super::{Chosen, ClosedLoop, Effort, Found, Gate, Stage, choose, search_watched};
use crate::scenario::{Ego, PlanningProblem, Scenario};
use crate::simulation::{Collision, DriveError, Outcome, Settings};

/// A scenario whose ego has been driven once, ready to be attacked.
#[derive(Debug)]
pub struct Workshop {
    /// What drives the ego, and its drive in the scenario as it was recorded.
    pub closed: ClosedLoop,
    /// The ego of that drive.
    pub ego: Ego,
}

/// What was made.
#[derive(Debug)]
pub struct Made {
    /// Everything that was tried.
    pub found: Found,
    /// What was taken.
    pub chosen: Option<Chosen>,
}

impl Made {
    fn nothing() -> Self {
        Self {
            found: Found::default(),
            chosen: None,
        }
    }
}

/// Why nothing can be made.
#[derive(Debug, thiserror::Error)]
pub enum WorkshopError {
    /// The ego cannot be driven.
    #[error(transparent)]
    Drive(#[from] DriveError),
    /// Nobody can be attacked who stands.
    #[error("the planned ego never moves, so there is nothing to attack")]
    Stands,
}

impl Workshop {
    /// Drives the ego of a planning problem.
    ///
    /// # Errors
    /// See [`WorkshopError`].
    pub fn new(
        scenario: Arc<Scenario>,
        problem: &PlanningProblem,
        settings: &Settings,
    ) -> Result<Self, WorkshopError> {
        let closed = ClosedLoop::new(scenario, problem, settings)?;
        let ego = closed.baseline().drive().ego(problem, settings);
        let workshop = Self { closed, ego };
        workshop.stage().ok_or(WorkshopError::Stands)?;
        Ok(workshop)
    }

    fn stage(&self) -> Option<Stage<'_>> {
        Stage::new(self.closed.scenario(), &self.ego.footprint, &self.ego.track)
    }

    /// Gives the ground for attacks to `work`.
    ///
    /// # Errors
    /// The ego stands.
    pub fn on<T>(&self, work: impl FnOnce(&Ground<'_>) -> T) -> Result<T, WorkshopError> {
        let stage = self.stage().ok_or(WorkshopError::Stands)?;
        let gate = self.gate();
        Ok(work(&Ground {
            stage: &stage,
            gate: &gate,
            closed_loop: &self.closed,
        }))
    }

    /// What every changed motion has to pass.
    #[must_use]
    pub fn gate(&self) -> Gate<'_> {
        Gate::new(self.closed.scenario()).with_ego(&self.ego)
    }

    /// The contact that the ego has in the original scenario: then that is not safe, and nothing is to be made dangerous.
    #[must_use]
    pub fn unsafe_already(&self) -> Option<Collision> {
        match self.closed.baseline().drive().outcome {
            Outcome::Collision(collision) => Some(collision),
            _ => None,
        }
    }

    /// Whether nobody comes near to the ego in the original: it touches nobody, and no risk score in it is that of a near
    /// miss or lower. Otherwise that is no safe scenario, and what is made of it proves less.
    #[must_use]
    pub fn is_safe(&self) -> bool {
        let lowest = self.closed.baseline().lowest();
        self.unsafe_already().is_none() && lowest.is_none_or(|score| score > NEAR_MISS)
    }

    /// Searches, and takes the most dangerous attack that a good driver survives; `only` names the one obstacle that
    /// may attack. After each round `watch` says whether to go on. Nothing is tried where the original is not safe.
    ///
    /// # Errors
    /// The ego stands.
    pub fn search(
        &self,
        effort: &Effort,
        only: Option<i64>,
        watch: &dyn Fn() -> bool,
    ) -> Result<Made, WorkshopError> {
        if self.unsafe_already().is_some() {
            return Ok(Made::nothing());
        }
        self.on(|ground| {
            let found = search_watched(ground, effort, only, &mut |_| watch());
            let chosen = choose(&self.closed, &found.attacks, effort.delay);
            Made { found, chosen }
        })
    }
}

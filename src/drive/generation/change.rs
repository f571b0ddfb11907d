//! A changed motion for one obstacle, and the scenario with it.

use nearmiss_scene::scenario::{Motion, Obstacle, ObstacleRole, Scenario};

/// Another motion for one obstacle.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// The obstacle's id.
    pub obstacle: i64,
    /// Time steps and the motion of the body's centre, in order, one a step. The first one is the recorded state that
    /// it departs from; what was recorded before stays, what was recorded after is gone.
    pub motions: Vec<(i64, Motion)>,
}

/// Why a change cannot be applied to a scenario.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ChangeError {
    /// No such obstacle.
    #[error("no obstacle {0} in the scenario")]
    NoSuchObstacle(i64),
    /// Static and phantom obstacles cannot be given a motion.
    #[error("obstacle {0} does not move")]
    DoesNotMove(i64),
    /// It has nothing to begin with, or is not there at its first step.
    #[error("obstacle {0} is absent at the step where its motion should change")]
    NotThere(i64),
    /// One obstacle cannot have two motions.
    #[error("obstacle {0} is given two motions")]
    Twice(i64),
    /// A joint change of no obstacle is none.
    #[error("no obstacle is given another motion")]
    Nothing,
}

impl Change {
    /// The step of the recorded state that it departs from.
    #[must_use]
    pub fn from(&self) -> Option<i64> {
        self.motions.first().map(|(step, _)| *step)
    }

    /// The last step with a motion.
    #[must_use]
    pub fn until(&self) -> Option<i64> {
        self.motions.last().map(|(step, _)| *step)
    }

    /// The scenario with this motion in it, everything else as it is: its name and its hash, too.
    ///
    /// Changed states say position, orientation, velocity and acceleration; what else the recorded ones said (yaw
    /// rates, steering angles, signals) would not be true of them and is left out.
    ///
    /// # Errors
    /// The obstacle does not exist, does not move, or is absent when the change begins.
    pub fn apply(&self, scenario: &Scenario) -> Result<Scenario, ChangeError> {
        let mut changed = scenario.clone();
        self.apply_to(&mut changed)?;
        Ok(changed)
    }

    /// Gives the obstacle its motion in a scenario, which stays as it is if that fails.
    pub(super) fn apply_to(&self, scenario: &mut Scenario) -> Result<(), ChangeError> {
        let id = self.obstacle;
        let place = scenario
            .obstacles
            .iter()
            .position(|o| o.id == id)
            .ok_or(ChangeError::NoSuchObstacle(id))?;
        let changed = self.changed(&scenario.obstacles[place], scenario.dt())?;
        scenario.obstacles[place] = changed;
        Ok(())
    }

    fn changed(&self, obstacle: &Obstacle, dt: f64) -> Result<Obstacle, ChangeError> {
        let id = obstacle.id;
        if obstacle.role != ObstacleRole::Dynamic {
            return Err(ChangeError::DoesNotMove(id));
        }
        if obstacle.initial.is_none() {
            return Err(ChangeError::DoesNotMove(id));
        }
        let changed = obstacle.departing(&self.motions, dt);
        changed.ok_or(ChangeError::NotThere(id))
    }
}

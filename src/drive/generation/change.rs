//! Changed motions for one obstacle or several at once, and the scenario with them.

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

/// At most so many obstacles attack together.
pub const MOST_ATTACKERS: usize = 3;

/// Other motions for one obstacle or several, each of its own; at least one.
#[derive(Debug, Clone, PartialEq)]
pub struct JointChange {
    changes: Vec<Change>,
}

impl JointChange {
    /// These changes together, in their order.
    ///
    /// # Errors
    /// There is none, or two are of the same obstacle.
    pub fn new(changes: Vec<Change>) -> Result<Self, ChangeError> {
        if changes.is_empty() {
            return Err(ChangeError::Nothing);
        }
        for (place, change) in changes.iter().enumerate() {
            if changes[..place]
                .iter()
                .any(|c| c.obstacle == change.obstacle)
            {
                return Err(ChangeError::Twice(change.obstacle));
            }
        }
        Ok(Self { changes })
    }

    /// The same with a change of another obstacle, which comes last.
    ///
    /// # Errors
    /// It is of one of these obstacles.
    pub fn with(&self, change: Change) -> Result<Self, ChangeError> {
        let mut changes = self.changes.clone();
        changes.push(change);
        Self::new(changes)
    }

    /// The same but for one obstacle, which moves as recorded; `None` if no change is left.
    #[must_use]
    pub fn without(&self, obstacle: i64) -> Option<Self> {
        let changes = self.changes.iter().filter(|c| c.obstacle != obstacle);
        Self::new(changes.cloned().collect()).ok()
    }

    /// The change of each obstacle, in their order.
    #[must_use]
    pub fn changes(&self) -> &[Change] {
        &self.changes
    }

    /// The obstacles that move otherwise.
    pub fn obstacles(&self) -> impl Iterator<Item = i64> + '_ {
        self.changes.iter().map(|c| c.obstacle)
    }

    /// The step of the last state before the first of them moves otherwise.
    #[must_use]
    pub fn from_step(&self) -> Option<i64> {
        self.changes.iter().filter_map(Change::from).min()
    }

    /// The last step with a changed motion.
    #[must_use]
    pub fn until_step(&self) -> Option<i64> {
        self.changes.iter().filter_map(Change::until).max()
    }

    /// The scenario with these motions in it, see [`Change::apply`].
    ///
    /// # Errors
    /// One of the obstacles does not exist, does not move, or is absent when its change begins.
    pub fn apply(&self, scenario: &Scenario) -> Result<Scenario, ChangeError> {
        let mut changed = scenario.clone();
        for change in &self.changes {
            change.apply_to(&mut changed)?;
        }
        Ok(changed)
    }
}

impl From<Change> for JointChange {
    fn from(change: Change) -> Self {
        Self {
            changes: vec![change],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use nearmiss_base::geometry::Pose;
    use nearmiss_scene::scenario::Motion;

    fn change(obstacle: i64, steps: std::ops::Range<i64>) -> Change {
        let motion = Motion {
            pose: Pose::new(0.0, 0.0, 0.0),
            velocity: 0.0,
            acceleration: 0.0,
        };
        Change {
            obstacle,
            motions: steps.map(|step| (step, motion)).collect(),
        }
    }

    #[test]
    fn it_lasts_from_the_first_change_to_the_last() {
        let first = JointChange::from(change(7, 5..9));
        let both = first.with(change(3, 2..6)).ok();
        let both = both.as_ref();
        assert_eq!(both.and_then(JointChange::from_step), Some(2));
        assert_eq!(both.and_then(JointChange::until_step), Some(8));
        let ids: Option<Vec<i64>> = both.map(|b| b.obstacles().collect());
        assert_eq!(ids, Some(vec![7, 3]));
        assert_eq!(both.and_then(|b| b.without(3)), Some(first.clone()));
        assert_eq!(first.without(7), None);
        assert_eq!(first.with(change(7, 1..2)), Err(ChangeError::Twice(7)));
        assert_eq!(JointChange::new(Vec::new()), Err(ChangeError::Nothing));
    }
}

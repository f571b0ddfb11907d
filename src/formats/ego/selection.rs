//! Ego selection: the one beside the scenario, one from another file, or an obstacle.

use std::path::PathBuf;
use std::sync::Arc;

use super::{EgoError, PlannerDrives, read_ego_file};
use crate::Entry;
use nearmiss_scene::scenario::{Ego, Scenario, Scene};

/// Choice of a scenario's ego.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EgoSelection {
    /// The one whose file lies with the scenario; see [`super::find_recording`].
    #[default]
    Beside,
    /// The one whose file lies with the scenario, which solves several planning problems or holds several vehicles.
    BesideFor {
        /// The planning problem whose vehicle it is.
        planning_problem: i64,
    },
    /// The obstacle with this id.
    Obstacle(i64),
    /// The one in a file.
    File {
        /// A recording, a log or a solution.
        path: PathBuf,
        /// The planning problem whose vehicle it is, where the file solves several.
        planning_problem: Option<i64>,
    },
    /// The one that a planner drove.
    Planner(PlannerDrives),
}

impl EgoSelection {
    /// The drives of a planner, where they are chosen.
    #[must_use]
    pub fn planner(&self) -> Option<&PlannerDrives> {
        match self {
            Self::Planner(drives) => Some(drives),
            _ => None,
        }
    }

    /// This ego of the scenario of an entry; nothing where it was to lie beside it and does not.
    ///
    /// # Errors
    /// The file cannot be read or has no such ego, or the obstacle cannot be one.
    pub fn resolve(
        &self,
        entry: &Entry,
        scenario: &Arc<Scenario>,
    ) -> Result<Option<Ego>, EgoError> {
        match self {
            Self::Beside => entry.recorded_ego(scenario),
            Self::BesideFor { planning_problem } => {
                entry.recorded_ego_for(scenario, Some(*planning_problem))
            }
            Self::Obstacle(id) if own(scenario) == Some(*id) => entry.recorded_ego(scenario),
            Self::Obstacle(id) => match Scene::with_obstacle_as_ego(Arc::clone(scenario), *id) {
                Ok(scene) => Ok(Some(scene.ego)),
                Err(source) => Err(EgoError::Obstacle {
                    file: entry.display(),
                    source,
                }),
            },
            Self::File {
                path,
                planning_problem,
            } => read_ego_file(path, scenario, *planning_problem).map(Some),
            Self::Planner(drives) => drives.resolve(&entry.display(), scenario).map(Some),
        }
    }
}

/// The track that is the ego of a recording.
fn own(scenario: &Scenario) -> Option<i64> {
    scenario.recorded_ego.as_ref().map(|own| own.obstacle.id)
}

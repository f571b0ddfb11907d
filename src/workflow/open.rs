//! Opens a scenario with its ego, optionally with a changed scene.

use std::sync::Arc;

use nearmiss_formats::commonroad::ReadError;
use nearmiss_formats::{EgoError, EgoSelection, Entry};
use nearmiss_scene::scenario::{Scenario, Scene, Transform};

use super::StandIn;

/// A request to open a scenario.
#[derive(Debug, Clone, Copy)]
pub struct OpenRequest<'a> {
    /// The scenario.
    pub entry: &'a Entry,
    /// Its ego. An obstacle is named as it is called after the change.
    pub ego: &'a EgoSelection,
    /// What of the scene is changed.
    pub transform: Option<Transform>,
    /// Whether a file beside the scenario that cannot be used is an error; otherwise the scenario has no ego then.
    pub strict: bool,
    /// Who is the ego where none lies beside it.
    pub stand_in: StandIn<'a>,
}

/// A scenario, and the scene with its ego or why there is none.
#[derive(Debug, Clone)]
pub struct OpenedScene {
    /// The scenario, changed if that was asked for.
    pub scenario: Arc<Scenario>,
    /// The same with its ego.
    pub scene: Result<Arc<Scene>, MissingEgo>,
    /// Whether the ego stands in for one that is not recorded, see [`StandIn`].
    pub stands_in: bool,
}

/// Why a scenario was opened without an ego.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MissingEgo {
    /// No file with one lies beside the scenario.
    #[error("no recorded ego beside it")]
    NotRecorded,
    /// No file with one lies beside the scenario, and the built-in planner cannot drive it.
    #[error("no recorded ego beside it, and none is driven: {0}")]
    NotDriven(String),
    /// The file beside it cannot be used, and why.
    #[error("{0}")]
    Unusable(String),
}

/// Why a scenario cannot be opened as requested.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// It cannot be read.
    #[error(transparent)]
    Scenario(#[from] ReadError),
    /// The ego that was asked for cannot be the ego.
    #[error(transparent)]
    Ego(#[from] EgoError),
    /// Only a scene with an ego can be changed.
    #[error("{name} cannot be shown: {why}")]
    Transform {
        /// The name of the changed scene.
        name: String,
        /// Why there is no ego.
        why: MissingEgo,
    },
}

/// The scene of a scenario that was read, with its ego; or that none lies beside it.
///
/// # Errors
/// The ego that was asked for cannot be the ego, or that beside it cannot be used.
pub fn scene_with_ego(
    entry: &Entry,
    scenario: &Arc<Scenario>,
    ego: &EgoSelection,
) -> Result<Result<Arc<Scene>, MissingEgo>, EgoError> {
    let scene = |ego| Arc::new(Scene::new(Arc::clone(scenario), ego));
    let ego = ego.resolve(entry, scenario)?;
    Ok(ego.map(scene).ok_or(MissingEgo::NotRecorded))
}

/// Opens a scenario. Where no ego lies beside it, the one is its ego that was asked for in its place.
///
/// ```
/// use nearmiss_formats::{EgoSelection, bundled};
/// use nearmiss_workflow::{OpenRequest, StandIn, open};
///
/// let opened = open(&OpenRequest {
///     entry: &bundled()[0],
///     ego: &EgoSelection::Beside,
///     transform: None,
///     strict: true,
///     stand_in: StandIn::None,
/// })?;
/// assert!(opened.scene.is_ok());
/// # Ok::<(), nearmiss_workflow::OpenError>(())
/// ```
///
/// # Errors
/// See [`OpenError`].
pub fn open(request: &OpenRequest<'_>) -> Result<OpenedScene, OpenError> {
    let OpenRequest {
        entry,
        ego,
        transform,
        strict,
        stand_in,
    } = *request;
    let scenario = entry.read()?;
    let ego = match (transform, ego) {
        (Some(transform), EgoSelection::Obstacle(id)) => {
            let before = transform.ids(&scenario).get(id).copied();
            &EgoSelection::Obstacle(before.unwrap_or(*id))
        }
        _ => ego,
    };
    let mut stands_in = false;
    let scene = match scene_with_ego(entry, &scenario, ego) {
        Ok(Err(MissingEgo::NotRecorded)) if *ego == EgoSelection::Beside => {
            let scene = stand_in.scene(entry, &scenario);
            stands_in = scene.is_ok();
            scene
        }
        Ok(scene) => scene,
        Err(error) if *ego == EgoSelection::Beside && !strict => {
            Err(MissingEgo::Unusable(error.to_string()))
        }
        Err(error) => return Err(error.into()),
    };
    let Some(transform) = transform else {
        return Ok(OpenedScene {
            scenario,
            scene,
            stands_in,
        });
    };
    let scene = scene.map_err(|why| OpenError::Transform {
        name: transform.name(&entry.name),
        why,
    })?;
    let scene = Arc::new(transform.apply(&scene).scene);
    Ok(OpenedScene {
        scenario: Arc::clone(&scene.scenario),
        scene: Ok(scene),
        stands_in,
    })
}

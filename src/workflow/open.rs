//! Opens a scenario with its ego, optionally with a changed scene.

use std::sync::Arc;

use nearmiss_formats::commonroad::ReadError;
use nearmiss_formats::{EgoError, EgoSelection, Entry};
use nearmiss_scene::scenario::{Scenario, Scene, Transform};

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
}

/// A scenario, and the scene with its ego or why there is none.
#[derive(Debug, Clone)]
pub struct OpenedScene {
    /// The scenario, changed if that was asked for.
    pub scenario: Arc<Scenario>,
    /// The same with its ego.
    pub scene: Result<Arc<Scene>, MissingEgo>,
}

/// Why a scenario was opened without an ego.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MissingEgo {
    /// No file with one lies beside the scenario.
    #[error("no recorded ego beside it")]
    NotRecorded,
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

/// Opens a scenario. Where no ego lies beside it, it has none.
///
/// ```
/// use nearmiss_formats::{EgoSelection, bundled};
/// use nearmiss_workflow::{OpenRequest, open};
///
/// let opened = open(&OpenRequest {
///     entry: &bundled()[0],
///     ego: &EgoSelection::Beside,
///     transform: None,
///     strict: true,
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
    } = *request;
    let scenario = entry.read()?;
    let ego = match (transform, ego) {
        (Some(transform), EgoSelection::Obstacle(id)) => {
            let before = transform.ids(&scenario).get(id).copied();
            &EgoSelection::Obstacle(before.unwrap_or(*id))
        }
        _ => ego,
    };
    let scene = match scene_with_ego(entry, &scenario, ego) {
        Ok(scene) => scene,
        Err(error) if *ego == EgoSelection::Beside && !strict => {
            Err(MissingEgo::Unusable(error.to_string()))
        }
        Err(error) => return Err(error.into()),
    };
    let Some(transform) = transform else {
        return Ok(OpenedScene { scenario, scene });
    };
    let scene = scene.map_err(|why| OpenError::Transform {
        name: transform.name(&entry.name),
        why,
    })?;
    let scene = Arc::new(transform.apply(&scene).scene);
    Ok(OpenedScene {
        scenario: Arc::clone(&scene.scenario),
        scene: Ok(scene),
    })
}

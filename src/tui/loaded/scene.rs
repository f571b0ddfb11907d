//! A scenario with its ego, as it is or after a change under which answers about it are kept.

use std::sync::Arc;

use crate::scenario::{Entry, Scenario, Scene, Transform, WantedEgo};

/// A scenario, and its scene or why there is none.
pub type Read = (Arc<Scenario>, Result<Arc<Scene>, String>);

/// Why there is no ego where nobody asked for one: none was recorded.
pub const NONE_BESIDE: &str = "no recorded ego beside it";

/// Reads a scenario and its scene; why there is no scene, where it has no ego. An ego that lies beside it is looked for,
/// and where it is missing or broken, there is none. An obstacle as the ego is called as it is after the change.
///
/// # Errors
/// It cannot be read, the obstacle or file that was asked for cannot be the ego, or it has none, without which nothing
/// can be changed.
pub fn changed_scene(
    entry: &Entry,
    wanted: &WantedEgo,
    change: Option<Transform>,
) -> Result<Read, String> {
    let scenario = entry.read().map_err(|e| e.to_string())?;
    let wanted = match (change, wanted) {
        (Some(change), WantedEgo::Obstacle(id)) => {
            let before = change.ids(&scenario).get(id).copied();
            &WantedEgo::Obstacle(before.unwrap_or(*id))
        }
        _ => wanted,
    };
    let scene = match wanted.of(entry, &scenario) {
        Ok(Some(ego)) => Ok(Arc::new(Scene::new(scenario.clone(), ego))),
        Ok(None) => Err(NONE_BESIDE.to_string()),
        Err(error) if *wanted == WantedEgo::Beside => Err(error.to_string()),
        Err(error) => return Err(error.to_string()),
    };
    let Some(change) = change else {
        return Ok((scenario, scene));
    };
    let scene = scene.map_err(|why| {
        let name = change.name(&entry.name);
        format!("{name} cannot be shown: {why}")
    })?;
    let scene = Arc::new(change.apply(&scene).scene);
    Ok((scene.scenario.clone(), Ok(scene)))
}

//! Scenes that are looked at before and after a change, and what counts as the same.

use crate::support::recorded::folder;

use nearmiss::formats::{Entry, find};
use nearmiss::metrics::Reading;
use nearmiss::scenario::Scene;

/// Whether two readings are the same; `sign` turns the first one.
pub fn same(a: Reading, b: Reading, sign: f64) -> bool {
    match (a, b) {
        (Reading::Value(a), Reading::Value(b)) => {
            // Very long times and distances are compared by their digits.
            (sign * a - b).abs() <= 1e-6 * a.abs().max(1.0)
        }
        (a, b) => a == b,
    }
}

/// A scenario with its recorded ego, where it has one.
pub fn opened(entry: &Entry) -> Option<Scene> {
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap()?;
    Some(Scene::new(scenario, ego))
}

/// All changes of all scenes instead of a sample: set this to look closely (minutes without optimisation).
pub fn thorough() -> bool {
    std::env::var_os("NEARMISS_ALL_MOVES").is_some()
}

/// Those of all changes that the scene at a place has, so many: each is on one scene or another.
pub fn some<T: Copy>(all: &[T], place: usize, count: usize) -> Vec<T> {
    let count = if thorough() { all.len() } else { count };
    let all = all.iter().copied().cycle();
    all.skip(place * count).take(count).collect()
}

/// Fails where there is any difference.
pub fn none(found: &[String]) {
    let shown = &found[..found.len().min(40)];
    assert!(found.is_empty(), "{} differences: {shown:#?}", found.len());
}

/// One in so many of the published scenes with a recorded ego, with their names; nothing where they are not on this
/// machine.
pub fn recorded(every: usize) -> Option<impl Iterator<Item = (String, Scene)>> {
    let published = folder()?;
    let scenes = find(&[published])
        .unwrap()
        .entries
        .into_iter()
        .filter_map(|entry| opened(&entry).map(|scene| (entry.name, scene)));
    Some(scenes.step_by(if thorough() { 1 } else { every }))
}

//! Scenarios between requests: those that stay open, in bounds, and all of them by their most severe moment.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use nearmiss_scene::corpus::worst_moments;
use nearmiss_scene::metrics::{
    Context, CriticalMoment, SEVERITY_NAMES, Thresholds, critical_moments,
};
use nearmiss_scene::scenario::{Scenario, Scene};
use nearmiss_workflow::INDEX_RADIUS;
use serde::Serialize;

/// Scenarios that are kept, and the bytes of their files; in memory a scenario takes some 15 times as many. One that is
/// larger is kept alone.
const MAX_OPEN: usize = 64;

const MAX_OPEN_BYTES: u64 = 64 << 20;

/// A scene is counted as this part of the bytes of its scenario: it has a list of obstacles of its own.
const SCENE: u64 = 16;

/// What is kept, that used last at the end.
#[derive(Debug, Default)]
pub struct Scenes(Mutex<Vec<OpenScenario>>);

/// A file with the time of its last change and its length.
pub type Read = (PathBuf, Option<(SystemTime, u64)>);

#[derive(Debug)]
struct OpenScenario {
    name: String,
    files: Vec<Read>,
    scenario: Arc<Scenario>,
    scenes: Vec<KeptScene>,
}

/// A scene by the obstacle that is its ego, if one was chosen, with the files that its ego was read from.
#[derive(Debug)]
struct KeptScene {
    obstacle: Option<i64>,
    files: Vec<Read>,
    scene: Arc<Scene>,
}

/// A file as it is now.
pub fn as_is(file: &Path) -> Read {
    let version = || {
        let meta = std::fs::metadata(file).ok()?;
        Some((meta.modified().ok()?, meta.len()))
    };
    (file.to_path_buf(), version())
}

/// Whether files are as they were read.
fn are_current(files: &[Read]) -> bool {
    files.iter().all(|read| as_is(&read.0) == *read)
}

impl OpenScenario {
    fn bytes(&self) -> u64 {
        let lengths = self
            .files
            .iter()
            .filter_map(|(_, version)| Some(version.as_ref()?.1));
        let bytes: u64 = lengths.sum();
        bytes + bytes / SCENE * self.scenes.len() as u64
    }
}

impl Scenes {
    /// The scenario with a name, if it was read and its files are still the same; and its scene with this ego, if that
    /// was made and is still the same.
    pub fn get(
        &self,
        name: &str,
        obstacle: Option<i64>,
        recorded: Option<&Path>,
    ) -> Option<(Arc<Scenario>, Option<Arc<Scene>>)> {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let place = all.iter().position(|kept| kept.name == name)?;
        let kept = all.remove(place);
        if !are_current(&kept.files) {
            return None;
        }
        let same = |known: &&KeptScene| {
            // One that was recorded since counts, too.
            let is_read = |file: &Path| known.files.iter().any(|(read, _)| read == file);
            known.obstacle == obstacle
                && are_current(&known.files)
                && (obstacle.is_some() || recorded.is_none_or(is_read))
        };
        let scene = kept.scenes.iter().find(same);
        let scene = scene.map(|known| Arc::clone(&known.scene));
        let found = (Arc::clone(&kept.scenario), scene);
        all.push(kept);
        Some(found)
    }

    /// Keeps a scenario that was read from these files.
    pub fn keep(&self, name: &str, files: Vec<Read>, scenario: &Arc<Scenario>) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|kept| kept.name != name);
        all.push(OpenScenario {
            name: name.into(),
            files,
            scenario: Arc::clone(scenario),
            scenes: Vec::new(),
        });
        shrink(&mut all);
    }

    /// Keeps a scene of a scenario that is kept, with the files that its ego was read from.
    pub fn keep_scene(
        &self,
        name: &str,
        obstacle: Option<i64>,
        files: Vec<Read>,
        scene: &Arc<Scene>,
    ) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(kept) = all.iter_mut().find(|kept| kept.name == name) else {
            return;
        };
        kept.scenes.retain(|known| known.obstacle != obstacle);
        kept.scenes.push(KeptScene {
            obstacle,
            files,
            scene: Arc::clone(scene),
        });
        shrink(&mut all);
    }
}

/// Lets go of what was not used for the longest time.
fn shrink(all: &mut Vec<OpenScenario>) {
    while all.len() > MAX_OPEN || all.iter().map(OpenScenario::bytes).sum::<u64>() > MAX_OPEN_BYTES
    {
        match &mut all[..] {
            [only] if only.scenes.len() > 1 => drop(only.scenes.remove(0)),
            [] | [_] => return,
            _ => drop(all.remove(0)),
        }
    }
    for kept in all {
        let more = kept.scenes.len().saturating_sub(MAX_OPEN);
        kept.scenes.drain(..more);
    }
}

/// A most severe moment, as clients are told of it.
#[derive(Debug, Clone, Serialize)]
pub struct Worst {
    /// 0 (contact) to 5 (none).
    severity: u8,
    /// The name of that number.
    called: &'static str,
    /// The time step.
    at: i64,
    /// The obstacle that is the ego, where none is recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    ego: Option<i64>,
    obstacle: i64,
    /// The type of the obstacle.
    #[serde(rename = "type")]
    kind: &'static str,
    /// What happens.
    why: String,
    #[serde(skip)]
    moment: CriticalMoment,
}

impl Worst {
    fn new(scenario: &Scenario, ego: Option<i64>, moment: CriticalMoment) -> Self {
        let mut all = scenario.obstacles.iter();
        let obstacle = all.find(|one| one.id == moment.obstacle);
        let severity = moment.grade.number();
        Self {
            severity,
            called: SEVERITY_NAMES[usize::from(severity)],
            at: moment.step,
            ego,
            obstacle: moment.obstacle,
            kind: obstacle.map_or("unknown", |one| one.kind.name()),
            why: moment.hazard.to_string(),
            moment,
        }
    }

    /// The most severe moment with each obstacle, the most severe first; without an ego that of each road user.
    pub fn all(
        scenario: &Arc<Scenario>,
        scene: Option<&Scene>,
        thresholds: &Thresholds,
    ) -> Vec<Self> {
        match scene {
            Some(scene) => { critical_moments(&Context::under(scene, thresholds)).into_iter() }
                .map(|moment| Self::new(scenario, None, moment))
                .collect(),
            None => {
                let egos = scenario.possible_egos();
                { worst_moments(scenario, &egos, INDEX_RADIUS, thresholds).into_iter() }
                    .map(|worst| Self::new(scenario, Some(worst.ego), worst.moment))
                    .collect()
            }
        }
    }
}

/// A scenario of the list.
#[derive(Debug, Clone, Serialize)]
pub struct Ranked {
    /// Its name.
    scenario: String,
    #[serde(flatten)]
    worst: Option<Worst>,
    /// Why it cannot be opened.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

impl Ranked {
    /// A scenario with its most severe moment, or why it cannot be opened.
    pub fn new(scenario: String, worst: Result<Option<Worst>, String>) -> Self {
        let (worst, error) = match worst {
            Ok(worst) => (worst, None),
            Err(why) => (None, Some(why)),
        };
        Self {
            scenario,
            worst,
            error,
        }
    }

    /// Sorts the most severe ones first, and those that cannot be opened last.
    pub fn sort(all: &mut [Self]) {
        let rank = |one: &Self| (one.error.is_some(), one.worst.is_none());
        all.sort_by(|a, b| {
            let by_moment = || {
                Some(
                    a.worst
                        .as_ref()?
                        .moment
                        .compare_across(&b.worst.as_ref()?.moment),
                )
            };
            let by_rank = rank(a).cmp(&rank(b));
            by_rank.then_with(|| by_moment().unwrap_or(std::cmp::Ordering::Equal))
        });
    }
}

/// What was measured so far, by place.
#[derive(Debug, Default)]
pub struct Ranks(Mutex<HashMap<String, Measured>>);

/// What a scenario was read from, and its most severe moment.
type Measured = (Vec<Read>, Option<Worst>);

impl Ranks {
    /// What was measured of a scenario, if its files, with the recording beside it, are still the same.
    pub fn get(&self, place: &str, recorded: Option<&Path>) -> Option<Option<Worst>> {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (files, worst) = all.get(place)?;
        let is_read = |file: &Path| files.iter().any(|(read, _)| read == file);
        (recorded.is_none_or(is_read) && are_current(files)).then(|| worst.clone())
    }

    /// Keeps what was measured.
    pub fn keep(&self, place: String, files: Vec<Read>, worst: Option<Worst>) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.insert(place, (files, worst));
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_bounded_by_the_bytes_of_its_files() {
        let scenario = nearmiss_formats::bundled()[0].read().unwrap();
        let ids = scenario.possible_egos();
        let scene = |id: i64| {
            let scene = Scene::with_obstacle_as_ego(Arc::clone(&scenario), id);
            Arc::new(scene.unwrap())
        };
        let folder = tempfile::tempdir().unwrap();
        let scenes = Scenes::default();
        // Sparse files cost no room.
        let keep = |name: &str, mebibytes: u64| {
            let file = folder.path().join(name);
            std::fs::File::create(&file)
                .unwrap()
                .set_len(mebibytes << 20)
                .unwrap();
            scenes.keep(name, vec![as_is(&file)], &scenario);
        };
        let there = |name: &str| scenes.get(name, None, None).is_some();
        (0..100).for_each(|i| keep(&format!("small{i}"), 0));
        assert!(there("small99") && there("small36") && !there("small35"));
        keep("a", 30);
        keep("b", 30);
        // Used since.
        assert!(there("a") && there("b") && there("a"));
        keep("c", 30);
        assert!(there("a") && !there("b") && there("c") && !there("small99"));
        keep("huge", 200);
        assert!(there("huge") && !there("a") && !there("c"));
        for id in [ids[0], ids[1]] {
            scenes.keep_scene("huge", Some(id), Vec::new(), &scene(id));
        }
        let made = |id: i64| scenes.get("huge", Some(id), None).unwrap().1.is_some();
        assert!(
            made(ids[1]) && !made(ids[0]),
            "the scenario is not read again"
        );
        keep("huge", 201);
        std::fs::write(folder.path().join("huge"), "other").unwrap();
        assert!(!there("huge"), "its file has changed");
    }
}

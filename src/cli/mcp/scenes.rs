//! Scenarios that stay open between requests, in bounds, each read once for all of its egos.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use nearmiss_scene::scenario::{Scenario, Scene};

/// Scenarios that are kept, and the bytes of their files; in memory a scenario takes some 15 times as many. One that is
/// larger is kept alone.
const MOST: usize = 64;
const MOST_BYTES: u64 = 64 << 20;

/// A scene is counted as this part of the bytes of its scenario: it has a list of obstacles of its own.
const SCENE: u64 = 16;

/// What is kept, that used last at the end.
#[derive(Debug, Default)]
pub struct Scenes(Mutex<Vec<Kept>>);

/// A file with the time of its last change and its length.
pub type Read = (PathBuf, Option<(SystemTime, u64)>);

#[derive(Debug)]
struct Kept {
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
pub fn are_current(files: &[Read]) -> bool {
    files.iter().all(|read| as_is(&read.0) == *read)
}

impl Kept {
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
        all.push(Kept {
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
fn shrink(all: &mut Vec<Kept>) {
    while all.len() > MOST || all.iter().map(Kept::bytes).sum::<u64>() > MOST_BYTES {
        match &mut all[..] {
            [only] if only.scenes.len() > 1 => drop(only.scenes.remove(0)),
            [] | [_] => return,
            _ => drop(all.remove(0)),
        }
    }
    for kept in all {
        let more = kept.scenes.len().saturating_sub(MOST);
        kept.scenes.drain(..more);
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

//! Reads an index of a corpus, and which of its windows stored answers are about.

use std::collections::HashMap;
use std::fs::File;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use super::journal::FOLDER;
use nearmiss_drive::planner::Cancel;
use nearmiss_scene::corpus::{CorpusIndex, IndexError, WindowEgo, WindowKey, part_files};
use nearmiss_scene::scenario::obstacle_taken;
use nearmiss_store::{Origin, StoredVerdict};

/// The parts of an index, in order.
///
/// # Errors
/// There is no index in the folder, or `nearmiss corpus index` is still writing it.
pub fn index_parts(folder: &Path) -> Result<Vec<PathBuf>, IndexError> {
    let parts = part_files(folder);
    // Before its first part is there, an index is one all the same.
    if is_being_written(folder) {
        Err(IndexError::BeingWritten(folder.to_path_buf()))
    } else {
        parts
    }
}

/// Whether a run of `nearmiss corpus index` has its journal open.
fn is_being_written(folder: &Path) -> bool {
    let entries = std::fs::read_dir(folder.join(FOLDER)).into_iter().flatten();
    let paths = entries.flatten().map(|entry| entry.path());
    let mut journals = paths.filter(|path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("index") && name.ends_with(".jsonl")
    });
    journals.any(|path| {
        let locked = File::open(path).map(|file| file.try_lock_shared());
        matches!(locked, Ok(Err(std::fs::TryLockError::WouldBlock)))
    })
}

/// Reads an index; `on_rows` is told rows that were read and rows in all. Nothing if it was cancelled.
///
/// # Errors
/// See [`IndexError`].
pub fn read_index(
    folder: &Path,
    answers: &[StoredVerdict],
    cancel: &Cancel,
    on_rows: &mut dyn FnMut(u64, u64),
) -> Result<Option<CorpusIndex>, IndexError> {
    let parts = index_parts(folder)?;
    let asked = AskedWindows::of(answers);
    let mut progress = |rows, all| {
        on_rows(rows, all);
        if cancel.is_asked() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    CorpusIndex::read(
        folder.to_path_buf(),
        &parts,
        &|window| asked.has(window),
        &mut progress,
    )
}

/// The windows that models were asked about.
struct AskedWindows<'a> {
    by_hash: HashMap<&'a str, Vec<&'a StoredVerdict>>,
    by_name: HashMap<&'a str, Vec<&'a StoredVerdict>>,
}

impl<'a> AskedWindows<'a> {
    /// Answers that were recorded or played back do not count: they were not asked for here.
    fn of(answers: &'a [StoredVerdict]) -> Self {
        let mut asked = Self {
            by_hash: HashMap::new(),
            by_name: HashMap::new(),
        };
        for one in answers.iter().filter(|one| one.origin == Origin::Asked) {
            let of = match &one.scenario_hash {
                Some(hash) => asked.by_hash.entry(hash.as_str()),
                None => asked.by_name.entry(one.scenario.as_str()),
            };
            of.or_default().push(one);
        }
        asked
    }

    /// Whether there is an answer about the same ego at a time of the window.
    fn has(&self, window: WindowKey<'_>) -> bool {
        let (by_hash, by_name) = (self.by_hash.get(window.hash), self.by_name.get(window.name));
        let mut answers = by_hash.into_iter().chain(by_name).flatten();
        answers.any(|answer| {
            let same_ego = match window.place.ego {
                WindowEgo::Obstacle(id) => obstacle_taken(&answer.ego) == Some(id),
                WindowEgo::Recorded => {
                    let id = format!("{}, ", window.place.ego_id);
                    let motion = answer.ego.strip_prefix(&id);
                    motion.is_some_and(|motion| {
                        ["recorded in", "driven by", "solution"]
                            .iter()
                            .any(|source| motion.starts_with(source))
                    })
                }
            };
            let (first, last) = window.place.steps;
            let overlaps = |(from, to): (i64, i64)| from <= last && first <= to;
            same_ego && answer.window.is_none_or(overlaps)
        })
    }
}

//! Counts the claims of stored answers that no program checked when they came, opening each scenario once.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::StoredQuestion;
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::scenario::Transform;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{ClaimCounts, Outcome, RunId, RunState, Store, StoreError};
use nearmiss_study::evaluation::{Answer, claims};

/// Whether the claims of an answer are still to be counted: it is whole, and this version's check did not see it.
#[must_use]
pub fn is_unchecked(outcome: &Outcome) -> bool {
    outcome.state == RunState::Answered
        && Task::VERDICTS.contains(&outcome.task)
        && outcome.claims.claims_check != Some(claims::CHECK)
}

/// Counts the claims of those of the answers that [`is_unchecked`], as far as one of the files is their scenario; each
/// scene is opened once, for all answers about it. `on_progress` hears how many of how many scenes are done.
///
/// # Errors
/// The store cannot be read.
pub fn count_claims(
    store: &Store,
    outcomes: &[Outcome],
    files: &[Entry],
    on_progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Vec<(RunId, ClaimCounts)>, StoreError> {
    let mut entries: HashMap<&str, Vec<&Entry>> = HashMap::new();
    for entry in files {
        entries.entry(entry.name.as_str()).or_default().push(entry);
    }
    let mut scenes: BTreeMap<_, Vec<&Outcome>> = BTreeMap::new();
    for one in outcomes.iter().filter(|one| is_unchecked(one)) {
        let name = Transform::of_name(&one.scenario).0;
        if entries.contains_key(name) {
            let scene = (
                &one.scenario,
                &one.scenario_hash,
                &one.ego,
                one.origin.name(),
            );
            scenes.entry(scene).or_default().push(one);
        }
    }
    let (done, of) = (AtomicUsize::new(0), scenes.len());
    let counted: Vec<_> = scenes
        .into_values()
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|asked| {
            let found = of_scene(store, &asked, &entries);
            on_progress(done.fetch_add(1, Ordering::Relaxed) + 1, of);
            found
        })
        .collect::<Result<_, _>>()?;
    Ok(counted.into_iter().flatten().collect())
}

/// The scenarios of all batches.
///
/// # Errors
/// The store cannot be read.
pub fn files_of_batches(store: &Store) -> Result<Vec<Entry>, StoreError> {
    let mut paths = BTreeSet::new();
    for (batch, _) in store.batches()? {
        for item in store.items(batch.id)? {
            paths.insert(item.asked.path);
        }
    }
    let paths = paths.iter().map(Path::new);
    Ok(paths.map(Entry::of_argument).collect())
}

/// The counts of answers about one scene; none if no file holds it.
fn of_scene(
    store: &Store,
    asked: &[&Outcome],
    entries: &HashMap<&str, Vec<&Entry>>,
) -> Result<Vec<(RunId, ClaimCounts)>, StoreError> {
    let Some(first) = asked.first() else {
        return Ok(Vec::new());
    };
    let question = StoredQuestion::from(*first);
    let files = entries.get(Transform::of_name(&first.scenario).0);
    let scene = files
        .into_iter()
        .flatten()
        .find_map(|entry| question.scene(entry, &EgoSelection::Beside));
    let Some(scene) = scene else {
        return Ok(Vec::new());
    };
    let mut found = Vec::new();
    for one in asked {
        if let Some(run) = store.run(one.run)? {
            found.push((one.run, Answer::from(run).claims(&scene)));
        }
    }
    Ok(found)
}

//! Claims of answers that were stored without being checked: counted for the report, and kept.

use std::collections::HashMap;
use std::path::PathBuf;

use super::truth::AUTO;
use crate::filters::store as store_to_write;
use crate::progress::LateProgress;
use crate::{Failure, output};
use nearmiss_formats::{Entry, bundled};
use nearmiss_store::{Outcome as Run, Store};
use nearmiss_workflow::{count_claims, files_of_batches, find, is_unchecked};

/// Counts the claims of answers that have no counts of this version, where their scenario is one of `files`, of the
/// bundled ones, or of a batch; gives what is to be said of the others.
pub fn complete(
    store: &Store,
    runs: &mut [Run],
    mut files: Vec<Entry>,
) -> Result<Option<String>, Failure> {
    if !runs.iter().any(is_unchecked) {
        return Ok(None);
    }
    files.extend(known_files(store)?);
    let progress = LateProgress::new("scenarios");
    let shown = |_, of| progress.step(of);
    let counted = count_claims(store, runs, &files, &shown).map_err(Failure::input)?;
    let by_run: HashMap<_, _> = counted.iter().copied().collect();
    for run in runs.iter_mut() {
        if let Some(counts) = by_run.get(&run.run) {
            run.claims = *counts;
        }
    }
    // Where the store can only be read, they are counted again next time.
    if !counted.is_empty()
        && let Ok(writable) = store_to_write()
        && let Err(error) = writable.keep_claims(&counted)
    {
        output::say(&format!(
            "nearmiss: the counts of claims are not stored: {error}"
        ));
    }
    let left = runs
        .iter()
        .filter(|run| run.claims.known().is_none())
        .filter(|run| is_unchecked(run))
        .count();
    Ok((left > 0).then(|| {
        format!(
            "claims of {} not checked: their scenarios are not at hand; --truth FOLDER names them",
            output::counted(left, "answer")
        )
    }))
}

/// The scenarios that `--truth` names.
pub fn files(sources: &[PathBuf]) -> Vec<Entry> {
    let folders = sources
        .iter()
        .filter(|source| source.as_os_str() != AUTO && source.is_dir());
    folders
        .filter_map(|folder| find(std::slice::from_ref(folder)).ok())
        .flat_map(|found| found.entries)
        .collect()
}

/// The scenarios of all batches and the bundled ones.
pub fn known_files(store: &Store) -> Result<Vec<Entry>, Failure> {
    let mut files = files_of_batches(store).map_err(Failure::input)?;
    files.extend(bundled());
    Ok(files)
}

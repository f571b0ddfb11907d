//! Imports recorded answers from a repository laid out as that of "From Words to Collisions".

use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use super::Counts;
use crate::{Failure, output};
use nearmiss_store::Store;
use nearmiss_study::evaluation::Loss;
use nearmiss_study::paper;

/// Runs that are added in one transaction.
const BATCH: usize = 500;

/// Problems that are named one by one.
const NAMED: usize = 20;

/// Adds the recorded answers below a folder that are not in the store yet.
pub fn import(root: &Path, store: &Store, counts: &mut Counts) -> Result<(), Failure> {
    let now = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or(0, |since| {
            i64::try_from(since.as_millis()).unwrap_or(i64::MAX)
        });
    let (runs, problems) = paper::runs(root, now);
    // What is lost comes first.
    let (lost, others): (Vec<_>, Vec<_>) = problems.iter().partition(|p| p.loss == Loss::Unread);
    for problem in lost.into_iter().chain(others).take(NAMED) {
        output::say(&format!("nearmiss: {problem}"));
    }
    if problems.len() > NAMED {
        let more = problems.len() - NAMED;
        output::say(&format!(
            "nearmiss: {}: {more} more like this",
            root.display()
        ));
    }
    for runs in runs.chunks(BATCH) {
        let added = store.add(runs).map_err(Failure::input)?;
        counts.imported += added;
        counts.already_there += runs.len() - added;
    }
    let lost = |loss| problems.iter().filter(|p| p.loss == loss).count();
    counts.absent += lost(Loss::Absent);
    counts.unreadable += lost(Loss::Unread);
    let without = |run: &&nearmiss_store::Run| run.question.scenario_hash.is_none();
    let loose = runs.iter().filter(without).count();
    if loose > 0 {
        output::say(&format!(
            "nearmiss: {} linked to scenarios by name only: no such files below {}",
            output::counted(loose, "answer"),
            root.display()
        ));
    }
    Ok(())
}

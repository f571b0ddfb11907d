//! What answers are held against: labels, folders, exact geometry or risk scores, and claims that were not checked yet.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use nearmiss_base::system;
use nearmiss_formats::{EgoSelection, Entry, bundled};
use nearmiss_scene::metrics::RiskConvention;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{Outcome as Run, Store};
use nearmiss_study::evaluation::annotations;
use nearmiss_study::evaluation::batch::{Spec, TruthSource};
use nearmiss_study::evaluation::report::{Stored, Truth};
use nearmiss_workflow::{
    TruthChoice, TruthSearch, asked_as, batch_labels, count_claims, files_of_batches, find,
    is_unchecked,
};

use crate::filters::store as store_to_write;
use crate::open::{configuration, user_thresholds};
use crate::output::LateProgress;
use crate::{Failure, output};

/// The word for the exact geometry.
pub const AUTO: &str = "auto";

/// The word for the truth of the batch that an answer is of.
pub const BATCH: &str = "batch";

/// Reads what `--truth` names, for these runs; the usual truth where it names nothing, as the results screen has it.
pub fn truth(sources: &[PathBuf], store: &Store, runs: &[Run]) -> Result<Truth, Failure> {
    let (folders, _) = configuration()?;
    let (ego, thresholds) = (EgoSelection::Beside, &user_thresholds(&folders)?);
    let search = |entries| TruthSearch {
        outcomes: runs,
        entries,
        ego: &ego,
        thresholds,
    };
    let of_batches = batch_labels(store).map_err(Failure::input)?;
    let mut truth = Truth {
        windows: of_batches.windows,
        asked: asked_as(store).map_err(Failure::input)?,
        ..Truth::default()
    };
    let mut entries: Vec<Entry> = Vec::new();
    let score = score(sources)?;
    for source in sources {
        if score_of(source).is_some() {
            truth.scores = Some(HashMap::new());
            entries.extend(bundled());
        } else if source.as_os_str() == BATCH {
            truth.of_batches.clone_from(&of_batches.all);
        } else if source.as_os_str() == AUTO {
            truth.add_stored_geometry(runs);
            entries.extend(bundled());
        } else if source.is_dir() {
            entries.extend(folder(source, &mut truth)?);
        } else {
            labels(source, &mut truth)?;
        }
    }
    let search = search(&entries);
    for (name, label) in search.layout() {
        truth.layout.entry(name).or_insert(label);
    }
    let progress = LateProgress::new("scenarios");
    let shown = |_, of| progress.step(of);
    let never = AtomicBool::new(false);
    // Nothing stops it.
    let choice = score.map_or(TruthChoice::Usual, TruthChoice::Score);
    let _ = search.complete(choice, &mut truth, &never, &shown);
    if score.is_some() {
        let unknown = |run: &&Run| run.task == Task::Safety && truth.score_key(run).is_none();
        match runs.iter().filter(unknown).count() {
            0 => {}
            n => output::say(&format!(
                "nearmiss: {} of the safety task without a truth: the batch that says how far ahead they look is not in the store",
                output::counted(n, "answer")
            )),
        }
    }
    Ok(truth)
}

/// The risk score that a word of `--truth` means.
fn score_of(source: &Path) -> Option<RiskConvention> {
    TruthSource::score(source.to_str()?)
}

/// The risk score that is the truth, if one is: it says something about every question, so only folders of scenarios
/// can stand beside it.
fn score(sources: &[PathBuf]) -> Result<Option<RiskConvention>, Failure> {
    let mut scores = sources.iter().filter_map(|source| score_of(source));
    let Some(score) = scores.next() else {
        return Ok(None);
    };
    let other = |source: &&PathBuf| score_of(source).is_none() && !source.is_dir();
    match sources.iter().find(other) {
        _ if scores.next().is_some() => {
            Err(Failure::input("--truth: use one of score and score:paper"))
        }
        Some(other) => Err(Failure::input(format!(
            "--truth score stands alone or with folders of scenarios; remove {}",
            other.display()
        ))),
        None => Ok(Some(score)),
    }
}

/// The same as a description for the report: for batches, how many answers are compared with which ground truth.
pub fn truth_description(
    sources: &[PathBuf],
    stored: &Stored,
    store: &Store,
) -> Result<String, Failure> {
    let mut words = Vec::new();
    let named = sources.iter().any(|source| source.as_os_str() == BATCH);
    if !named && let Some(batches) = of_batches(stored, store)? {
        words.push(format!("of drawn windows {batches}"));
    }
    for source in sources {
        if let Some(convention) = score_of(source) {
            words.push(TruthSource::score_summary(convention));
        } else if source.as_os_str() == BATCH {
            words.extend(of_batches(stored, store)?);
        } else if source.as_os_str() == AUTO {
            words.push("the exact geometry of recordings".into());
        } else {
            words.push(output::visible(&source.display().to_string()));
        }
    }
    Ok(if words.is_empty() {
        "none; no batch has a truth for these answers".into()
    } else {
        words.join(", then ")
    })
}

/// Batches that are named each.
const MAX_LISTED: usize = 5;

fn of_batches(stored: &Stored, store: &Store) -> Result<Option<String>, Failure> {
    if stored.of_batches.is_empty() {
        return Ok(None);
    }
    let mut parts = Vec::new();
    for (batch, answers) in stored.of_batches.iter().take(MAX_LISTED) {
        let id = batch.parse().ok();
        let known = id
            .map(|id| store.batch(id))
            .transpose()
            .map_err(Failure::input)?
            .flatten();
        let spec = known.and_then(|batch| Spec::from_json(&batch.spec).ok());
        let truth = spec.map_or_else(|| "its own".into(), |spec| spec.truth_summary());
        parts.push(format!(
            "{batch}, {answers} answers: {}",
            output::visible(&truth)
        ));
    }
    if stored.of_batches.len() > MAX_LISTED {
        parts.push("…".into());
    }
    Ok(Some(format!(
        "that of each answer's batch ({})",
        parts.join("; ")
    )))
}

fn labels(file: &Path, truth: &mut Truth) -> Result<(), Failure> {
    let shown = file.display().to_string();
    let bytes = system::read_file(file, system::LARGEST).map_err(|e| {
        Failure::input(format!(
            "--truth {shown}: {}; use CSV files, folders, `batch` for the truth of the batches, `auto` for the exact geometry, or `score` for the risk score",
            system::error_text(&e)
        ))
    })?;
    truth.labels.read(&bytes, &shown).map_err(Failure::input)
}

/// The scenarios of a folder; the annotations in it are labels.
fn folder(folder: &Path, truth: &mut Truth) -> Result<Vec<Entry>, Failure> {
    let annotated = folder.join("Results").join("LLM").is_dir() || folder.join("LLM").is_dir();
    let found = find(&[folder.to_path_buf()]);
    let entries = match (found, annotated) {
        (Ok(found), _) => found.entries,
        (Err(_), true) => Vec::new(),
        (Err(error), false) => return Err(Failure::input(format!("--truth {error}"))),
    };
    if annotated {
        let (labels, problems) = annotations(folder);
        for problem in &problems {
            output::say(&format!("nearmiss: {problem}"));
        }
        for (name, label) in labels.iter() {
            truth.layout.entry(name.to_string()).or_insert(label);
        }
    }
    Ok(entries)
}

/// Counts the claims of answers that have no counts of this version, where their scenario is one of `files`, of the
/// bundled ones, or of a batch; gives what is to be said of the others.
pub fn complete_claims(
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
pub fn claimed_files(sources: &[PathBuf]) -> Vec<Entry> {
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

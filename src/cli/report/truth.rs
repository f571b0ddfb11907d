//! Ground truth for a report: labels, folders, or exact geometry.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::cli::open::scene_beside;
use crate::cli::{Failure, output};
use crate::evaluation::batch::Spec;
use crate::evaluation::report::{Stored, Truth};
use crate::evaluation::{Label, Labelled, annotations};
use crate::formats::{Entry, bundled, find};
use crate::store::Store;
use crate::system;

/// The word for the exact geometry.
pub const AUTO: &str = "auto";

/// The word for the truth of the batch that an answer is of.
pub const BATCH: &str = "batch";

/// Reads what `--truth` names.
pub fn truth(sources: &[PathBuf], store: &Store) -> Result<Truth, Failure> {
    let mut truth = Truth::default();
    for source in sources {
        if source.as_os_str() == BATCH {
            let told = store.truths().map_err(Failure::input)?.into_iter();
            truth.of_batches = told
                .map(|one| {
                    let label = match one.collides {
                        true => Label::Collision(one.obstacle),
                        false => Label::Safe,
                    };
                    (one.run, (one.batch.to_string(), label))
                })
                .collect();
        } else if source.as_os_str() == AUTO {
            truth.judged = true;
            add(&mut truth, geometry(&bundled()));
        } else if source.is_dir() {
            folder(source, &mut truth)?;
        } else {
            labels(source, &mut truth)?;
        }
    }
    Ok(truth)
}

/// The same as a description for the report: for batches, how many answers are compared with which ground truth.
pub fn words(sources: &[PathBuf], stored: &Stored, store: &Store) -> Result<String, Failure> {
    let mut words = Vec::new();
    for source in sources {
        if source.as_os_str() == BATCH {
            words.extend(of_batches(stored, store)?);
        } else if source.as_os_str() == AUTO {
            words.push("the exact geometry of recordings".into());
        } else {
            words.push(output::visible(&source.display().to_string()));
        }
    }
    Ok(match words.is_empty() {
        true => "none; no batch says what is true about these answers".into(),
        false => words.join(", then "),
    })
}

/// Batches that are named each.
const NAMED: usize = 5;

fn of_batches(stored: &Stored, store: &Store) -> Result<Option<String>, Failure> {
    if stored.of_batches.is_empty() {
        return Ok(None);
    }
    let mut parts = Vec::new();
    for (batch, answers) in stored.of_batches.iter().take(NAMED) {
        let id = batch.parse().ok();
        let known = id.map(|id| store.batch(id)).transpose();
        let known = known.map_err(Failure::input)?.flatten();
        let spec = known.and_then(|batch| Spec::from_json(&batch.spec).ok());
        let truth = spec.map_or_else(|| "its own".into(), |spec| spec.truth.words());
        parts.push(format!(
            "{batch}, {answers} answers: {}",
            output::visible(&truth)
        ));
    }
    if stored.of_batches.len() > NAMED {
        parts.push("…".into());
    }
    Ok(Some(format!(
        "that of the batch an answer is of ({})",
        parts.join("; ")
    )))
}

fn labels(file: &Path, truth: &mut Truth) -> Result<(), Failure> {
    let shown = file.display().to_string();
    let bytes = system::read_file(file, system::LARGEST).map_err(|e| {
        Failure::input(format!(
            "--truth {shown}: {}; it takes CSV files, folders, `batch` for the truth of the batches, or `auto` for the exact \
             geometry",
            system::words(&e)
        ))
    })?;
    truth.labels.read(&bytes, &shown).map_err(Failure::input)
}

/// Annotations, and for scenarios without one the exact geometry.
fn folder(folder: &Path, truth: &mut Truth) -> Result<(), Failure> {
    let annotated = folder.join("Results").join("LLM").is_dir() || folder.join("LLM").is_dir();
    let found = find(&[folder.to_path_buf()]);
    let entries = match (found, annotated) {
        (Ok(found), _) => found.entries,
        (Err(_), true) => Vec::new(),
        (Err(error), false) => return Err(Failure::input(format!("--truth {error}"))),
    };
    let mut others = entries;
    if annotated {
        let (labels, problems) = annotations(folder);
        for problem in &problems {
            output::say(&format!("nearmiss: {problem}"));
        }
        others.retain(|entry| labels.get(&entry.name).is_none());
        let labels = labels.iter().map(|(name, label)| (name.to_string(), label));
        add(truth, labels.collect());
    }
    add(truth, geometry(&others));
    Ok(())
}

fn add(truth: &mut Truth, found: Vec<(String, Label)>) {
    for (name, label) in found {
        truth.found.entry(name).or_insert(label);
    }
}

/// The exact geometry of scenarios with a recorded ego; what cannot be opened is said.
fn geometry(entries: &[Entry]) -> Vec<(String, Label)> {
    let judge = |entry: &Entry| match scene_beside(entry) {
        Ok(scene) => {
            Ok(scene.map(|(scene, _)| (entry.name.clone(), Labelled::new(&scene, None).label)))
        }
        Err(failure) => Err(failure),
    };
    let judged: Vec<_> = entries.par_iter().map(judge).collect();
    let mut found = Vec::new();
    for one in judged {
        match one {
            Ok(one) => found.extend(one),
            Err(failure) => failure.say(),
        }
    }
    found
}

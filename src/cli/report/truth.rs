//! What is true about the scenarios of a report: labels, folders, or the exact geometry.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::cli::open::scene_beside;
use crate::cli::{Failure, output};
use crate::evaluation::report::Truth;
use crate::evaluation::{Label, Labelled, recorded};
use crate::scenario::{Entry, bundled, find};
use crate::system;

/// The word for the exact geometry.
pub const AUTO: &str = "auto";

/// Reads what `--truth` names.
pub fn truth(sources: &[PathBuf]) -> Result<Truth, Failure> {
    let mut truth = Truth::default();
    for source in sources {
        if source.as_os_str() == AUTO {
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

/// The same in words, for the report.
pub fn words(sources: &[PathBuf]) -> String {
    let word = |source: &PathBuf| match source.as_os_str() == AUTO {
        true => "the exact geometry of recordings".into(),
        false => output::visible(&source.display().to_string()),
    };
    sources.iter().map(word).collect::<Vec<_>>().join(", then ")
}

fn labels(file: &Path, truth: &mut Truth) -> Result<(), Failure> {
    let shown = file.display().to_string();
    let bytes = system::read_file(file, system::LARGEST).map_err(|e| {
        Failure::input(format!(
            "--truth {shown}: {}; it takes CSV files, folders, or `auto` for the exact geometry",
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
        let (labels, problems) = recorded::truth(folder);
        for problem in &problems {
            output::say(&format!("nearmiss: {problem}"));
        }
        others.retain(|entry| labels.of(&entry.name).is_none());
        let annotations = labels.iter().map(|(name, label)| (name.to_string(), label));
        add(truth, annotations.collect());
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

//! Resumes an earlier run: finished variants are taken over with everything their manifests record.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::Value;

use crate::{Failure, output};
use nearmiss_base::system;
use nearmiss_drive::generation::{Manifest, OutcomeName, PlannerIdentity, VariantFiles};
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::ContentHash;
use nearmiss_workflow::is_unchanged;
use nearmiss_workflow::variant::{GenerationSettings, PROMPTS, VariantLine};

/// Results of an earlier run, by the hash of the original.
#[derive(Debug, Default)]
pub struct EarlierRun {
    variants: HashMap<String, Vec<MadeVariant>>,
}

/// A variant of an earlier run.
#[derive(Debug)]
struct MadeVariant {
    /// SHA-256 of its original, hexadecimal.
    original: String,
    settings: GenerationSettings,
    line: VariantLine,
}

/// What a manifest records for later runs.
#[derive(Deserialize)]
struct Made {
    settings: GenerationSettings,
    line: VariantLine,
}

/// Contents of a file.
enum FileKind {
    /// A variant with all that it was made with.
    Variant(Box<MadeVariant>),
    /// The figures of a run.
    Report,
}

impl EarlierRun {
    /// Contents of `folder`, with descriptions of untrusted files.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn read(folder: &Path) -> Result<(Self, Vec<String>), Failure> {
        let failed = |e: &std::io::Error| Failure::system(folder.display(), e);
        let mut paths = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(|e| failed(&e))? {
            let path = entry.map_err(|e| failed(&e))?.path();
            if path.extension().is_some_and(|ending| ending == "json") {
                paths.push(path);
            }
        }
        // The first of several that fit is taken, in every run the same.
        paths.sort();
        let (mut past, mut doubts) = (Self::default(), Vec::new());
        for path in paths {
            match read(&path) {
                Ok(FileKind::Variant(made)) => {
                    let same = past.variants.entry(made.original.clone()).or_default();
                    same.push(*made);
                }
                Ok(FileKind::Report) => {}
                Err(why) => doubts.push(format!("{}: not reused: {why}", path.display())),
            }
        }
        Ok((past, doubts))
    }

    /// The line of a variant of a scenario with this content that was made with these settings: first of all of one
    /// that was called so.
    pub fn line_for(
        &self,
        entry: &Entry,
        original: &ContentHash,
        settings: &GenerationSettings,
    ) -> Option<VariantLine> {
        let mut same = self
            .variants
            .get(&original.to_string())?
            .iter()
            .filter(|made| made.settings.differences(settings).is_empty());
        let name = output::visible(&entry.name);
        let named = same.clone().find(|made| made.line.scenario == name);
        Some(VariantLine {
            scenario: name,
            file: entry.display(),
            ..named.or_else(|| same.next())?.line.clone()
        })
    }

    /// Which variant of a scenario with this content is nearest to these settings, and why it is not taken over; `None`
    /// where there is none of it.
    pub fn why_not(&self, original: &ContentHash, settings: &GenerationSettings) -> Option<String> {
        let all = self.variants.get(&original.to_string())?.iter();
        let all = all.map(|made| (made, made.settings.differences(settings)));
        let (made, differences) = all.min_by_key(|(_, differences)| differences.len())?;
        let named = &differences[..differences.len().min(MAX_LISTED)];
        let more = match differences.len() - named.len() {
            0 => String::new(),
            n => format!("; and {n} more"),
        };
        let prompts = differences.iter().any(|one| one.starts_with(PROMPTS));
        let todo = if prompts {
            // No option brings back the prompts of another version.
            "keep it as it is in another folder, or drop it"
        } else {
            "with the options of that run it is reused"
        };
        Some(format!(
            "variant {} is not reused, its settings differ: {}{more}; a new one is generated; {todo}",
            made.line.id.as_deref().unwrap_or("without an id"),
            named.join("; "),
        ))
    }
}

/// Differences that are named.
const MAX_LISTED: usize = 4;

/// Reads a manifest, and compares it with its variant.
fn read(path: &Path) -> Result<FileKind, String> {
    let bytes = system::read_file(path, system::LARGEST).map_err(|e| system::error_text(&e))?;
    let document: Value =
        serde_json::from_slice(&bytes).map_err(|e| format!("not a manifest of a variant: {e}"))?;
    if is_of_report(&document) {
        return Ok(FileKind::Report);
    }
    let manifest = Manifest::deserialize(&document)
        .map_err(|e| format!("not a manifest of a variant: {e}"))?;
    let made = manifest.made.as_ref().filter(|made| !made.is_null());
    let made = made.ok_or("its settings are missing")?;
    let made =
        Made::deserialize(made).map_err(|e| format!("not a manifest of a variant: made: {e}"))?;
    let folder = path.parent().unwrap_or(Path::new("."));
    let scenario = file_beside(folder, &manifest.variant)?;
    let ego = file_beside(folder, &manifest.ego)?;
    let hashes = &manifest.sha256;
    let has_hash = |path: &PathBuf| hashes.contains_key(&file_name(path));
    if ![&scenario, &ego].into_iter().all(has_hash) {
        return Err("not a manifest of a variant: sha256 lacks its files".into());
    }
    for (name, hash) in hashes {
        is_unchanged(&file_beside(folder, name)?, hash)?;
    }
    let line = VariantLine {
        rejected: Some(manifest.rejected),
        taken_over: true,
        ..made.line
    };
    if line.outcome == OutcomeName::None {
        return Err("not a manifest of a variant: nothing was generated".into());
    }
    if let Some(why) = line.model.as_ref().and_then(|model| model.stopped.as_ref()) {
        return Err(format!("the model stopped early: {why}"));
    }
    let identity = match manifest.planning.planner {
        PlannerIdentity::External { name, version, .. } => Some((name, version)),
        PlannerIdentity::BuiltIn(_) => None,
    };
    let files = VariantFiles {
        id: manifest.benchmark_id,
        scenario,
        ego,
        ..VariantFiles::default()
    };
    Ok(FileKind::Variant(Box::new(MadeVariant {
        original: manifest.original.sha256,
        settings: made.settings.with_identity(identity),
        line: line.saved_as(&files),
    })))
}

/// The file of this name in a folder. A name is meant, not a way out of the folder.
fn file_beside(folder: &Path, name: &str) -> Result<PathBuf, String> {
    match Path::new(name).file_name() {
        Some(file) if file == name => Ok(folder.join(name)),
        _ => Err(format!("not a file name: {name}")),
    }
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// Whether the file at `path` is a report of an earlier run, which may be replaced.
///
/// # Errors
/// It is not, or cannot be read.
pub fn is_report(path: &Path) -> Result<(), String> {
    let named = |words: String| format!("{}: {words}", path.display());
    let bytes =
        system::read_file(path, system::LARGEST).map_err(|e| named(system::error_text(&e)))?;
    match serde_json::from_slice(&bytes) {
        Ok(document) if is_of_report(&document) => Ok(()),
        _ => Err(named(
            "exists and is not a report of `nearmiss generate`; name another file".into(),
        )),
    }
}

fn is_of_report(document: &Value) -> bool {
    let counts = |key: &str| document.get(key).is_some_and(Value::is_u64);
    counts("asked_for") && counts("scenarios")
}

#[cfg(test)]
#[path = "resume_tests.rs"]
mod tests;

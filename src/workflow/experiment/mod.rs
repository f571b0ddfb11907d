//! An experiment as a file: which questions are asked about which scenarios, to whom, and which comparison matters.

mod axes;
mod file;
mod files;
mod hashes;
mod keys;
mod prepare;
mod progress;
mod read;
mod save;
mod values;
mod write;

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::batch::BatchRequest;
use nearmiss_ask::prompts::Library;
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_study::evaluation::batch::{Matrix, Shard, Spec, Subset, TruthSource};
use nearmiss_study::evaluation::report::Comparison;

pub use axes::ExperimentAxis;
pub use files::{ExperimentFile, FolderOfExperiments, experiments_in};
pub use hashes::{hashes_in, hashes_of, name_of};
pub use keys::{ExperimentKey, KEYS as EXPERIMENT_KEYS, schema as experiment_schema};
pub use prepare::{
    ExperimentContext, PreparedExperiment, experiment_among, is_experiment_file, selected,
};
pub use progress::{ExperimentProgress, WayProgress, reasons_of};
pub use save::WriteExperimentError;

/// An experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// What it asks, in a line.
    pub title: Option<String>,
    /// Scenario files, folders and names of bundled scenarios; those of a file are absolute.
    pub paths: Vec<PathBuf>,
    /// Where the truth is from; by default the folders of a labelled repository, else the geometry.
    pub truth: Option<TruthSource>,
    /// Questions about each scenario.
    pub matrix: Matrix,
    /// The address of the server, where it is not the provider's own.
    pub base_url: Option<String>,
    /// Most that a run may cost, US dollars.
    pub budget: Option<f64>,
    /// Which comparisons of its answers matter.
    pub comparison: Comparison,
    /// The templates that it was written with, by file name, with the start of the hash of each; none where any will
    /// do.
    pub templates: BTreeMap<String, String>,
    /// Which of the scenarios are asked about, and in which parts.
    pub subset: Subset,
    /// The contents of the scenarios by name, each as the start of its SHA-256, several where scenarios of one name
    /// differ; none where any will do.
    pub hashes: BTreeMap<String, Vec<String>>,
}

/// Digits of a hash that tell a template or a scenario from others.
const HASH_DIGITS: usize = 12;

impl Experiment {
    /// The batch that asks its questions.
    ///
    /// # Errors
    /// A template or a scenario is not the one that the experiment was written with.
    pub fn request(
        &self,
        entries: Vec<Entry>,
        shard: Option<Shard>,
        library: &Library,
    ) -> Result<BatchRequest, String> {
        let now = Spec::templates_of(&self.matrix, library);
        let other = self.templates.iter().find(|(name, hash)| {
            !now.get(*name)
                .is_some_and(|now| now.starts_with(hash.as_str()))
        });
        if let Some((name, hash)) = other {
            return Err(match now.get(name) {
                Some(now) => format!(
                    "templates: {name} has the hash {}, but the experiment was written with {hash}; put that version of \
                     it into the folder of templates, or remove the line",
                    &now[..HASH_DIGITS.min(now.len())]
                ),
                None => format!("templates: {name} is not asked with in this experiment"),
            });
        }
        hashes::check(&self.hashes, &entries)?;
        Ok(BatchRequest {
            title: self.title.clone(),
            paths: self.paths.clone(),
            entries,
            matrix: self.matrix.clone(),
            ego: EgoSelection::Beside,
            truth: self.truth.clone(),
            shard,
            drafts: BTreeMap::new(),
            base_url: self.base_url.clone(),
            comparison: self.comparison.clone(),
            subset: self.subset.clone(),
        })
    }
}

/// The same without repetitions.
fn each_once<T: PartialEq>(values: Vec<T>) -> Vec<T> {
    let mut once = Vec::with_capacity(values.len());
    for value in values {
        if !once.contains(&value) {
            once.push(value);
        }
    }
    once
}

#[cfg(test)]
mod tests;

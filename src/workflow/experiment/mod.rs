//! An experiment as a file: which questions are asked about which scenarios, to whom, and which comparison matters.

mod files;
mod hashes;
mod outline;
mod prepare;
mod progress;
mod read;
mod save;

use std::collections::BTreeMap;

use super::batch::BatchRequest;
use nearmiss_ask::prompts::Library;
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_study::evaluation::batch::{Experiment, HASH_DIGITS, Shard, Spec};

pub use files::{ExperimentFile, FolderOfExperiments, experiments_in};
pub use hashes::{hashes_in, hashes_of, name_of};
pub use outline::{ExperimentAxis, experiment_axes, experiment_facts};
pub use prepare::{
    ExperimentContext, PreparedExperiment, experiment_among, find_scenarios, is_experiment_file,
    prepare_experiment, selected,
};
pub use progress::{ExperimentProgress, WayProgress, reasons_of};
pub use read::{
    add_experiment_file, complete_experiment, configured_experiment, experiment_schema,
    experiment_toml, read_experiment,
};
pub use save::{WriteExperimentError, experiment_of, pins_of, write_experiment};

/// The batch that asks the questions of an experiment.
///
/// # Errors
/// A template or a scenario is not the one that the experiment was written with.
pub fn request_of(
    experiment: &Experiment,
    entries: Vec<Entry>,
    shard: Option<Shard>,
    library: &Library,
) -> Result<BatchRequest, String> {
    let now = Spec::templates_of(experiment, library);
    let other = experiment.templates.iter().find(|pin| {
        let now = now.get(&pin.name);
        !now.is_some_and(|now| now.starts_with(&pin.hash))
    });
    if let Some(pin) = other {
        let (name, hash) = (&pin.name, &pin.hash);
        return Err(match now.get(name) {
            Some(now) => format!(
                "templates: {name} has the hash {}, but the experiment was written with {hash}; put that version of \
                 it into the folder of templates, or remove the line",
                &now[..HASH_DIGITS.min(now.len())]
            ),
            None => format!("templates: {name} is not asked with in this experiment"),
        });
    }
    hashes::check(&experiment.hashes, &entries)?;
    Ok(BatchRequest {
        experiment: experiment.clone(),
        entries,
        ego: EgoSelection::Beside,
        shard,
        drafts: BTreeMap::new(),
    })
}

#[cfg(test)]
mod tests;

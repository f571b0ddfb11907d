//! From an experiment to the batch that asks it, new or stored: the same for command line and workbench.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::request_of;
use crate::batch::{BatchError, BatchPlan, BatchRequest, PlanningEvent, ResumeRequest, Selection};
use crate::{Selector, find};
use nearmiss_ask::prompts::Library;
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::{Entry, SearchResults, resolved};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_store::{BatchId, Store};
use nearmiss_study::evaluation::batch::{Experiment, Shard};

/// What an experiment is run with, beside its file.
#[derive(Debug, Clone, Copy)]
pub struct ExperimentContext<'a> {
    /// The templates.
    pub library: &'a Library,
    /// The thresholds of risk scores.
    pub thresholds: &'a Arc<Thresholds>,
    /// Where its batch is.
    pub store: &'a Store,
}

/// An experiment with its scenarios, and the stored batch that asks the same.
#[derive(Debug)]
pub struct PreparedExperiment {
    request: BatchRequest,
    batch: Option<BatchId>,
}

/// Whether a path on the command line is an experiment file.
#[must_use]
pub fn is_experiment_file(path: &Path) -> bool {
    path.extension().is_some_and(|end| end == "toml")
}

/// The experiment file among paths.
///
/// # Errors
/// There is one beside other paths: in words.
pub fn experiment_among(paths: &[PathBuf]) -> Result<Option<&Path>, String> {
    match (paths.iter().find(|path| is_experiment_file(path)), paths) {
        (None, _) => Ok(None),
        (Some(path), [_]) => Ok(Some(path)),
        (Some(path), _) => Err(format!(
            "{}: an experiment file names its scenarios; give it alone",
            path.display()
        )),
    }
}

/// The scenarios in the paths of an experiment, before its filter; reads folders.
///
/// # Errors
/// A path is not there, or there is no scenario in any of them: in words.
pub fn find_scenarios(experiment: &Experiment) -> Result<SearchResults, String> {
    let paths = experiment.scenarios.iter();
    let paths = paths
        .map(|path| resolved(path))
        .collect::<Result<Vec<_>, _>>()?;
    find(&paths).map_err(|error| error.to_string())
}

/// The batch that asks the experiment of `file` about those of the `found` scenarios that its filter selects.
///
/// # Errors
/// The filter selects none, or a template or a scenario is not the one that the experiment was written with: with
/// the file. The store cannot be read.
pub fn prepare_experiment(
    experiment: &Experiment,
    file: &Path,
    found: Vec<Entry>,
    shard: Option<Shard>,
    context: ExperimentContext<'_>,
) -> Result<PreparedExperiment, String> {
    let named = |why| format!("{}: {why}", file.display());
    let entries =
        selected(found, experiment.select.as_deref(), context.thresholds).map_err(named)?;
    let mut request = request_of(experiment, entries, shard, context.library).map_err(named)?;
    let batch = request
        .stored(context.store, context.library, context.thresholds)
        .map_err(|error| error.to_string())?;
    Ok(PreparedExperiment { request, batch })
}

impl PreparedExperiment {
    /// The stored batch that asks the same, which is gone on with; `None` where a new one begins.
    #[must_use]
    pub fn batch(&self) -> Option<BatchId> {
        self.batch
    }

    /// What a new batch would ask.
    #[must_use]
    pub fn request(&self) -> &BatchRequest {
        &self.request
    }

    /// Plans the new batch, or to go on with the stored one; nothing is written. Drawing windows reads all recordings:
    /// nothing where `cancel` asked for an end.
    ///
    /// # Errors
    /// See [`BatchError`].
    pub fn plan(
        self,
        selection: Selection,
        context: ExperimentContext<'_>,
        cancel: &Cancel,
        on_event: &mut dyn FnMut(PlanningEvent),
    ) -> Result<Option<BatchPlan>, BatchError> {
        let ExperimentContext {
            library,
            thresholds,
            store,
        } = context;
        if self.batch.is_none() {
            return self.request.plan(library, thresholds, cancel, on_event);
        }
        let again = ResumeRequest {
            batch: self.batch,
            selection,
            more: Experiment::default(),
            truth: None,
            // Only another truth would be written.
            dry_run: false,
        };
        again.plan(store, library, thresholds, cancel, on_event)
    }
}

/// The scenarios that the filter of an experiment lets through.
///
/// # Errors
/// The filter is wrong, or lets none through: in words that begin with `select`.
pub fn selected(
    entries: Vec<Entry>,
    filter: Option<&str>,
    thresholds: &Thresholds,
) -> Result<Vec<Entry>, String> {
    let Some(filter) = filter else {
        return Ok(entries);
    };
    let selected = Selector::read(filter).and_then(|selector| selector.select(entries, thresholds));
    selected.map_err(|why| format!("select: {why}"))
}

//! From an experiment to the batch that asks it, new or stored, and how far that is: the same for every face.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_ask::prompts::Library;
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::{Entry, SearchResults, resolved};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_store::{BatchId, Item, ItemState, NewItem, Store};
use nearmiss_study::evaluation::PromptConfig;
use nearmiss_study::evaluation::batch::{Experiment, Shard, configuration_of_item};

use super::batch_request;
use crate::batch::{BatchError, BatchPlan, BatchRequest, PlanningEvent, ResumeRequest, Selection};
use crate::{Selector, find};

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
    let mut request = batch_request(experiment, entries, shard, context.library).map_err(named)?;
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

/// Questions of one way of asking by their state.
#[derive(Debug, Clone, PartialEq)]
pub struct ConfigurationProgress {
    /// The way.
    pub configuration: PromptConfig,
    /// Questions with a whole answer.
    pub answered: usize,
    /// Questions to which no whole answer came, those that the server cut off among them.
    pub failed: usize,
    /// Questions that were not asked yet.
    pub open: usize,
    /// Questions that cannot be asked.
    pub unaskable: usize,
}

/// All questions of a batch.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExperimentProgress {
    /// By way of asking, in the order of the questions.
    pub configurations: Vec<ConfigurationProgress>,
    /// Scenarios that are asked about.
    pub scenarios: usize,
    /// Windows that are asked about; a window at another lead or after a transform is another one.
    pub windows: usize,
}

/// What a window is of: path, lead, transform, steps and task.
type Window<'a> = (
    &'a str,
    Option<&'a str>,
    Option<&'a str>,
    Option<(i64, i64)>,
    &'static str,
);

impl ConfigurationProgress {
    /// All its questions.
    #[must_use]
    pub fn all(&self) -> usize {
        self.answered + self.failed + self.open + self.unaskable
    }

    fn count(&mut self, state: ItemState) -> &mut usize {
        match state {
            ItemState::Answered => &mut self.answered,
            ItemState::Failed | ItemState::Truncated => &mut self.failed,
            ItemState::Waiting => &mut self.open,
            ItemState::Unaskable => &mut self.unaskable,
        }
    }
}

impl ExperimentProgress {
    /// That of a stored batch.
    ///
    /// # Errors
    /// A question holds a word that this version does not know.
    pub fn of_items(items: &[Item]) -> Result<Self, String> {
        Self::counted(items.iter().map(|item| (&item.asked, item.state)))
    }

    /// That of a batch before it is begun.
    ///
    /// # Errors
    /// A question holds a word that this version does not know.
    pub fn of_new(items: &[NewItem]) -> Result<Self, String> {
        Self::counted(items.iter().map(|item| {
            let state = match item.unaskable {
                Some(_) => ItemState::Unaskable,
                None => ItemState::Waiting,
            };
            (item, state)
        }))
    }

    fn counted<'a>(items: impl Iterator<Item = (&'a NewItem, ItemState)>) -> Result<Self, String> {
        let mut progress = Self::default();
        let mut scenarios: HashSet<&str> = HashSet::new();
        let mut windows: HashSet<Window<'a>> = HashSet::new();
        for (asked, state) in items {
            let configuration = configuration_of_item(asked)?;
            *progress.progress_of(&configuration).count(state) += 1;
            scenarios.insert(&asked.path);
            windows.insert((
                &asked.path,
                asked.lead.as_deref(),
                asked.transform.as_deref(),
                asked.window,
                asked.task.name(),
            ));
        }
        (progress.scenarios, progress.windows) = (scenarios.len(), windows.len());
        Ok(progress)
    }

    /// A question of this way changed its state.
    pub fn change(&mut self, configuration: &PromptConfig, before: ItemState, now: ItemState) {
        let of_way = self.progress_of(configuration);
        let count = of_way.count(before);
        *count = count.saturating_sub(1);
        *of_way.count(now) += 1;
    }

    /// The sums over all ways: answered, failed, open, and those that cannot be asked.
    #[must_use]
    pub fn sums(&self) -> [usize; 4] {
        self.configurations
            .iter()
            .fold([0; 4], |sums, configuration| {
                let counts = [
                    configuration.answered,
                    configuration.failed,
                    configuration.open,
                    configuration.unaskable,
                ];
                std::array::from_fn(|i| sums[i] + counts[i])
            })
    }

    fn progress_of(&mut self, configuration: &PromptConfig) -> &mut ConfigurationProgress {
        let place = self
            .configurations
            .iter()
            .position(|known| known.configuration == *configuration)
            .unwrap_or_else(|| {
                self.configurations.push(ConfigurationProgress {
                    configuration: configuration.clone(),
                    answered: 0,
                    failed: 0,
                    open: 0,
                    unaskable: 0,
                });
                self.configurations.len() - 1
            });
        &mut self.configurations[place]
    }
}

/// Why questions have no whole answer, each reason once with how many questions it holds for, the most first.
#[must_use]
pub fn count_reasons<'a>(items: impl IntoIterator<Item = &'a Item>) -> Vec<(String, usize)> {
    let mut reasons: Vec<(String, usize)> = Vec::new();
    for item in items {
        let why = item.error.as_deref().unwrap_or("not asked yet");
        match reasons.iter_mut().find(|(known, _)| known == why) {
            Some((_, count)) => *count += 1,
            None => reasons.push((why.to_string(), 1)),
        }
    }
    reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    reasons
}

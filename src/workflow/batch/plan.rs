//! Plans a batch: what it asks about which scenarios, which of its questions, and its record in the store.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::resume::StoredBatch;
use super::{BatchError, DryRun, Relabelling};
use nearmiss_ask::prompts::Library;
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::{EgoSelection, Entry, EntryLocation};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_store::{Batch, BatchId, Item, ItemState, SplitPart, Store, StoreError};
use nearmiss_study::evaluation::batch::{
    Ask, BatchWindows, Experiment, QuestionBuilder, Shard, Spec, Truth, TruthSource, WindowSource,
    stored_path,
};

/// A batch that is to be begun.
#[derive(Debug)]
pub struct BatchRequest {
    /// What is asked, about files, folders and bundled scenarios as they were chosen.
    pub experiment: Experiment,
    /// The scenarios in them that its filter selects.
    pub entries: Vec<Entry>,
    /// Whose ego they have.
    pub ego: EgoSelection,
    /// The part of the scenarios that this machine asks about.
    pub shard: Option<Shard>,
    /// Texts of templates that are not saved, by file name.
    pub drafts: BTreeMap<String, String>,
}

/// A batch ready to run: a new or a resumed one.
pub struct BatchPlan {
    /// What it asks.
    pub spec: Spec,
    /// What makes its questions.
    pub builder: Arc<QuestionBuilder>,
    /// Warnings about the ground truth.
    pub doubts: Vec<String>,
    /// How many safe scenarios have no window to ask about, and why; `None` if all have one.
    pub left_out: Option<String>,
    /// Which of its questions are asked.
    pub selection: Selection,
    /// The part of its split that is asked; `None` for all.
    pub part: Option<SplitPart>,
    /// Changed ground truth of a resumed batch.
    pub relabelling: Option<Relabelling>,
    pub(super) truth: Truth,
    /// Questions to ask about each scenario.
    pub(super) scenarios: Vec<(Entry, Vec<Ask>)>,
    pub(super) origin: Origin,
}

/// Events while a batch is planned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlanningEvent {
    /// Windows are to be drawn: recordings that were read, and how many there are.
    Read {
        /// Recordings so far.
        done: usize,
        /// Recordings in all, each once for every length of windows.
        of: usize,
    },
}

/// Whether the batch is already stored.
pub(super) enum Origin {
    New { shard: Option<Shard> },
    Stored(Box<StoredBatch>),
}

impl BatchRequest {
    /// What the batch asks, as the store keeps it.
    ///
    /// # Errors
    /// A path cannot be resolved, or a draft is not for what is asked.
    pub fn spec(&mut self, library: &Library, thresholds: &Thresholds) -> Result<Spec, BatchError> {
        for entry in &mut self.entries {
            if let EntryLocation::File(path) = &mut entry.place {
                *path = absolute(path)?;
            }
        }
        let paths = self.experiment.scenarios.iter().map(|path| {
            if matches!(Entry::of_argument(path).place, EntryLocation::Bundled(_)) {
                Ok(path.clone())
            } else {
                absolute(path)
            }
        });
        let truth = self.experiment.truth.clone().map(TruthSource::absolute);
        let experiment = Experiment {
            scenarios: paths.collect::<Result<_, _>>()?,
            truth: Some(truth.unwrap_or_else(|| TruthSource::default_for(&self.entries))),
            ..self.experiment.asked()
        };
        let mut spec = Spec {
            templates: BTreeMap::new(),
            thresholds: Spec::threshold_changes(thresholds),
            ego: self.ego.clone(),
            drafts: self.drafts.clone(),
            drawn_from: if experiment.draws_windows() {
                self.entries.iter().map(stored_path).collect()
            } else {
                Vec::new()
            },
            experiment,
        };
        spec.templates = Spec::templates_for(&spec.experiment, &spec.library(library)?);
        let unused = |file: &&String| !spec.templates.contains_key(*file);
        match spec.drafts.keys().find(unused) {
            Some(file) => Err(BatchError::Draft(file.clone())),
            None => Ok(spec),
        }
    }

    /// The stored batch that asks the same, the last one of several.
    ///
    /// # Errors
    /// See [`BatchError`].
    pub fn stored(
        &mut self,
        store: &Store,
        library: &Library,
        thresholds: &Thresholds,
    ) -> Result<Option<BatchId>, BatchError> {
        let shard = self.shard.map(|shard| shard.to_string());
        let all = self.asking_the_same(store, library, thresholds)?;
        let same = all.into_iter().filter(|batch| batch.shard == shard);
        Ok(same.map(|batch| batch.id).max())
    }

    /// The stored batches that ask the same about parts of the scenarios, each with its part, such as `1/4`.
    ///
    /// # Errors
    /// See [`BatchError`].
    pub fn stored_parts(
        &mut self,
        store: &Store,
        library: &Library,
        thresholds: &Thresholds,
    ) -> Result<Vec<(BatchId, String)>, BatchError> {
        let all = self.asking_the_same(store, library, thresholds)?;
        let parts = all
            .into_iter()
            .filter_map(|batch| Some((batch.id, batch.shard?)));
        Ok(parts.collect())
    }

    /// The stored batches that ask the same, about all scenarios or parts of them, the newest first.
    fn asking_the_same(
        &mut self,
        store: &Store,
        library: &Library,
        thresholds: &Thresholds,
    ) -> Result<Vec<Batch>, BatchError> {
        let spec = self.spec(library, thresholds)?;
        let is_same =
            |batch: &Batch| Spec::from_json(&batch.spec).is_ok_and(|stored| stored == spec);
        let all = store.batches()?.into_iter().map(|(batch, _)| batch);
        Ok(all.filter(is_same).collect())
    }

    /// Plans the batch; nothing is written. Drawing windows reads all recordings: nothing where `cancel` asked for an
    /// end.
    ///
    /// # Errors
    /// See [`BatchError`].
    pub fn plan(
        mut self,
        library: &Library,
        thresholds: &Arc<Thresholds>,
        cancel: &Cancel,
        on_event: &mut dyn FnMut(PlanningEvent),
    ) -> Result<Option<BatchPlan>, BatchError> {
        let spec = self.spec(library, thresholds)?;
        let split = spec.experiment.split;
        if let Some(part) = split.and_then(|split| split.empty_part(&self.entries)) {
            return Err(BatchError::EmptyPart(part));
        }
        // Of all scenarios, so that every part has the same ones.
        let (truth, doubts) = Truth::open(spec.truth(), &self.entries)?;
        let builder = Arc::new(spec.builder(library, Arc::clone(thresholds))?);
        let source = WindowSource {
            experiment: &spec.experiment,
            entries: &self.entries,
            builder: &builder,
            split,
            cancel,
        };
        let on_read = &mut |done, of| on_event(PlanningEvent::Read { done, of });
        let Some((windows, left_out)) = BatchWindows::draw(&source, &truth, on_read) else {
            return Ok(None);
        };
        if let Some(shard) = self.shard {
            self.entries.retain(|entry| shard.has(&entry.name));
        }
        let asks = |entry: Entry| {
            let asks = spec.experiment.asks(&windows, &stored_path(&entry));
            (entry, asks)
        };
        let scenarios = self.entries.into_iter().map(asks).collect();
        Ok(Some(BatchPlan {
            builder,
            doubts,
            left_out,
            selection: Selection::Open,
            part: None,
            relabelling: None,
            truth,
            scenarios,
            origin: Origin::New { shard: self.shard },
            spec,
        }))
    }
}

impl BatchPlan {
    /// The models that are asked, each once.
    #[must_use]
    pub fn models(&self) -> Vec<String> {
        let mut models: Vec<String> = Vec::new();
        for ask in self.scenarios.iter().flat_map(|(_, asks)| asks) {
            if !models.contains(&ask.configuration.model) {
                models.push(ask.configuration.model.clone());
            }
        }
        models
    }

    /// Asks only a part of the split; `None` asks all.
    ///
    /// # Errors
    /// There is no split.
    pub fn ask_part(&mut self, part: Option<SplitPart>) -> Result<(), BatchError> {
        if part.is_some() && self.spec.experiment.split.is_none() {
            return Err(BatchError::NoSplit);
        }
        self.part = part;
        Ok(())
    }

    /// Whether there is something to ask about.
    ///
    /// # Errors
    /// It is a new batch, and none of its scenarios has a label.
    pub fn check_labels(&self, dry_run: &DryRun) -> Result<(), BatchError> {
        if dry_run.items.is_empty() && !self.is_stored() {
            return Err(BatchError::Unlabelled {
                scenarios: self.scenarios(),
                truth: self.spec.truth().summary(),
            });
        }
        Ok(())
    }

    /// Whether the batch is in the store already.
    #[must_use]
    pub fn is_stored(&self) -> bool {
        matches!(self.origin, Origin::Stored(_))
    }

    /// How many scenarios it asks about.
    #[must_use]
    pub fn scenarios(&self) -> usize {
        self.scenarios.len()
    }

    /// Writes a new batch to the store, or the additions to a resumed one.
    ///
    /// # Errors
    /// The store cannot be written.
    pub fn write(&self, store: &Store, dry_run: &DryRun) -> Result<BatchId, StoreError> {
        match &self.origin {
            Origin::New { shard } => {
                let shard = shard.map(|shard| shard.to_string());
                store.begin_batch(&self.spec.to_json(), shard.as_deref(), &dry_run.items)
            }
            Origin::Stored(stored) => {
                stored.extend(store, &self.spec, dry_run)?;
                Ok(stored.id())
            }
        }
    }
}

/// Selection of a batch's questions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Selection {
    /// Those that have no whole answer, without those that the server cut off: it would do so again.
    Open,
    /// Those to which no whole answer came, with those that were cut off, and whole answers without a verdict.
    Failed,
    /// All of them, also those with a whole answer: to look at them, not to ask them.
    All,
}

impl Selection {
    /// Whether a question is among them.
    #[must_use]
    pub fn selects(self, item: &Item) -> bool {
        self.has(item.state) || self.asks_anew(item)
    }

    /// Whether the question is asked although the store has a whole answer to it, since no verdict could be read there.
    #[must_use]
    pub fn asks_anew(self, item: &Item) -> bool {
        self == Self::Failed && item.state == ItemState::Answered && item.unparsed
    }

    /// Whether questions in this state are among them, leaving aside whole answers without a verdict.
    #[must_use]
    pub fn has(self, state: ItemState) -> bool {
        use ItemState::{Answered, Failed, Truncated, Unaskable, Waiting};
        match (self, state) {
            (Self::All, _) => true,
            (_, Answered) => false,
            (Self::Open, Truncated) | (Self::Failed, Waiting) => false,
            (Self::Open, Waiting | Failed | Unaskable) => true,
            (Self::Failed, Failed | Truncated | Unaskable) => true,
        }
    }
}

fn absolute(path: &Path) -> Result<PathBuf, BatchError> {
    std::path::absolute(path).map_err(|source| BatchError::Path {
        path: path.to_path_buf(),
        source,
    })
}

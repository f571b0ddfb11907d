//! Plans a batch: what it asks about which scenarios, and its record in the store.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::resume::StoredBatch;
use super::{BatchError, DryRun, Relabelling, Selection};
use crate::evaluation::batch::{Ask, Matrix, QuestionBuilder, Shard, Spec, Truth, TruthSource};
use crate::formats::{EgoSelection, Entry, EntryLocation};
use crate::metrics::Thresholds;
use crate::prompts::Library;
use crate::store::{BatchId, Store, StoreError};

/// A batch that is to be begun.
#[derive(Debug)]
pub struct BatchRequest {
    /// Files, folders and names of bundled scenarios, as they were chosen.
    pub paths: Vec<PathBuf>,
    /// The scenarios in them.
    pub entries: Vec<Entry>,
    /// Questions about each scenario.
    pub matrix: Matrix,
    /// Whose ego they have.
    pub ego: EgoSelection,
    /// Where the truth is from; by default the folders of a labelled repository, else the geometry.
    pub truth: Option<TruthSource>,
    /// The part of the scenarios that this machine asks about.
    pub shard: Option<Shard>,
    /// Texts of templates that are not saved, by file name.
    pub drafts: BTreeMap<String, String>,
    /// The address of the server, where it is not the provider's own.
    pub base_url: Option<String>,
}

/// A batch ready to run: a new or a resumed one.
pub struct BatchPlan {
    /// What it asks.
    pub spec: Spec,
    /// What makes its questions.
    pub builder: Arc<QuestionBuilder>,
    /// Warnings about the ground truth.
    pub doubts: Vec<String>,
    /// Which of its questions are asked.
    pub selection: Selection,
    /// Changed ground truth of a resumed batch.
    pub relabelling: Option<Relabelling>,
    pub(super) truth: Truth,
    /// Questions to ask about each scenario.
    pub(super) scenarios: Vec<(Entry, Vec<Ask>)>,
    pub(super) origin: Origin,
}

/// Whether the batch is already stored.
pub(super) enum Origin {
    New { shard: Option<Shard> },
    Stored(Box<StoredBatch>),
}

impl BatchRequest {
    /// Plans the batch; nothing is written.
    ///
    /// # Errors
    /// See [`BatchError`].
    pub fn plan(
        mut self,
        library: &Library,
        thresholds: &Arc<Thresholds>,
    ) -> Result<BatchPlan, BatchError> {
        for entry in &mut self.entries {
            if let EntryLocation::File(path) = &mut entry.place {
                *path = absolute(path)?;
            }
        }
        // Of all scenarios, so that every part has the same one.
        let source = self
            .truth
            .unwrap_or_else(|| TruthSource::usual(&self.entries));
        let (truth, doubts) = Truth::open(&source, &self.entries)?;
        if let Some(shard) = self.shard {
            self.entries.retain(|entry| shard.has(&entry.name));
        }
        let paths = self.paths.iter().map(|path| {
            match matches!(Entry::of_argument(path).place, EntryLocation::Bundled(_)) {
                true => Ok(path.clone()),
                false => absolute(path),
            }
        });
        let mut spec = Spec {
            paths: paths.collect::<Result<_, _>>()?,
            matrix: self.matrix,
            truth: source,
            templates: BTreeMap::new(),
            thresholds: Spec::thresholds_of(thresholds),
            base_url: self.base_url,
            ego: self.ego,
            drafts: self.drafts,
        };
        spec.templates = Spec::templates_of(&spec.matrix, &spec.library(library)?);
        if let Some(file) = spec
            .drafts
            .keys()
            .find(|file| !spec.templates.contains_key(*file))
        {
            return Err(BatchError::Draft(file.clone()));
        }
        let asks = spec.matrix.asks();
        let scenarios = self.entries.into_iter();
        Ok(BatchPlan {
            builder: Arc::new(spec.builder(library, Arc::clone(thresholds))?),
            doubts,
            selection: Selection::Open,
            relabelling: None,
            truth,
            scenarios: scenarios.map(|entry| (entry, asks.clone())).collect(),
            origin: Origin::New { shard: self.shard },
            spec,
        })
    }
}

impl BatchPlan {
    /// The models that are asked, each once.
    #[must_use]
    pub fn models(&self) -> Vec<String> {
        let mut models: Vec<String> = Vec::new();
        for ask in self.scenarios.iter().flat_map(|(_, asks)| asks) {
            if !models.contains(&ask.way.model) {
                models.push(ask.way.model.clone());
            }
        }
        models
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

fn absolute(path: &Path) -> Result<PathBuf, BatchError> {
    std::path::absolute(path).map_err(|source| BatchError::Path {
        path: path.to_path_buf(),
        source,
    })
}

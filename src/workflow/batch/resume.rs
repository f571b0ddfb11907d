//! Resumes a batch: unanswered and failed questions, added models, techniques and samples, another ground truth.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::path::Path;
use std::sync::Arc;

use super::plan::{Origin, PlanningEvent};
use super::{BatchError, BatchPlan, DryRun, Selection};
use nearmiss_ask::prompts::Library;
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::Entry;
use nearmiss_record::fields::{Fields, Row};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{Batch, BatchId, Identity, Item, ItemTruth, NewItem, Store, StoreError};
use nearmiss_study::evaluation::batch::{
    Ask, AskedWindow, BatchWindows, Experiment, Spec, Truth, TruthSource, Variant, WindowSource,
    configuration_of_item, relabel,
};
use nearmiss_study::evaluation::{Lead, PromptConfig, Protocol};

/// A batch to resume.
#[derive(Debug)]
pub struct ResumeRequest {
    /// Which one; the last one where none is named.
    pub batch: Option<BatchId>,
    /// Which of its questions are asked.
    pub selection: Selection,
    /// What is added to it, of fields that grow; others have to be as they are.
    pub more: Experiment,
    /// Another truth.
    pub truth: Option<TruthSource>,
    /// Whether another truth is only looked at; otherwise it is written into the store.
    pub dry_run: bool,
}

/// Another truth of a batch.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Relabelling {
    /// The batch.
    pub batch: BatchId,
    /// Where the truth was from before.
    pub before: TruthSource,
    /// Scenarios that the new one says nothing about.
    pub unlabelled: Vec<String>,
}

/// A batch as the store has it, and what is added to it.
pub(super) struct StoredBatch {
    batch: Batch,
    pub(super) items: Vec<Item>,
    /// The specification without what is added.
    before: Spec,
    extended: bool,
}

impl ResumeRequest {
    /// Plans to go on. Drawing windows of what is added reads all recordings: nothing where `cancel` asked for an end.
    ///
    /// # Errors
    /// See [`BatchError`].
    pub fn plan(
        &self,
        store: &Store,
        library: &Library,
        thresholds: &Arc<Thresholds>,
        cancel: &Cancel,
        on_event: &mut dyn FnMut(PlanningEvent),
    ) -> Result<Option<BatchPlan>, BatchError> {
        let batch = self.batch(store)?;
        let stored = |error| BatchError::Stored {
            batch: batch.id,
            error,
        };
        let mut spec = Spec::from_json(&batch.spec)?;
        spec.ensure_unchanged(library, thresholds).map_err(stored)?;
        self.can_be_added(&batch, &spec)?;
        let mut items = store.items(batch.id)?;
        let mut before = spec.clone();
        spec.experiment.extend(&self.more);
        spec.experiment.check_size().map_err(BatchError::TooLarge)?;
        let own_library = spec.library(library)?;
        spec.templates
            .extend(Spec::templates_for(&spec.experiment, &own_library));
        let builder = spec.builder(library, Arc::clone(thresholds))?;
        let mut doubts = Vec::new();
        let mut relabelling = None;
        if let Some(source) = &self.truth {
            let entries: Vec<Entry> = paths(&items).into_iter().map(entry).collect();
            let (truth, doubtful) = Truth::open(source, &entries)?;
            doubts = doubtful;
            let labels = relabel(&items, &truth, &builder)?;
            if labels.iter().all(|told| told.collides.is_none()) {
                return Err(BatchError::NoLabel(batch.id));
            }
            relabelling = Some(Relabelling {
                batch: batch.id,
                before: spec.truth().clone(),
                unlabelled: unlabelled(&items, &labels),
            });
            for (item, told) in items.iter_mut().zip(&labels) {
                item.set_truth(told);
            }
            spec.experiment.truth = Some(source.clone());
            before.experiment.truth = Some(source.clone());
            if !self.dry_run {
                store.set_truth(batch.id, &before.to_json(), &labels)?;
            }
        }
        let extended = self.more.asked() != Experiment::default();
        let mut windows = BatchWindows::of_items(&items).map_err(BatchError::Question)?;
        let mut left_out = None;
        if extended {
            let drawn_from: Vec<&str> = if spec.drawn_from.is_empty() {
                paths(&items)
            } else {
                spec.drawn_from.iter().map(String::as_str).collect()
            };
            let entries: Vec<Entry> = drawn_from.into_iter().map(entry).collect();
            // Files with labels may be gone; then what the questions say is what is known.
            let truth = match Truth::open(spec.truth(), &entries) {
                Ok((truth, _)) => truth,
                Err(_) => Truth::of_items(&items),
            };
            let source = WindowSource {
                experiment: &spec.experiment,
                entries: &entries,
                builder: &builder,
                split: spec.experiment.split,
                cancel,
            };
            let on_read = &mut |done, of| on_event(PlanningEvent::Read { done, of });
            match windows.add(&source, &truth, on_read) {
                Some(words) => left_out = words,
                None => return Ok(None),
            }
        }
        let asked = extended.then_some((&spec, &windows));
        let scenarios = scenarios(&items, self.selection, asked)?;
        Ok(Some(BatchPlan {
            builder: Arc::new(builder),
            doubts,
            left_out,
            selection: self.selection,
            part: None,
            relabelling,
            truth: match spec.truth() {
                // Of files that could not be read before.
                TruthSource::Geometry => Truth::Geometry,
                TruthSource::Score(convention) => Truth::Score(*convention),
                TruthSource::Layout | TruthSource::Files(_) => Truth::of_items(&items),
            },
            scenarios,
            spec,
            origin: Origin::Stored(Box::new(StoredBatch {
                batch,
                items,
                before,
                extended,
            })),
        }))
    }

    fn batch(&self, store: &Store) -> Result<Batch, BatchError> {
        match self.batch {
            Some(id) => store.batch(id)?.ok_or(BatchError::NoBatch(id)),
            None => store.last_batch()?.ok_or(BatchError::NoBatchYet),
        }
    }

    fn can_be_added(&self, batch: &Batch, spec: &Spec) -> Result<(), BatchError> {
        let (more, has, batch) = (&self.more, &spec.experiment, batch.id);
        let given = more.given().map(|(row, _)| row);
        let is_free = |row: &Row| row.is("grows") || ["budget", "concurrency"].contains(&row.key);
        let kept = given.filter(|row| !is_free(row) && more.get(row.key) != has.get(row.key));
        let kept: Vec<&str> = kept.map(|row| row.key).collect();
        if !kept.is_empty() {
            return Err(BatchError::Kept { batch, keys: kept });
        }
        if let Some(wanted) = more.samples.filter(|wanted| *wanted < has.samples()) {
            let has = has.samples();
            return Err(BatchError::FewerSamples { wanted, batch, has });
        }
        if more.leads.is_empty() {
            return Ok(());
        }
        if !has.tasks.contains(&Task::Safety) {
            return Err(BatchError::Leads);
        }
        if has.protocol == Protocol::Paper {
            return Err(BatchError::PaperWindows);
        }
        let beyond = |lead: &&Lead| lead.is_beyond(has.within);
        match more.leads.iter().find(beyond) {
            Some(lead) => Err(BatchError::Beyond {
                lead: *lead,
                within: has.within.unwrap_or_default(),
            }),
            None => Ok(()),
        }
    }
}

impl StoredBatch {
    pub(super) fn id(&self) -> BatchId {
        self.batch.id
    }

    /// Writes down what became known about old questions, and the new questions.
    pub(super) fn extend(
        &self,
        store: &Store,
        spec: &Spec,
        dry_run: &DryRun,
    ) -> Result<(), StoreError> {
        let known = known_now(&self.items, &dry_run.items);
        if !known.is_empty() {
            store.set_truth(self.batch.id, &self.before.to_json(), &known)?;
        }
        if !self.extended {
            return Ok(());
        }
        let there: HashSet<Identity<'_>> = identities(&self.items);
        let new = dry_run
            .items
            .iter()
            .filter(|item| !there.contains(&item.identity()));
        let new: Vec<NewItem> = new.cloned().collect();
        store.extend_batch(self.batch.id, &spec.to_json(), &new)
    }
}

fn identities(items: &[Item]) -> HashSet<Identity<'_>> {
    items.iter().map(|item| item.asked.identity()).collect()
}

/// The scenarios that another truth says nothing about, by name.
fn unlabelled(items: &[Item], labels: &[ItemTruth]) -> Vec<String> {
    let without = items
        .iter()
        .zip(labels)
        .filter(|(_, told)| told.collides.is_none());
    let names: BTreeSet<&str> = without
        .map(|(item, _)| item.asked.scenario.as_str())
        .collect();
    names.into_iter().map(String::from).collect()
}

/// The truth about scenarios that could not be read when the batch was begun, and can be now.
fn known_now(items: &[Item], now: &[NewItem]) -> Vec<ItemTruth> {
    let known = now.iter().filter(|item| item.collides.is_some());
    let known: BTreeMap<&str, &NewItem> = known.map(|item| (item.path.as_str(), item)).collect();
    let unknown = items.iter().filter(|item| item.asked.collides.is_none());
    let found = unknown.filter_map(|item| {
        let now = known.get(item.asked.path.as_str())?;
        Some(ItemTruth {
            place: item.place,
            collides: now.collides,
            obstacle: now.obstacle,
            critical: now.facts.as_ref().map(|facts| facts.critical.clone()),
        })
    });
    found.collect()
}

/// The scenarios of a batch, in their order.
fn paths(items: &[Item]) -> Vec<&str> {
    let mut seen = HashSet::new();
    let paths = items.iter().map(|item| item.asked.path.as_str());
    paths.filter(|path| seen.insert(*path)).collect()
}

fn entry(path: &str) -> Entry {
    Entry::of_argument(Path::new(path))
}

/// Questions about each scenario: the batch's selected ones, and those an extension adds.
fn scenarios(
    items: &[Item],
    selection: Selection,
    extended: Option<(&Spec, &BatchWindows)>,
) -> Result<Vec<(Entry, Vec<Ask>)>, BatchError> {
    let mut by_path: BTreeMap<&str, Vec<Ask>> = BTreeMap::new();
    for item in items.iter().filter(|item| selection.selects(item)) {
        let configuration = configuration_of_item(&item.asked).map_err(BatchError::Question)?;
        let variant = Variant::from_item(&item.asked).map_err(BatchError::Question)?;
        let asks = by_path.entry(&item.asked.path).or_default();
        let truth = AskedWindow::of_item(item);
        add(asks, configuration, (variant, truth), item.asked.sample);
    }
    let all = paths(items);
    if let Some((spec, windows)) = extended {
        let there = identities(items);
        for path in &all {
            let asks = by_path.entry(path).or_default();
            for ask in &spec.experiment.asks(windows, path) {
                add_missing(asks, ask, path, &there);
            }
        }
    }
    let in_order = all.into_iter().filter_map(|path| {
        let asks = by_path.remove(path)?;
        (!asks.is_empty()).then(|| (entry(path), asks))
    });
    Ok(in_order.collect())
}

/// Adds those samples of an `ask` that are not there yet.
fn add_missing(asks: &mut Vec<Ask>, ask: &Ask, path: &str, there: &HashSet<Identity<'_>>) {
    let configuration = &ask.configuration;
    let techniques = configuration
        .techniques
        .map(|techniques| techniques.to_string());
    let (lead, transform) = ask.variant.stored();
    let settings = configuration.settings.to_stored();
    for &sample in &ask.samples {
        let new = Identity {
            path,
            task: configuration.task.name(),
            model: &configuration.model,
            frame: configuration.frame.map(|frame| frame.name()),
            techniques: techniques.as_deref(),
            lead: lead.as_deref(),
            transform: transform.as_deref(),
            window: ask.variant.window,
            settings: settings.as_deref(),
            sample,
        };
        if !there.contains(&new) {
            add(
                asks,
                configuration.clone(),
                (ask.variant, ask.truth.clone()),
                sample,
            );
        }
    }
}

fn add(
    asks: &mut Vec<Ask>,
    configuration: PromptConfig,
    (variant, truth): (Variant, Option<AskedWindow>),
    sample: u32,
) {
    let same = |ask: &&mut Ask| ask.configuration == configuration && ask.variant == variant;
    match asks.iter_mut().find(same) {
        Some(ask) => ask.samples.push(sample),
        None => asks.push(Ask {
            configuration,
            variant,
            truth,
            samples: vec![sample],
        }),
    }
}

//! One question about many scenarios: what it would take, and asking it as a batch of the store.

use std::collections::BTreeMap;
use std::num::NonZeroU32;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use tokio::runtime::Handle;
use tokio::task::JoinSet;

use crate::features::experiment;
use crate::features::jobs::notes;
use crate::message::Effect;
use crate::model::{Batch, Counts, Job, JobId, JobKind, JobState, Model, Update};
use crate::request::{Replies, Request};
use crate::services::{Canceller, Services};
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::{EgoSelection, EntryLocation};
use nearmiss_scene::verdict::Task;
use nearmiss_store::{Item, ItemState, Store, StoreError};
use nearmiss_study::evaluation::JudgeOutcome;
use nearmiss_study::evaluation::batch::{Experiment, configuration_of_item};
use nearmiss_study::evaluation::{Answer, Judge, Judges, PromptConfig};
use nearmiss_workflow::batch::{
    self, BatchControl, BatchError, BatchPlan, BatchRequest, BatchRun, DryRun, DryRunEvent,
    PlanningEvent, ProviderSlots,
};
use std::time::Duration;

/// What can be begun, by its number; it is there once it is prepared.
pub(crate) type Prepared = Option<(JobId, Arc<OnceLock<Ready>>)>;

/// The batch that was estimated last.
#[derive(Default)]
struct Estimated(Prepared);

/// Bounds all batches that are asked.
#[derive(Default)]
struct Slots(Arc<ProviderSlots>);

/// A batch that can be begun.
pub(crate) struct Ready {
    pub plan: BatchPlan,
    pub dry_run: DryRun,
    pub judges: Judges,
}

/// Prepares all questions of a batch to know what they take, in place of one that was estimated before; nothing is
/// asked.
#[derive(Debug)]
pub struct EstimateBatch {
    /// Its number.
    pub id: JobId,
    /// The batch.
    pub batch: Arc<Batch>,
}

impl Request for EstimateBatch {
    /// The estimate, as far as known.
    type Reply = (JobId, Update<Counts, Counts>);

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let Self { id, batch } = self;
        if let Some((before, _)) = services.state::<Estimated>().0.take() {
            services.jobs.cancel(before);
        }
        let counts = Counts {
            budget: services.models.budget_left(),
            ..Counts::default()
        };
        let judge = services.judge(&batch.model, batch.experiment.parameters().tools);
        let (judge, store) = match judge.and_then(|judge| Ok((judge, services.open_store()?))) {
            Ok(both) => both,
            Err(why) => {
                let counts = Counts {
                    looked: batch.entries.len(),
                    refused: Some(why),
                    ..counts
                };
                replies.send((id, Update::Ended(Ok(counts))));
                return;
            }
        };
        let estimating = Estimating {
            batch,
            store,
            ego: services.ego.clone(),
            counts: Counts {
                at_once: batch::at_once(&judge, services.concurrency),
                ..counts
            },
            judge,
        };
        let ready = Arc::new(OnceLock::new());
        services.state::<Estimated>().0 = Some((id, Arc::clone(&ready)));
        let runtime = Handle::current();
        services.run(id, replies, move |cancel, progress| {
            Ok(estimating.run(&ready, &runtime, cancel, progress))
        });
    }

    fn reply(model: &mut Model, (id, update): Self::Reply) -> Vec<Effect> {
        let card = model.proposal.as_mut().filter(|card| card.id == id);
        if let (Some(card), Update::Progress(counts) | Update::Ended(Ok(counts))) = (card, update) {
            card.counts = counts;
        }
        Vec::new()
    }
}

/// How far a batch is.
#[derive(Debug)]
pub enum BatchProgress {
    /// The store knows it by this name, and it has so many questions to ask.
    Named(String, usize),
    /// A question of an experiment changed its state.
    Changed(Box<ItemChange>),
    /// A question was answered, or why not.
    Answered(Result<BatchAnswer, String>),
}

/// A question of an experiment changed its state.
#[derive(Debug, Clone, PartialEq)]
pub struct ItemChange {
    /// How it is asked.
    pub way: PromptConfig,
    /// Its state before.
    pub before: ItemState,
    /// Its state now.
    pub now: ItemState,
}

/// An answer within a batch.
#[derive(Debug)]
pub struct BatchAnswer {
    /// Its subject: hash of the scenario, ego, task.
    pub about: Option<(String, String, Task)>,
    /// The answer.
    pub answer: Box<Answer>,
    /// Whether the built-in judge says that the same question's scene is dangerous; nothing for other tasks.
    pub truth: Option<bool>,
}

/// Asking the questions of a batch.
pub type BatchUpdate = Update<BatchProgress, ()>;

/// Asks the questions of the batch that was estimated under the same number.
#[derive(Debug)]
pub struct AskBatch {
    /// Its number.
    pub id: JobId,
    /// The batch.
    pub batch: Arc<Batch>,
}

impl Request for AskBatch {
    type Reply = (JobId, BatchUpdate);

    fn sent(&self, model: &mut Model) {
        let count = self.batch.entries.len();
        let title = format!("{} on {count} scenarios", self.batch.model);
        let job = Job::new(self.id, JobKind::Batch, title, count, model.uptime);
        model.jobs.add(job);
    }

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let estimated = services.state::<Estimated>().0.take();
        ask(services, self.id, estimated, replies, false);
    }

    fn reply(model: &mut Model, (id, update): Self::Reply) -> Vec<Effect> {
        on_update(model, id, update)
    }
}

/// Takes the news of a batch or an experiment that is asked.
pub(crate) fn on_update(model: &mut Model, id: JobId, update: BatchUpdate) -> Vec<Effect> {
    if !notes::note(model, id, |job, now| note_batch(job, &update, now)) {
        return Vec::new();
    }
    let effects = experiment::on_batch(model, id, &update);
    super::on_update(model, id, update);
    effects
}

/// Asks the questions that were prepared under this number.
pub(crate) fn ask<R: Request<Reply = (JobId, BatchUpdate)>>(
    services: &mut Services,
    id: JobId,
    prepared: Prepared,
    replies: Replies<R>,
    tells_changes: bool,
) {
    let ready = prepared.filter(|(of, _)| *of == id);
    let (Some((_, ready)), Some(store)) = (ready, services.store.clone()) else {
        replies.send((id, Update::Ended(Ok(()))));
        return;
    };
    let control = BatchControl::default();
    let asking = Asking {
        id,
        ready,
        store,
        concurrency: services.concurrency,
        slots: Arc::clone(&services.state::<Slots>().0),
        control: control.clone(),
        replies,
        tells_changes,
    };
    let task = tokio::spawn(asking.run()).abort_handle();
    services.jobs.insert(id, Canceller::Batch(control), task);
}

/// Input of a batch estimate.
struct Estimating {
    batch: Arc<Batch>,
    judge: Judge,
    store: Arc<Store>,
    ego: EgoSelection,
    counts: Counts,
}

/// Input of asking a batch.
struct Asking<R> {
    id: JobId,
    ready: Arc<OnceLock<Ready>>,
    store: Arc<Store>,
    concurrency: NonZeroU32,
    slots: Arc<ProviderSlots>,
    control: BatchControl,
    replies: Replies<R>,
    /// Whether each change of a question is told, too.
    tells_changes: bool,
}

impl Batch {
    /// What the store is to keep of it.
    pub(crate) fn request(&self, ego: &EgoSelection) -> BatchRequest {
        let paths = self.entries.iter().map(|entry| match &entry.place {
            EntryLocation::File(path) => path.clone(),
            EntryLocation::Bundled(_) => PathBuf::from(&entry.name),
        });
        BatchRequest {
            experiment: Experiment {
                scenarios: paths.collect(),
                ..self.experiment.clone()
            },
            entries: self.entries.clone(),
            ego: ego.clone(),
            shard: None,
            drafts: BTreeMap::from_iter(self.draft.clone()),
        }
    }
}

impl Estimating {
    fn run(
        mut self,
        ready: &OnceLock<Ready>,
        runtime: &Handle,
        cancel: &Cancel,
        tell: &mut dyn FnMut(Counts),
    ) -> Option<Counts> {
        match self.ready(runtime, cancel, tell) {
            Ok(made) => {
                // It is set once.
                let _ = ready.set(made?);
            }
            Err(error) => self.counts.refused = Some(error.to_string()),
        }
        self.counts.looked = self.batch.entries.len();
        Some(self.counts)
    }

    fn ready(
        &mut self,
        runtime: &Handle,
        cancel: &Cancel,
        tell: &mut dyn FnMut(Counts),
    ) -> Result<Option<Ready>, BatchError> {
        let (batch, store) = (Arc::clone(&self.batch), Arc::clone(&self.store));
        let (library, thresholds) = (&batch.library, &batch.thresholds);
        let on_read = &mut |PlanningEvent::Read { done, of }| {
            self.counts.read = (done, of);
            tell(self.counts.clone());
        };
        let plan = batch
            .request(&self.ego)
            .plan(library, thresholds, cancel, on_read)?;
        let Some(plan) = plan else {
            return Ok(None);
        };
        self.counts.left_out.clone_from(&plan.left_out);
        let judges = Judges::from([(batch.model.clone(), self.judge.clone())]);
        let dry_run = plan.dry_run(&judges, &store, cancel, &mut |event| {
            let DryRunEvent::Described { done, dry_run } = event;
            self.note(done, dry_run);
            // Of the last ones it is told once it is known whether they can be asked.
            if done < plan.scenarios() {
                tell(self.counts.clone());
            }
        })?;
        let Some(dry_run) = dry_run else {
            return Ok(None);
        };
        let refused = runtime.block_on(dry_run.refused(&judges));
        self.counts.refused = refused.into_iter().next().map(|(_, why)| why);
        Ok(Some(Ready {
            plan,
            dry_run,
            judges,
        }))
    }

    fn note(&mut self, done: usize, dry_run: &DryRun) {
        self.counts.looked = done;
        self.counts.unlabelled = dry_run.unlabelled.len();
        self.counts.estimate.clone_from(&dry_run.estimate);
    }
}

impl<R: Request<Reply = (JobId, BatchUpdate)>> Asking<R> {
    async fn run(self) {
        let (id, replies, tells_changes) = (self.id, self.replies.clone(), self.tells_changes);
        let reply = |update| {
            replies.send((id, update));
        };
        let begun = tokio::task::spawn_blocking(move || self.begin()).await;
        let asked = match begun {
            Ok(Ok((run, items))) => {
                let named = BatchProgress::Named(run.id.to_string(), items.len());
                reply(Update::Progress(named));
                let mut judging = JoinSet::new();
                let asked = Arc::new(run)
                    .ask(items, |ended| {
                        let replies = replies.clone();
                        if tells_changes && let Ok(way) = configuration_of_item(&ended.item.asked) {
                            let change = ItemChange {
                                way,
                                before: ended.item.state,
                                now: ended.state,
                            };
                            let changed = BatchProgress::Changed(Box::new(change));
                            reply(Update::Progress(changed));
                        }
                        judging.spawn_blocking(move || {
                            let answered = BatchProgress::Answered(outcome(ended));
                            replies.send((id, Update::Progress(answered)));
                        });
                    })
                    .await;
                judging.join_all().await;
                for paused in asked.iter().flatten() {
                    replies.complain(paused.summary());
                }
                asked.map_err(|error| error.to_string())
            }
            Ok(Err(error)) => Err(error.to_string()),
            Err(error) => Err(error.to_string()),
        };
        reply(Update::Ended(asked.map(|_| ())));
    }

    /// Writes the batch into the store.
    fn begin(self) -> Result<(BatchRun, Vec<Item>), StoreError> {
        let Ready {
            plan,
            dry_run,
            judges,
        } = self.ready.wait();
        let id = plan.write(&self.store, dry_run)?;
        let (concurrency, slots) = (self.concurrency, self.slots);
        let mut run = BatchRun::new((id, plan), self.store, judges.clone(), concurrency, slots);
        run.control = self.control;
        let (items, _) = run.items(dry_run)?;
        Ok((run, items))
    }
}

/// The outcome of a batch question, beside the built-in judge's answer.
fn outcome(ended: batch::QuestionOutcome) -> Result<BatchAnswer, String> {
    let Some((question, answer)) = ended.answered else {
        return Err(ended.error.unwrap_or_default());
    };
    let case = &question.case;
    let scenario = case.scene.scenario.hash.to_string();
    Ok(BatchAnswer {
        about: Some((scenario, case.scene.ego.to_string(), case.task)),
        answer,
        truth: question.reference().map(|verdict| verdict.dangerous),
    })
}

/// Notes how far a batch is.
fn note_batch(job: &mut Job, update: &BatchUpdate, now: Duration) {
    match update {
        Update::Progress(BatchProgress::Named(name, questions)) => {
            job.batch = Some(name.clone());
            job.of = *questions;
            return;
        }
        Update::Progress(BatchProgress::Changed(_)) => return,
        Update::Progress(BatchProgress::Answered(Ok(ended))) => return answered(job, ended),
        Update::Progress(BatchProgress::Answered(Err(why))) => return failed(job, why),
        Update::Ended(Err(why)) => failed(job, why),
        Update::Ended(Ok(())) | Update::Cancelled => {}
    }
    let left = job.of.saturating_sub(job.done);
    let words = job.outcome();
    let state = match (left, job.tally.2 == job.done && job.done > 0) {
        (0, false) => JobState::Done(words),
        (0, true) => JobState::Failed(words),
        (left, _) => JobState::Cancelled(format!("{words}, {left} not asked")),
    };
    job.end(state, now);
}

/// A question of a batch has no answer.
fn failed(job: &mut Job, why: &str) {
    job.done += 1;
    job.tally.2 += 1;
    job.why.get_or_insert_with(|| why.into());
}

/// One answer of a batch is here.
fn answered(job: &mut Job, ended: &BatchAnswer) {
    let answer = &ended.answer;
    job.done += 1;
    if answer.past.is_none() {
        job.consumed(&answer.consumed);
    }
    let said = answer.verdict().map(|verdict| verdict.dangerous);
    match (&answer.judged, said, ended.truth) {
        (JudgeOutcome::Missing(missing), ..) => {
            job.tally.2 += 1;
            job.why.get_or_insert_with(|| missing.to_string());
        }
        (_, Some(said), Some(truth)) if said == truth => job.tally.0 += 1,
        (_, Some(_), Some(_)) => job.tally.1 += 1,
        _ => {}
    }
}

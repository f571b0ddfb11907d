//! One question about many scenarios: what it would take, and asking it as a batch of the store.

use std::collections::BTreeMap;
use std::num::NonZeroU32;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use tokio::runtime::Handle;
use tokio::sync::mpsc::UnboundedSender;
use tokio::task::JoinSet;

use super::Tasks;
use super::job::Canceller;
use crate::message::experiment::ItemChange;
use crate::message::runs::{Batch, BatchAnswer, Counts};
use crate::message::{BatchProgress, JobEvent, JobId, Msg, Update};
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::{EgoSelection, EntryLocation};
use nearmiss_store::{Item, Store, StoreError};
use nearmiss_study::evaluation::batch::{Experiment, configuration_of_item};
use nearmiss_study::evaluation::{Judge, Judges};
use nearmiss_workflow::batch::{
    self, BatchControl, BatchError, BatchPlan, BatchRequest, BatchRun, DryRun, DryRunEvent,
    PlanningEvent, ProviderSlots,
};

/// The batch that was estimated last, and what bounds those that are asked.
#[derive(Default)]
pub struct Batches {
    estimated: Option<(JobId, Arc<OnceLock<Ready>>)>,
    /// The experiment that was read last.
    pub(super) experiment: Option<(JobId, Arc<OnceLock<Ready>>)>,
    slots: Arc<ProviderSlots>,
}

/// A batch that can be begun.
pub(super) struct Ready {
    pub plan: BatchPlan,
    pub dry_run: DryRun,
    pub judges: Judges,
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
struct Asking {
    id: JobId,
    ready: Arc<OnceLock<Ready>>,
    store: Arc<Store>,
    concurrency: NonZeroU32,
    slots: Arc<ProviderSlots>,
    control: BatchControl,
    sender: UnboundedSender<Msg>,
    /// Whether each change of a question is told, too.
    tells_changes: bool,
}

impl Tasks {
    /// Prepares all questions of a batch, in place of one that was estimated before.
    pub(super) fn estimate(&mut self, id: JobId, batch: Arc<Batch>) {
        if let Some((before, _)) = self.batches.estimated.take() {
            self.jobs.cancel(before);
        }
        let counts = Counts {
            budget: self.models.budget_left(),
            ..Counts::default()
        };
        let judge = self.judge(&batch.model, batch.experiment.parameters().tools);
        let (judge, store) = match (judge, self.store.clone()) {
            (Ok(judge), Some(store)) => (judge, store),
            (judge, _) => {
                let no_store = || "the store of runs is not open".to_string();
                let counts = Counts {
                    looked: batch.entries.len(),
                    refused: Some(judge.err().unwrap_or_else(no_store)),
                    ..counts
                };
                let ended = JobEvent::Estimate(Update::Ended(Ok(counts)));
                let _ = self.sender.send(Msg::Job(id, ended));
                return;
            }
        };
        let estimating = Estimating {
            batch,
            store,
            ego: self.ego.clone(),
            counts: Counts {
                at_once: batch::at_once(&judge, self.concurrency),
                ..counts
            },
            judge,
        };
        let ready = Arc::new(OnceLock::new());
        self.batches.estimated = Some((id, Arc::clone(&ready)));
        let runtime = Handle::current();
        self.run(id, JobEvent::Estimate, move |cancel, tell| {
            Ok(estimating.run(&ready, &runtime, cancel, tell))
        });
    }

    /// Asks the questions of the batch that was estimated under this id.
    pub(super) fn begin(&mut self, id: JobId) {
        let estimated = self.batches.estimated.take();
        self.ask_ready(id, estimated, false);
    }

    /// Asks the questions of the experiment that was read under this id.
    pub(super) fn begin_experiment(&mut self, id: JobId) {
        let read = self.batches.experiment.take();
        self.ask_ready(id, read, true);
    }

    fn ask_ready(
        &mut self,
        id: JobId,
        estimated: Option<(JobId, Arc<OnceLock<Ready>>)>,
        tells_changes: bool,
    ) {
        let ready = estimated
            .filter(|(of, _)| *of == id)
            .map(|(_, ready)| ready);
        let (Some(ready), Some(store)) = (ready, self.store.clone()) else {
            let ended = JobEvent::Batch(Update::Ended(Ok(())));
            let _ = self.sender.send(Msg::Job(id, ended));
            return;
        };
        let control = BatchControl::default();
        let asking = Asking {
            id,
            ready,
            store,
            concurrency: self.concurrency,
            slots: Arc::clone(&self.batches.slots),
            control: control.clone(),
            sender: self.sender.clone(),
            tells_changes,
        };
        let task = tokio::spawn(asking.run()).abort_handle();
        self.jobs.insert(id, Canceller::Batch(control), task);
    }
}

impl Batch {
    /// What the store is to keep of it.
    pub(super) fn request(&self, ego: &EgoSelection) -> BatchRequest {
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

impl Asking {
    async fn run(self) {
        let (id, sender, tells_changes) = (self.id, self.sender.clone(), self.tells_changes);
        let tell = |update| drop(sender.send(Msg::Job(id, JobEvent::Batch(update))));
        let begun = tokio::task::spawn_blocking(move || self.begin()).await;
        let asked = match begun {
            Ok(Ok((run, items))) => {
                let named = BatchProgress::Named(run.id.to_string(), items.len());
                tell(Update::Progress(named));
                let mut judging = JoinSet::new();
                let asked = Arc::new(run)
                    .ask(items, |ended| {
                        let sender = sender.clone();
                        if tells_changes && let Ok(way) = configuration_of_item(&ended.item.asked) {
                            let change = ItemChange {
                                way,
                                before: ended.item.state,
                                now: ended.state,
                            };
                            let changed = BatchProgress::Changed(Box::new(change));
                            tell(Update::Progress(changed));
                        }
                        judging.spawn_blocking(move || {
                            let answered = BatchProgress::Answered(outcome(ended));
                            let event = JobEvent::Batch(Update::Progress(answered));
                            let _ = sender.send(Msg::Job(id, event));
                        });
                    })
                    .await;
                judging.join_all().await;
                for paused in asked.iter().flatten() {
                    let _ = sender.send(Msg::Complaint(paused.summary()));
                }
                asked.map_err(|error| error.to_string())
            }
            Ok(Err(error)) => Err(error.to_string()),
            Err(error) => Err(error.to_string()),
        };
        tell(Update::Ended(asked.map(|_| ())));
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

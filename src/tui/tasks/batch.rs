//! One question about many scenarios: what it would take, and asking it as a batch of the store.

use std::collections::{BTreeMap, HashMap};
use std::num::NonZeroU32;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use tokio::runtime::Handle;
use tokio::sync::mpsc::UnboundedSender;
use tokio::task::{AbortHandle, JoinSet};

use super::Tasks;
use crate::evaluation::batch::Matrix;
use crate::evaluation::{Judge, Judges};
use crate::formats::{EgoSelection, Place};
use crate::planner::Cancel;
use crate::store::{Item, Store, StoreError};
use crate::tui::message::Msg;
use crate::tui::message::runs::{Batch, BatchAsk, BatchId, BatchNews, Counts, Ended};
use crate::workflow::batch::{
    self, BatchControl, BatchError, BatchPlan, BatchRequest, BatchRun, DryRun, DryRunEvent,
    ProviderSlots,
};

/// Batches that are asked, and the one that is counted.
#[derive(Default)]
pub struct Batches {
    running: HashMap<BatchId, Running>,
    counted: Option<Counted>,
    slots: Arc<ProviderSlots>,
}

struct Running {
    control: BatchControl,
    task: AbortHandle,
}

/// A batch that is or was counted.
struct Counted {
    id: BatchId,
    cancel: Cancel,
    ready: Arc<OnceLock<Ready>>,
}

/// A batch that can be begun.
struct Ready {
    plan: BatchPlan,
    dry_run: DryRun,
    judges: Judges,
}

/// What counting a batch needs.
struct Counting {
    id: BatchId,
    batch: Arc<Batch>,
    judge: Judge,
    store: Arc<Store>,
    ego: EgoSelection,
    cancel: Cancel,
    counts: Counts,
    sender: UnboundedSender<Msg>,
}

/// What asking a batch needs.
struct Asking {
    id: BatchId,
    ready: Arc<OnceLock<Ready>>,
    store: Arc<Store>,
    concurrency: NonZeroU32,
    slots: Arc<ProviderSlots>,
    control: BatchControl,
    sender: UnboundedSender<Msg>,
}

impl Batches {
    /// Cancels everything; each task ends once the store says so.
    pub fn cancel(&mut self) -> Vec<AbortHandle> {
        self.stop_counting();
        let tasks = self.running.drain().map(|(_, running)| {
            running.control.cancel();
            running.task
        });
        tasks.collect()
    }

    fn stop_counting(&mut self) {
        if let Some(counted) = self.counted.take() {
            counted.cancel.ask();
        }
    }
}

impl Tasks {
    /// Does what is wanted with a batch.
    pub(super) fn batch(&mut self, ask: BatchAsk) {
        match ask {
            BatchAsk::Count(id, batch) => self.count(id, batch),
            BatchAsk::StopCounting => self.batches.stop_counting(),
            BatchAsk::Begin(id, _) => self.begin(id),
            BatchAsk::Stop(id) => {
                if let Some(Running { control, .. }) = self.batches.running.get(&id) {
                    // The first time it begins nothing more, the second time nothing goes on.
                    match control.is_stopped() {
                        true => control.cancel(),
                        false => control.stop(),
                    }
                }
            }
        }
    }

    fn count(&mut self, id: BatchId, batch: Arc<Batch>) {
        self.batches.stop_counting();
        let counts = Counts {
            budget: self.models.budget_left(),
            ..Counts::default()
        };
        let (judge, store) = match (self.judge(&batch.model), self.store.clone()) {
            (Ok(judge), Some(store)) => (judge, store),
            (judge, _) => {
                let no_store = || "the store of runs is not open".to_string();
                let counts = Counts {
                    looked: batch.entries.len(),
                    refused: Some(judge.err().unwrap_or_else(no_store)),
                    ..counts
                };
                let _ = self.sender.send(Msg::Batch(BatchNews::Counted(id, counts)));
                return;
            }
        };
        let (cancel, ready) = (Cancel::default(), Arc::new(OnceLock::new()));
        let counting = Counting {
            id,
            batch,
            store,
            ego: self.ego.clone(),
            cancel: cancel.clone(),
            counts: Counts {
                at_once: batch::at_once(&judge, self.concurrency),
                ..counts
            },
            judge,
            sender: self.sender.clone(),
        };
        let counted = Counted {
            id,
            cancel,
            ready: Arc::clone(&ready),
        };
        self.batches.counted = Some(counted);
        let runtime = Handle::current();
        tokio::task::spawn_blocking(move || counting.run(&ready, &runtime));
    }

    fn begin(&mut self, id: BatchId) {
        let counted = self
            .batches
            .counted
            .take()
            .filter(|counted| counted.id == id);
        let (Some(counted), Some(store)) = (counted, self.store.clone()) else {
            let _ = self.sender.send(Msg::Batch(BatchNews::Over(id)));
            return;
        };
        let control = BatchControl::default();
        let asking = Asking {
            id,
            ready: counted.ready,
            store,
            concurrency: self.concurrency,
            slots: Arc::clone(&self.batches.slots),
            control: control.clone(),
            sender: self.sender.clone(),
        };
        let task = tokio::spawn(asking.run()).abort_handle();
        self.batches.running.retain(|_, r| !r.task.is_finished());
        self.batches.running.insert(id, Running { control, task });
    }
}

impl Batch {
    /// What the store is to keep of it.
    fn request(&self, ego: &EgoSelection) -> BatchRequest {
        let paths = self.entries.iter().map(|entry| match &entry.place {
            Place::File(path) => path.clone(),
            Place::Bundled(_) => PathBuf::from(&entry.name),
        });
        BatchRequest {
            paths: paths.collect(),
            entries: self.entries.clone(),
            matrix: Matrix {
                tasks: vec![self.task],
                frames: vec![self.frame],
                techniques: vec![self.techniques],
                models: vec![self.model.clone()],
                samples: 1,
                more_leads: Vec::new(),
                transforms: Vec::new(),
                request: self.request,
            },
            ego: ego.clone(),
            truth: None,
            shard: None,
            drafts: BTreeMap::from_iter(self.draft.clone()),
            base_url: None,
        }
    }
}

impl Counting {
    fn run(mut self, ready: &OnceLock<Ready>, runtime: &Handle) {
        match self.ready(runtime) {
            Ok(None) => return,
            // It is set once.
            Ok(Some(made)) => drop(ready.set(made)),
            Err(error) => self.counts.refused = Some(error.to_string()),
        }
        self.counts.looked = self.batch.entries.len();
        self.tell();
    }

    fn ready(&mut self, runtime: &Handle) -> Result<Option<Ready>, BatchError> {
        let (batch, store) = (Arc::clone(&self.batch), Arc::clone(&self.store));
        let plan = batch
            .request(&self.ego)
            .plan(&batch.library, &batch.thresholds)?;
        let judges = Judges::from([(batch.model.clone(), self.judge.clone())]);
        let cancel = self.cancel.clone();
        let dry_run = plan.dry_run(&judges, &store, &cancel, &mut |event| {
            let DryRunEvent::Described { done, dry_run } = event;
            self.note(done, dry_run);
            // Of the last ones it is told once it is known whether they can be asked.
            if done < plan.scenarios() {
                self.tell();
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

    fn tell(&self) {
        let news = BatchNews::Counted(self.id, self.counts.clone());
        // The receiver is gone once the loop has ended.
        let _ = self.sender.send(Msg::Batch(news));
    }
}

impl Asking {
    async fn run(self) {
        let (id, sender) = (self.id, self.sender.clone());
        let tell = |news| {
            let _ = sender.send(Msg::Batch(news));
        };
        let begun = tokio::task::spawn_blocking(move || self.begin()).await;
        match begun {
            Ok(Ok((run, items))) => {
                tell(BatchNews::Named(id, run.id.to_string(), items.len()));
                let mut judging = JoinSet::new();
                let asked = Arc::new(run).ask(items, |ended| {
                    let sender = sender.clone();
                    judging.spawn_blocking(move || {
                        let _ = sender.send(Msg::Batch(BatchNews::Ended(id, outcome(ended))));
                    });
                });
                let asked = asked.await;
                judging.join_all().await;
                if let Err(error) = asked {
                    tell(BatchNews::Ended(id, Err(error.to_string())));
                }
            }
            Ok(Err(error)) => tell(BatchNews::Ended(id, Err(error.to_string()))),
            Err(error) => tell(BatchNews::Ended(id, Err(error.to_string()))),
        }
        tell(BatchNews::Over(id));
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

/// What a question of a batch came to, beside what the built-in judge says to it.
fn outcome(ended: batch::Ended) -> Result<Ended, String> {
    let Some((question, answer)) = ended.answered else {
        return Err(ended.error.unwrap_or_default());
    };
    let case = &question.case;
    let scenario = case.scene.scenario.hash.to_string();
    Ok(Ended {
        about: Some((scenario, case.scene.ego.to_string(), case.task)),
        answer,
        truth: question.reference().map(|verdict| verdict.dangerous),
    })
}

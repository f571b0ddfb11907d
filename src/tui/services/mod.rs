//! What requests work with outside the model: the user's files, the store, models, and what runs.

mod queue;

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::num::NonZeroU32;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use nearmiss_ask::llm::{Environment, Registry, ToolLimits};
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::{ExternalPlanner, Settings};
use nearmiss_formats::EgoSelection;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_settings::{Config, Folders};
use nearmiss_store::Store;
use nearmiss_study::evaluation::Judge;
use nearmiss_workflow::batch::BatchControl;
use nearmiss_workflow::{Models, parameters};
use tokio::sync::mpsc::UnboundedSender;
use tokio::task::AbortHandle;

use crate::message::{Effect, Msg};
use crate::model::{JobId, Update};
use crate::request::{Replies, Request};

pub use queue::Queue;

/// Times five milliseconds that cancelled questions have to be written down.
const SETTLE_TRIES: usize = 100;

/// What requests work with.
pub struct Services {
    /// Where messages go.
    pub sender: UnboundedSender<Msg>,
    /// The user's folders.
    pub folders: Folders,
    /// The models that can be asked; this session's budget bounds what they cost.
    pub models: Models,
    /// The thresholds of risk scores.
    pub thresholds: Arc<Thresholds>,
    /// The store of runs, where it can be opened.
    pub store: Option<Arc<Store>>,
    /// The ego of a scenario where no obstacle is taken in its place.
    pub ego: EgoSelection,
    /// What runs.
    pub jobs: RunningJobs,
    /// Pictures that are being drawn.
    pub drawing: Drawing,
    /// How the configuration wants the ego to be planned.
    pub planning: Settings,
    /// The planners of the configuration that are processes.
    planners: Vec<Arc<ExternalPlanner>>,
    /// The user's providers, as the configuration has them.
    pub providers: toml::Table,
    /// Requests of batches at once, to one provider.
    pub concurrency: NonZeroU32,
    /// What requests of a type leave for the next ones.
    state: HashMap<TypeId, Box<dyn Any + Send>>,
}

impl Services {
    /// Ready for work.
    #[must_use]
    pub fn new(
        sender: UnboundedSender<Msg>,
        folders: Folders,
        (registry, environment): (Registry, Environment),
        config: &Config,
        thresholds: Arc<Thresholds>,
        store: Option<Arc<Store>>,
        ego: EgoSelection,
    ) -> Self {
        Self {
            sender,
            folders,
            models: Models::new(registry, environment, parameters(config), config.budget),
            thresholds,
            store,
            ego,
            jobs: RunningJobs::default(),
            drawing: Drawing::default(),
            planning: (&config.planning()).into(),
            planners: { config.external_planners().into_iter() }
                .map(|(name, options)| Arc::new(ExternalPlanner::new(name, options)))
                .collect(),
            providers: config.provider.clone(),
            concurrency: config.at_once(),
            state: HashMap::new(),
        }
    }

    /// Begins what an effect asks for; gives back what only the loop, which owns the terminal, can do.
    pub fn perform(&mut self, effect: Effect) -> Option<Effect> {
        match effect {
            Effect::Request(request) => request.perform(self),
            Effect::Cancel(id) => self.jobs.cancel(id),
            other => return Some(other),
        }
        None
    }

    /// What requests left here.
    pub fn state<T: Default + Send + 'static>(&mut self) -> &mut T {
        let entry = self.state.entry(TypeId::of::<T>());
        let state = entry.or_insert_with(|| Box::<T>::default());
        match state.downcast_mut() {
            Some(state) => state,
            None => unreachable!("it is kept by its type"),
        }
    }

    /// Works on a thread of its own, and replies.
    pub fn background<R: Request>(
        &self,
        replies: Replies<R>,
        work: impl FnOnce() -> R::Reply + Send + 'static,
    ) {
        tokio::task::spawn_blocking(move || replies.send(work()));
    }

    /// Works on the store on a thread of its own, or says that there is none.
    pub fn with_store<R: Request>(
        &self,
        replies: Replies<R>,
        work: impl FnOnce(Result<Arc<Store>, String>) -> R::Reply + Send + 'static,
    ) {
        let store = self.open_store();
        self.background(replies, move || work(store));
    }

    /// The store of runs.
    ///
    /// # Errors
    /// It could not be opened.
    pub fn open_store(&self) -> Result<Arc<Store>, String> {
        let store = self.store.clone();
        store.ok_or_else(|| "the store of runs is not open".to_string())
    }

    /// Runs a job on a thread of its own; it gives nothing where it was cancelled.
    pub fn run<R, P, T>(
        &mut self,
        id: JobId,
        replies: Replies<R>,
        work: impl FnOnce(&Cancel, &mut dyn FnMut(P)) -> Result<Option<T>, String> + Send + 'static,
    ) where
        R: Request<Reply = (JobId, Update<P, T>)>,
    {
        let cancel = Cancel::default();
        let flag = cancel.clone();
        let task = tokio::task::spawn_blocking(move || {
            // Where the receiver is gone the loop has ended; that cancels.
            let reply = |update| {
                replies.send((id, update));
            };
            let outcome = work(&flag, &mut |progress| reply(Update::Progress(progress)));
            reply(match outcome.transpose() {
                Some(outcome) => Update::Ended(outcome),
                None => Update::Cancelled,
            });
        });
        self.jobs
            .insert(id, Canceller::Flag(cancel), task.abort_handle());
    }

    /// The judge with a model id, which may call tools as often; all share the budget of the session.
    ///
    /// # Errors
    /// No such model is known: in words.
    pub fn judge(&self, model: &str, tools: Option<ToolLimits>) -> Result<Judge, String> {
        let judge = self.models.judge(model).map_err(|error| error.to_string());
        Ok(judge?.with_tools(tools))
    }

    /// The planner with this place among those of the configuration, from 1; `None` for the built-in one, 0.
    #[must_use]
    pub fn planner(&self, place: usize) -> Option<Arc<ExternalPlanner>> {
        self.planners.get(place.checked_sub(1)?).cloned()
    }

    /// Cancels what is on its way and waits until that is written down.
    pub async fn finish(&mut self) {
        self.jobs.cancel_all();
        self.drawing.stop();
        for _ in 0..SETTLE_TRIES {
            if self.jobs.is_settled() && self.drawing.ended() {
                return;
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    }
}

/// Pictures that are being drawn. What is stopped leaves nothing behind.
#[derive(Debug, Default)]
pub struct Drawing {
    stop: Arc<AtomicBool>,
    /// Each drawing task holds one.
    held: Arc<()>,
}

/// A guard for a picture being drawn.
#[derive(Debug)]
pub struct DrawGuard {
    stop: Arc<AtomicBool>,
    _held: Arc<()>,
}

impl DrawGuard {
    /// Set once it shall end.
    pub fn stop(&self) -> &AtomicBool {
        &self.stop
    }
}

impl Drawing {
    /// Another one begins.
    pub fn begin(&self) -> DrawGuard {
        DrawGuard {
            stop: Arc::clone(&self.stop),
            _held: Arc::clone(&self.held),
        }
    }

    /// All shall end.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether the drawing thread has ended.
    pub fn ended(&self) -> bool {
        Arc::strong_count(&self.held) == 1
    }
}

/// How a job is cancelled.
pub enum Canceller {
    /// It looks at a flag.
    Flag(Cancel),
    /// Its task is aborted, which writes down what was asked as cancelled.
    Abort,
    /// It first begins nothing more, then ends what it began.
    Batch(BatchControl),
}

/// A job that runs. Dropping it cancels.
struct Handle {
    canceller: Canceller,
    task: AbortHandle,
}

impl Drop for Handle {
    fn drop(&mut self) {
        match &self.canceller {
            Canceller::Flag(cancel) => cancel.ask(),
            Canceller::Abort => self.task.abort(),
            Canceller::Batch(control) => control.cancel(),
        }
    }
}

/// All jobs that run.
#[derive(Default)]
pub struct RunningJobs {
    handles: HashMap<JobId, Handle>,
    /// Cancelled, and not yet written down.
    ending: Vec<AbortHandle>,
}

impl RunningJobs {
    /// Adds one; another one of the same id is cancelled.
    pub fn insert(&mut self, id: JobId, canceller: Canceller, task: AbortHandle) {
        self.handles.retain(|_, handle| !handle.task.is_finished());
        self.handles.insert(id, Handle { canceller, task });
    }

    /// Cancels one. A batch goes on with what it began until it is cancelled once more.
    pub fn cancel(&mut self, id: JobId) {
        let handle = self.handles.get(&id);
        if let Some(Canceller::Batch(control)) = handle.map(|handle| &handle.canceller)
            && !control.is_stopped()
        {
            control.stop();
        } else if let Some(handle) = self.handles.remove(&id) {
            self.end(&handle);
        }
    }

    /// Cancels all.
    pub fn cancel_all(&mut self) {
        for (_, handle) in std::mem::take(&mut self.handles) {
            self.end(&handle);
        }
    }

    /// Waits at the end of the program for this task, too.
    pub fn wait_for(&mut self, task: AbortHandle) {
        self.ending.retain(|task| !task.is_finished());
        self.ending.push(task);
    }

    /// Whether everything that was cancelled is written down.
    pub fn is_settled(&self) -> bool {
        self.ending.iter().all(AbortHandle::is_finished)
    }

    /// Jobs that only work in memory are not waited for.
    fn end(&mut self, handle: &Handle) {
        if !matches!(handle.canceller, Canceller::Flag(_)) {
            self.wait_for(handle.task.clone());
        }
    }
}

//! Runs a batch: every question that is open is asked, stored and counted, until it is done or stopped.

use std::collections::{BTreeMap, HashMap};
use std::num::NonZeroU32;
use std::sync::{Arc, Mutex, PoisonError};

use nearmiss_ask::llm::ProviderOutage;
use nearmiss_store::{BatchId, Item, ItemState, Key, RunId, SplitPart, Store, StoreError};
use nearmiss_study::evaluation::batch::{QuestionBuilder, configuration_of_item, question_key};
use nearmiss_study::evaluation::{
    Answer, AskError, Event, Judge, JudgeOutcome, Judges, MissingVerdict, Question, RunOptions,
};
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};
use tokio::sync::{Semaphore, watch};
use tokio::task::JoinSet;

use super::judges::Watch;
use super::{BatchPlan, DryRun, PausedModel, Selection};
use crate::{AskOutcome, AskRequest, ask};

/// Outcome of one question.
#[derive(Debug, Clone)]
pub struct QuestionOutcome {
    /// The question, as the store had it before.
    pub item: Item,
    /// Where it stands now.
    pub state: ItemState,
    /// Why it has no whole answer, or was not asked.
    pub error: Option<String>,
    /// The question and its answer; `None` if it was not asked.
    pub answered: Option<(Arc<Question>, Box<Answer>)>,
}

impl QuestionOutcome {
    /// Whether the store had the answer.
    #[must_use]
    pub fn is_stored(&self) -> bool {
        let answer = self.answered.as_ref().map(|(_, answer)| answer);
        answer.is_some_and(|answer| answer.past.is_some())
    }

    /// What was paid for it now, US dollars, where that is known.
    #[must_use]
    pub fn cost_usd(&self) -> Option<f64> {
        let (_, answer) = self.answered.as_ref().filter(|_| !self.is_stored())?;
        answer.consumed.cost_usd
    }

    /// Whether its model was tried now, so that it tells something of the server.
    fn was_sent(&self) -> bool {
        let tried = [ItemState::Answered, ItemState::Truncated, ItemState::Failed];
        !self.is_stored() && tried.contains(&self.state)
    }
}

/// A batch that is asked.
pub struct BatchRun {
    /// The batch.
    pub id: BatchId,
    /// Stops or cancels it.
    pub control: BatchControl,
    pub(super) store: Arc<Store>,
    pub(super) builder: Arc<QuestionBuilder>,
    pub(super) judges: Judges,
    selection: Selection,
    /// The part of its split that is asked; `None` for all.
    part: Option<SplitPart>,
    /// Requests of each provider that are on their way at once, at least one.
    at_once: BTreeMap<String, usize>,
    slots: Arc<ProviderSlots>,
}

/// Requests to a judge that are on their way at once: as many as its provider takes, at most `concurrency`. The
/// built-in judge answers on all cores, and recorded answers are looked up there.
#[must_use]
pub fn at_once(judge: &Judge, concurrency: NonZeroU32) -> usize {
    match judge {
        Judge::Reference | Judge::Recorded(_) => {
            std::thread::available_parallelism().map_or(1, usize::from)
        }
        Judge::Model(model) => {
            let own = model.endpoint.limits.concurrency;
            own.map_or(concurrency, |own| own.min(concurrency)).get() as usize
        }
    }
}

impl BatchRun {
    /// A batch that is in the store. `concurrency` bounds the requests to each provider that are on their way at once;
    /// batches with the same `slots` share them.
    #[must_use]
    pub fn new(
        (id, plan): (BatchId, &BatchPlan),
        store: Arc<Store>,
        judges: Judges,
        concurrency: NonZeroU32,
        slots: Arc<ProviderSlots>,
    ) -> Self {
        let at_once = judges.iter().map(|(model, judge)| {
            let provider = model.split('/').next().unwrap_or_default();
            (provider.to_string(), at_once(judge, concurrency))
        });
        Self {
            id,
            control: BatchControl::default(),
            store,
            builder: Arc::clone(&plan.builder),
            selection: plan.selection,
            part: plan.part,
            at_once: at_once.collect(),
            judges,
            slots,
        }
    }

    /// The questions to ask, and how many others are already with a provider. Never-asked questions come first: those
    /// that failed before may fail again and again.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn items(&self, dry_run: &DryRun) -> Result<(Vec<Item>, usize), StoreError> {
        let mut items = self.store.items(self.id)?;
        items.retain(|item| self.selection.selects(item));
        items.retain(|item| self.part.is_none() || item.asked.split == self.part);
        items.sort_by_key(|item| item.state != ItemState::Waiting);
        dry_run.copy_keys(&mut items);
        self.without_submitted(items)
    }

    /// The questions of the part that is asked that failed, were cut off or have no readable verdict.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn failed(&self, dry_run: &DryRun) -> Result<Vec<Item>, StoreError> {
        let mut items = self.store.items(self.id)?;
        items.retain(|item| item.state != ItemState::Unaskable && Selection::Failed.selects(item));
        items.retain(|item| self.part.is_none() || item.asked.split == self.part);
        dry_run.copy_keys(&mut items);
        Ok(self.without_submitted(items)?.0)
    }

    /// Asks these questions and reports the outcome of each; returns when all are done, or when it was stopped and
    /// requests in progress have ended. Models whose server does not answer or refuses them are asked no further: their
    /// questions keep their state, and those models are returned. Dropping the future cancels requests in progress.
    ///
    /// # Errors
    /// The store cannot record what arrives; nothing more is asked then.
    pub async fn ask(
        self: Arc<Self>,
        items: Vec<Item>,
        mut on_event: impl FnMut(QuestionOutcome),
    ) -> Result<Vec<PausedModel>, StoreError> {
        let mut by_provider: BTreeMap<String, Vec<Item>> = BTreeMap::new();
        for item in items {
            let provider = item.asked.model.split('/').next().unwrap_or_default();
            by_provider
                .entry(provider.to_string())
                .or_default()
                .push(item);
        }
        let (sender, mut receiver) = unbounded_channel();
        let mut providers = JoinSet::new();
        for (provider, items) in by_provider {
            let at_once = self.at_once.get(&provider).copied().unwrap_or(1).max(1);
            let (run, sender) = (Arc::clone(&self), sender.clone());
            providers.spawn(async move { run.provider(provider, items, at_once, &sender).await });
        }
        drop(sender);
        let mut refused = None;
        while let Some(ended) = receiver.recv().await {
            match ended {
                Ok(ended) => on_event(ended),
                Err(error) => {
                    self.control.stop();
                    refused.get_or_insert(error);
                }
            }
        }
        let mut paused: Vec<PausedModel> =
            providers.join_all().await.into_iter().flatten().collect();
        paused.sort_by(|a, b| a.who.cmp(&b.who));
        refused.map_or(Ok(paused), Err)
    }

    /// The questions to one provider, in their order, so many at once.
    async fn provider(
        self: Arc<Self>,
        provider: String,
        items: Vec<Item>,
        at_once: usize,
        sender: &UnboundedSender<Result<QuestionOutcome, StoreError>>,
    ) -> Vec<PausedModel> {
        let slots = self.slots.of_provider(&provider, at_once);
        let mut watch = Watch::new(provider);
        let mut waiting = items.into_iter();
        let mut going = JoinSet::new();
        loop {
            while going.len() < at_once && !self.control.is_stopped() {
                let Some(item) = waiting.find(|item| !watch.holds(&item.asked.model)) else {
                    break;
                };
                let (run, slots) = (Arc::clone(&self), Arc::clone(&slots));
                let sender = sender.clone();
                going.spawn(async move { run.one(item, &slots, &sender).await });
            }
            match going.join_next().await {
                None => return watch.over(),
                Some(Ok(Some((model, met)))) => watch.record_outcome(&model, met),
                // Nothing was to be learnt of its server.
                Some(_) => {}
            }
        }
    }

    /// Asks one question once there is a slot for it, unless the batch ends before; what was met of the model's server,
    /// where it was tried.
    async fn one(
        &self,
        item: Item,
        slots: &Semaphore,
        sender: &UnboundedSender<Result<QuestionOutcome, StoreError>>,
    ) -> Option<(String, Option<(ProviderOutage, String)>)> {
        // The semaphore is never closed.
        let _slot = slots.acquire().await;
        if self.control.is_stopped() {
            return None;
        }
        let model = item.asked.model.clone();
        let mut barrier = None;
        let ended = tokio::select! {
            biased;
            () = self.control.cancelled() => return None,
            ended = self.answer(item, &mut barrier) => ended,
        };
        if ended.is_err() {
            // Before the next one is begun.
            self.control.stop();
        }
        let heard = ended.as_ref().is_ok_and(QuestionOutcome::was_sent);
        let why = ended.as_ref().ok().and_then(|ended| ended.error.clone());
        // The receiver is gone where the whole was dropped.
        let _ = sender.send(ended);
        heard.then(|| (model, barrier.map(|met| (met, why.unwrap_or_default()))))
    }

    async fn answer(
        &self,
        item: Item,
        barrier: &mut Option<ProviderOutage>,
    ) -> Result<QuestionOutcome, StoreError> {
        let judge = match configuration_of_item(&item.asked) {
            Ok(configuration) => self.judges[&item.asked.model].under(&configuration.settings),
            Err(why) => return self.unanswered(item, None, ItemState::Unaskable, why),
        };
        let judge = &*judge;
        let question = match self.question(&item).await {
            Ok(question) => question,
            Err(why) => return self.unanswered(item, None, ItemState::Unaskable, why),
        };
        let key = question_key(&question, judge)?;
        let request = AskRequest {
            question: &question,
            judge,
            store: Some(Arc::clone(&self.store)),
            options: self.options(&item),
        };
        let hear = |event| {
            if let Event::Barred(met) = event {
                *barrier = Some(met);
            }
        };
        match ask(request, hear).await {
            Ok(AskOutcome {
                not_stored: Some(why),
                ..
            }) => Err(StoreError::Unstored(why)),
            Ok(AskOutcome { answer, .. }) => self.answered(item, key.as_ref(), question, answer),
            Err(AskError::Refused(why) | AskError::OverBudget(why)) => {
                self.unanswered(item, key.as_ref(), ItemState::Waiting, why)
            }
            Err(AskError::NotRecorded(why)) => {
                self.unanswered(item, None, ItemState::Unaskable, why)
            }
            Err(AskError::Store(error)) => Err(error),
        }
    }

    /// Which answer an item wants.
    pub(super) fn options(&self, item: &Item) -> RunOptions {
        RunOptions {
            sample: item.asked.sample,
            fresh: Selection::Failed.asks_anew(item),
            batch: Some(self.id.to_string()),
        }
    }

    /// Makes the question where it does not keep others waiting.
    async fn question(&self, item: &Item) -> Result<Arc<Question>, String> {
        let (builder, asked) = (Arc::clone(&self.builder), item.asked.clone());
        let made = tokio::task::spawn_blocking(move || builder.question_of_item(&asked)).await;
        let (_, question) = made.map_err(|error| format!("cannot be computed: {error}"))??;
        Ok(question)
    }

    fn answered(
        &self,
        item: Item,
        key: Option<&Key>,
        question: Arc<Question>,
        answer: Answer,
    ) -> Result<QuestionOutcome, StoreError> {
        let (state, error) = match &answer.judged {
            JudgeOutcome::Missing(MissingVerdict::Cancelled) => (ItemState::Waiting, None),
            JudgeOutcome::Missing(
                missing @ (MissingVerdict::NoAnswer(_) | MissingVerdict::NotSent(_)),
            ) => (ItemState::Failed, Some(missing.to_string())),
            JudgeOutcome::Missing(missing) if !answer.is_complete() => {
                (ItemState::Truncated, Some(missing.to_string()))
            }
            _ if !answer.is_complete() => {
                let why = "the server ended the answer early";
                let why = answer.cut_off().unwrap_or_else(|| why.to_string());
                (ItemState::Truncated, Some(why))
            }
            _ => (ItemState::Answered, None),
        };
        self.set(&item, key, state, answer.run, error.as_deref())?;
        Ok(QuestionOutcome {
            item,
            state,
            error,
            answered: Some((question, Box::new(answer))),
        })
    }

    fn unanswered(
        &self,
        item: Item,
        key: Option<&Key>,
        state: ItemState,
        why: String,
    ) -> Result<QuestionOutcome, StoreError> {
        self.set(&item, key, state, None, Some(&why))?;
        Ok(QuestionOutcome {
            item,
            state,
            error: Some(why),
            answered: None,
        })
    }

    fn set(
        &self,
        item: &Item,
        key: Option<&Key>,
        state: ItemState,
        run: Option<RunId>,
        error: Option<&str>,
    ) -> Result<(), StoreError> {
        // An answer without a verdict stays the answer until another whole one takes its place.
        if self.selection.asks_anew(item) && state != ItemState::Answered {
            return Ok(());
        }
        self.store
            .set_item(self.id, item.place, key, state, run, error)
    }
}

/// Stops or cancels a batch; its clones are the same control.
#[derive(Debug, Clone)]
pub struct BatchControl(Arc<watch::Sender<Phase>>);

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd)]
enum Phase {
    Asking,
    Stopped,
    Cancelled,
}

impl Default for BatchControl {
    fn default() -> Self {
        Self(Arc::new(watch::Sender::new(Phase::Asking)))
    }
}

impl BatchControl {
    /// Begins no further question; what was sent is waited for.
    pub fn stop(&self) {
        self.advance(Phase::Stopped);
    }

    /// Cancels also requests already sent, and records that in the store.
    pub fn cancel(&self) {
        self.advance(Phase::Cancelled);
    }

    /// Whether no further question is begun.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        *self.0.borrow() >= Phase::Stopped
    }

    /// Waits until the batch is cancelled.
    pub(super) async fn cancelled(&self) {
        // This holds the sender, so the channel stays open.
        let _ = self
            .0
            .subscribe()
            .wait_for(|phase| *phase == Phase::Cancelled)
            .await;
    }

    fn advance(&self, phase: Phase) {
        self.0.send_if_modified(|now| {
            let further = *now < phase;
            if further {
                *now = phase;
            }
            further
        });
    }
}

/// Requests to each provider that are on their way at once, over all batches of the program.
#[derive(Debug, Default)]
pub struct ProviderSlots(Mutex<HashMap<String, Arc<Semaphore>>>);

impl ProviderSlots {
    /// The slots of a provider, `most` where it has none yet.
    pub(super) fn of_provider(&self, provider: &str, most: usize) -> Arc<Semaphore> {
        let mut slots = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let slots = slots.entry(provider.to_string());
        Arc::clone(slots.or_insert_with(|| Arc::new(Semaphore::new(most))))
    }
}

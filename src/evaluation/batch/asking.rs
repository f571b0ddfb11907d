//! Asking the questions of a batch: several at once of every provider, each outcome written down as it comes.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};
use tokio::task::JoinSet;

use super::paused::{Paused, Watch};
use super::question_builder::{Desk, key};
use super::scored::{label_of, way_of};
use super::variant::Variant;
use crate::evaluation::{self, Answer, AskError, Event, Judge, Judged, Missing, Question, Wanted};
use crate::llm::ProviderOutage;
use crate::scenario::Entry;
use crate::store::{BatchId, Item, ItemState, Key, RunId, Store, StoreError};

/// Who is asked, by model id.
pub type Judges = BTreeMap<String, Judge>;

/// Which questions of a batch are asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Selection {
    /// Those that have no whole answer, without those that the server cut off: it would do so again.
    Open,
    /// Those to which no whole answer came, with those that were cut off.
    Failed,
}

impl Selection {
    /// Whether a question is among them.
    #[must_use]
    pub fn has(self, state: ItemState) -> bool {
        use ItemState::{Answered, Failed, Truncated, Unaskable, Waiting};
        match (self, state) {
            (_, Answered) => false,
            (Self::Open, Truncated) | (Self::Failed, Waiting) => false,
            (Self::Open, Waiting | Failed | Unaskable) => true,
            (Self::Failed, Failed | Truncated | Unaskable) => true,
        }
    }
}

/// What became of one question.
#[derive(Debug, Clone, PartialEq)]
pub struct Ended {
    /// Its place in the batch.
    pub place: u64,
    /// Where it stands now.
    pub state: ItemState,
    /// Why it has no whole answer, or was not asked.
    pub error: Option<String>,
    /// Whether the store had the answer.
    pub stored: bool,
    /// What it cost, US dollars, where that is known.
    pub cost_usd: Option<f64>,
}

impl Ended {
    /// Whether its model was tried now, so that it tells something of the server.
    fn was_sent(&self) -> bool {
        let tried = [ItemState::Answered, ItemState::Truncated, ItemState::Failed];
        !self.stored && tried.contains(&self.state)
    }
}

/// A batch that is asked. Dropping the future of [`Asking::all`] cancels what is on its way and writes that down.
pub struct Asking {
    /// Where everything is kept.
    pub store: Arc<Store>,
    /// The batch.
    pub batch: BatchId,
    /// What makes the questions.
    pub desk: Arc<Desk>,
    /// Who is asked.
    pub judges: Judges,
    /// Requests of each provider that are on their way at once, at least one.
    pub at_once: BTreeMap<String, usize>,
    /// Set: nothing more is begun.
    pub stop: Arc<AtomicBool>,
}

impl Asking {
    /// Asks these questions and tells what becomes of each; returns when all are through, or when it was stopped and
    /// everything that was on its way is. Models whose server does not answer or refuses them are asked no further: their
    /// questions stay as they were, and who that is comes back.
    ///
    /// # Errors
    /// The store cannot keep what arrives; nothing more is asked then.
    pub async fn all(
        self: Arc<Self>,
        items: Vec<Item>,
        mut tell: impl FnMut(Ended),
    ) -> Result<Vec<Paused>, StoreError> {
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
            let (asking, sender) = (Arc::clone(&self), sender.clone());
            providers
                .spawn(async move { asking.provider(provider, items, at_once, &sender).await });
        }
        drop(sender);
        let mut refused = None;
        while let Some(ended) = receiver.recv().await {
            match ended {
                Ok(ended) => tell(ended),
                Err(error) => {
                    self.stop.store(true, Ordering::SeqCst);
                    refused.get_or_insert(error);
                }
            }
        }
        let mut paused: Vec<Paused> = providers.join_all().await.into_iter().flatten().collect();
        paused.sort_by(|a, b| a.who.cmp(&b.who));
        refused.map_or(Ok(paused), Err)
    }

    /// The questions to one provider, in their order, so many at once.
    async fn provider(
        self: Arc<Self>,
        provider: String,
        items: Vec<Item>,
        at_once: usize,
        sender: &UnboundedSender<Result<Ended, StoreError>>,
    ) -> Vec<Paused> {
        let mut watch = Watch::new(provider);
        let mut waiting = items.into_iter();
        let mut going = JoinSet::new();
        loop {
            while going.len() < at_once && !self.stop.load(Ordering::SeqCst) {
                let Some(item) = waiting.find(|item| !watch.holds(&item.asked.model)) else {
                    break;
                };
                let (asking, sender) = (Arc::clone(&self), sender.clone());
                going.spawn(async move {
                    let model = item.asked.model.clone();
                    let mut barrier = None;
                    let ended = asking.one(item, &mut barrier).await;
                    if ended.is_err() {
                        // Before the next one is begun.
                        asking.stop.store(true, Ordering::SeqCst);
                    }
                    let heard = ended.as_ref().is_ok_and(Ended::was_sent);
                    let why = ended.as_ref().ok().and_then(|ended| ended.error.clone());
                    // The receiver is gone where the whole was dropped.
                    let _ = sender.send(ended);
                    heard.then(|| (model, barrier.map(|met| (met, why.unwrap_or_default()))))
                });
            }
            match going.join_next().await {
                None => return watch.over(),
                Some(Ok(Some((model, met)))) => watch.hear(&model, met),
                // Nothing was to be learnt of its server.
                Some(_) => {}
            }
        }
    }

    async fn one(
        &self,
        item: Item,
        barrier: &mut Option<ProviderOutage>,
    ) -> Result<Ended, StoreError> {
        let judge = &self.judges[&item.asked.model];
        let question = match self.question(&item).await {
            Ok(question) => question,
            Err(why) => return self.ended(&item, None, ItemState::Unaskable, why),
        };
        let key = key(&question, judge)?;
        let wanted = Wanted {
            sample: item.asked.sample,
            fresh: false,
            batch: Some(self.batch.to_string()),
        };
        let store = Some(Arc::clone(&self.store));
        let mut unstored = None;
        let hear = |event| match event {
            Event::Barred(met) => *barrier = Some(met),
            Event::NotStored(words) => unstored = Some(words),
            _ => {}
        };
        match evaluation::run(&question, judge, store, &wanted, hear).await {
            Ok(_) if unstored.is_some() => Err(StoreError::Unstored(unstored.unwrap_or_default())),
            Ok(answer) => self.answered(&item, key.as_ref(), &answer),
            Err(AskError::Refused(why) | AskError::OverBudget(why)) => {
                self.ended(&item, key.as_ref(), ItemState::Waiting, why)
            }
            Err(AskError::Store(error)) => Err(error),
        }
    }

    /// Makes the question where it does not keep others waiting.
    async fn question(&self, item: &Item) -> Result<Arc<Question>, String> {
        let desk = Arc::clone(&self.desk);
        let asked = item.asked.clone();
        let made = tokio::task::spawn_blocking(move || {
            let entry = Entry::of_argument(Path::new(&asked.path));
            let way = way_of(&asked)?;
            desk.question(&entry, &way, &Variant::of(&asked)?, label_of(&asked))
        });
        let made = made.await;
        made.map_err(|error| format!("it could not be worked out: {error}"))?
    }

    fn answered(
        &self,
        item: &Item,
        key: Option<&Key>,
        answer: &Answer,
    ) -> Result<Ended, StoreError> {
        let (state, error) = match &answer.judged {
            Judged::Missing(Missing::Cancelled) => (ItemState::Waiting, None),
            Judged::Missing(missing @ (Missing::NoAnswer(_) | Missing::NotSent(_))) => {
                (ItemState::Failed, Some(missing.to_string()))
            }
            Judged::Missing(missing) if !answer.is_whole() => {
                (ItemState::Truncated, Some(missing.to_string()))
            }
            _ if !answer.is_whole() => {
                let why = "the server ended the answer before it was whole";
                let why = answer.cut_off().unwrap_or_else(|| why.to_string());
                (ItemState::Truncated, Some(why))
            }
            _ => (ItemState::Answered, None),
        };
        self.set(item, key, state, answer.run, error.as_deref())?;
        let stored = answer.past.is_some();
        Ok(Ended {
            place: item.place,
            state,
            error,
            stored,
            cost_usd: answer.consumed.cost_usd.filter(|_| !stored),
        })
    }

    fn ended(
        &self,
        item: &Item,
        key: Option<&Key>,
        state: ItemState,
        why: String,
    ) -> Result<Ended, StoreError> {
        self.set(item, key, state, None, Some(&why))?;
        Ok(Ended {
            place: item.place,
            state,
            error: Some(why),
            stored: false,
            cost_usd: None,
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
        self.store
            .set_item(self.batch, item.place, key, state, run, error)
    }
}

//! One question about many scenarios: what it would take, and asking it, a few at a time.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use futures_util::StreamExt;
use jiff::Zoned;
use tokio::sync::Semaphore;
use tokio::sync::mpsc::UnboundedSender;
use tokio::task::AbortHandle;

use super::Tasks;
use crate::evaluation::{self, Event, Judge, Question, Wanted};
use crate::scenario::{Entry, WantedEgo};
use crate::store::Store;
use crate::tui::message::Msg;
use crate::tui::message::runs::{Batch, BatchAsk, BatchId, BatchNews, Counts, Ended, Priced};

/// Batches that are asked or counted.
#[derive(Debug, Default)]
pub struct Batches {
    running: HashMap<BatchId, Running>,
    /// Raised whenever counting shall stop.
    counting: Arc<AtomicU64>,
    /// Places for requests, by provider: all batches share them.
    places: HashMap<String, Arc<Semaphore>>,
}

#[derive(Debug)]
struct Running {
    stop: Arc<AtomicBool>,
    task: AbortHandle,
}

/// What every question of a batch needs.
struct Asking {
    id: BatchId,
    name: String,
    batch: Arc<Batch>,
    judge: Judge,
    store: Option<Arc<Store>>,
    ego: WantedEgo,
    places: Arc<Semaphore>,
    stop: Arc<AtomicBool>,
    sender: UnboundedSender<Msg>,
}

impl Batches {
    /// Cancels everything; what was on its way is written down as cancelled.
    pub fn abort(&mut self) -> Vec<AbortHandle> {
        self.counting.fetch_add(1, Ordering::SeqCst);
        let handles = self.running.drain().map(|(_, running)| {
            running.stop.store(true, Ordering::SeqCst);
            running.task.abort();
            running.task
        });
        handles.collect()
    }
}

impl Tasks {
    /// Does what is wanted with a batch.
    pub(super) fn batch(&mut self, ask: BatchAsk) {
        match ask {
            BatchAsk::Count(id, batch) => self.count(id, batch),
            BatchAsk::StopCounting => {
                self.batches.counting.fetch_add(1, Ordering::SeqCst);
            }
            BatchAsk::Begin(id, batch) => self.begin(id, batch),
            BatchAsk::Stop(id) => {
                let running = self.batches.running.get(&id);
                // The first time it begins nothing more, the second time nothing goes on.
                if running.is_some_and(|r| r.stop.swap(true, Ordering::SeqCst))
                    && let Some(running) = self.batches.running.remove(&id)
                {
                    running.task.abort();
                    self.ending.push(running.task);
                    let _ = self.sender.send(Msg::Batch(BatchNews::Over(id)));
                }
            }
        }
    }

    fn count(&mut self, id: BatchId, batch: Arc<Batch>) {
        let asked = Arc::clone(&self.batches.counting);
        let mine = asked.fetch_add(1, Ordering::SeqCst) + 1;
        let judge = self.judge(&batch.model);
        let (store, ego, sender) = (self.store.clone(), self.ego.clone(), self.sender.clone());
        let mut counts = Counts {
            at_once: self.at_once(&batch.model),
            budget: self.budget.as_ref().map(crate::llm::Budget::left),
            price: Priced::Free,
            ..Counts::default()
        };
        tokio::spawn(async move {
            let tell = |counts: &Counts| {
                let news = BatchNews::Counted(id, counts.clone());
                let _ = sender.send(Msg::Batch(news));
            };
            let judge = match judge {
                Ok(judge) => judge,
                Err(why) => {
                    counts.refused = Some(why);
                    counts.looked = batch.entries.len();
                    return tell(&counts);
                }
            };
            // One at a time: what is being done on the screen comes first.
            for entry in &batch.entries {
                if asked.load(Ordering::SeqCst) != mine {
                    return;
                }
                let question = question(&batch, entry, &ego).await;
                let question = add(&mut counts, question, &judge, store.as_deref());
                // Whether one can be asked says it of all; a command that prints the key is run once.
                if let (Some(question), 1) = (&question, counts.asks) {
                    let ready = evaluation::can_ask(question, &judge).await;
                    counts.refused = ready.err().map(|why| why.to_string());
                }
                if let Some(question) = &question {
                    counts.price = price(counts.price, &batch, &judge, question);
                }
                counts.looked += 1;
                tell(&counts);
            }
        });
    }

    /// Requests of a batch at once.
    fn at_once(&self, model: &str) -> u32 {
        let own = self.judge(model).ok().and_then(|judge| match judge {
            Judge::Model(model) => model.endpoint.limits.concurrency,
            Judge::Reference => None,
        });
        let least = own.map_or(self.concurrency, |own| own.min(self.concurrency));
        least.get()
    }

    fn begin(&mut self, id: BatchId, batch: Arc<Batch>) {
        let judge = match self.judge(&batch.model) {
            Ok(judge) => judge,
            Err(why) => {
                let ended = BatchNews::Ended(id, Err(why));
                let _ = self.sender.send(Msg::Batch(ended));
                let _ = self.sender.send(Msg::Batch(BatchNews::Over(id)));
                return;
            }
        };
        let at_once = self.at_once(&batch.model) as usize;
        let provider = batch.model.split('/').next().unwrap_or_default();
        let places = self.batches.places.entry(provider.to_string());
        let places = places.or_insert_with(|| Arc::new(Semaphore::new(at_once)));
        let stop = Arc::new(AtomicBool::new(false));
        let asking = Asking {
            id,
            name: format!("{}-{}", Zoned::now().strftime("%Y-%m-%dT%H:%M:%S"), id.0),
            batch,
            judge,
            store: self.store.clone(),
            ego: self.ego.clone(),
            places: Arc::clone(places),
            stop: Arc::clone(&stop),
            sender: self.sender.clone(),
        };
        let task = tokio::spawn(async move { asking.all(at_once).await }).abort_handle();
        self.batches.running.retain(|_, r| !r.task.is_finished());
        self.batches.running.insert(id, Running { stop, task });
    }
}

impl Asking {
    fn tell(&self, news: BatchNews) {
        // The receiver is gone once the loop has ended.
        let _ = self.sender.send(Msg::Batch(news));
    }

    async fn all(&self, at_once: usize) {
        self.tell(BatchNews::Named(self.id, self.name.clone()));
        let places = 0..self.batch.entries.len();
        // Within the one task, so that aborting it drops every request.
        futures_util::stream::iter(places.map(|place| self.one(place)))
            .buffer_unordered(at_once)
            .for_each(|()| async {})
            .await;
        self.tell(BatchNews::Over(self.id));
    }

    async fn one(&self, place: usize) {
        // Nobody closes the semaphore.
        let _permit = self.places.acquire().await;
        if self.stop.load(Ordering::SeqCst) {
            return;
        }
        let ended = self.asked(&self.batch.entries[place]).await;
        self.tell(BatchNews::Ended(self.id, ended));
    }

    async fn asked(&self, entry: &Entry) -> Result<Ended, String> {
        let question = question(&self.batch, entry, &self.ego).await?;
        let wanted = Wanted {
            batch: Some(self.name.clone()),
            ..Wanted::default()
        };
        let mut unstored = None;
        let hear = |event| {
            if let Event::NotStored(words) = event {
                unstored = Some(words);
            }
        };
        let answer = evaluation::run(&question, &self.judge, self.store.clone(), &wanted, hear);
        let answer = answer.await.map_err(|e| e.to_string())?;
        if let Some(words) = unstored {
            // Others could not be stored either, and would be paid for.
            self.stop.store(true, Ordering::SeqCst);
            return Err(words);
        }
        let case = &question.case;
        let scenario = case.scene.scenario.hash.to_string();
        let about = (scenario, case.scene.ego.to_string(), case.task);
        let batch = Arc::clone(&self.batch);
        let truth = blocking(move || batch.plan.truth(&question)).await?;
        Ok(Ended {
            about: Some(about),
            answer: Box::new(answer),
            truth: truth.map(|verdict| verdict.dangerous),
        })
    }
}

/// Prepares a question where it does not keep others waiting.
async fn question(batch: &Arc<Batch>, entry: &Entry, ego: &WantedEgo) -> Result<Question, String> {
    let (batch, entry, ego) = (Arc::clone(batch), entry.clone(), ego.clone());
    let prepared = blocking(move || batch.plan.question(&entry, &ego)).await?;
    prepared.map_err(|e| e.to_string())
}

async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, String> {
    let done = tokio::task::spawn_blocking(work).await;
    done.map_err(|error| format!("it could not be worked out: {error}"))
}

/// Adds a question to the counts; gives it back if it would be asked.
fn add(
    counts: &mut Counts,
    question: Result<Question, String>,
    judge: &Judge,
    store: Option<&Store>,
) -> Option<Question> {
    let question = match question {
        Ok(question) => question,
        Err(why) => {
            counts.unaskable += 1;
            counts.why.get_or_insert(why);
            return None;
        }
    };
    let stored = store.map(|store| evaluation::stored(&question, judge, store, &Wanted::default()));
    match stored {
        Some(Ok(Some(_))) => {
            counts.stored += 1;
            return None;
        }
        Some(Err(error)) => counts.refused = Some(error.to_string()),
        Some(Ok(None)) | None => {}
    }
    counts.asks += 1;
    counts.tokens += question.tokens() as u64;
    Some(question)
}

/// Adds what one more question costs to what those before it do.
fn price(so_far: Priced, batch: &Batch, judge: &Judge, question: &Question) -> Priced {
    let Judge::Model(model) = judge else {
        return Priced::Free;
    };
    let name = batch.model.split_once('/').map_or("", |(_, name)| name);
    let Some(pricing) = model.endpoint.prices.of(name, Zoned::now().date()) else {
        return Priced::Unknown;
    };
    let tokens = u32::try_from(question.tokens()).unwrap_or(u32::MAX);
    let limit = model.endpoint.answer_limit(&model.parameters);
    // Long questions can have a price of their own, or none that is known.
    match (limit, pricing.at_most(tokens, 0), so_far) {
        (Some(limit), _, Priced::AtMost(usd)) => pricing
            .at_most(tokens, limit)
            .map_or(Priced::Unknown, |one| Priced::AtMost(usd + one)),
        (None, Some(one), Priced::Questions(usd, dearest)) => {
            match pricing.at_most(tokens, 1_000_000) {
                Some(both) => Priced::Questions(usd + one, dearest.max(both - one)),
                None => Priced::Unknown,
            }
        }
        (Some(limit), _, Priced::Free) => pricing
            .at_most(tokens, limit)
            .map_or(Priced::Unknown, Priced::AtMost),
        (None, Some(one), Priced::Free) => match pricing.at_most(tokens, 1_000_000) {
            Some(both) => Priced::Questions(one, both - one),
            None => Priced::Unknown,
        },
        _ => Priced::Unknown,
    }
}

//! Clients, and the jobs that run for them: commands of this program in threads of their own.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use serde_json::Value;

use super::aside::Aside;
use super::catalogue::Job;
use super::jobs::{self, JobEnd};
use super::lines::{RpcError, Wire};
use super::places::Places;
use super::server::{Server, failed};
use nearmiss_formats::Entry;

/// Jobs that run at once, of all clients.
const MOST_JOBS: usize = 4;

/// How commands say that they have paid nothing.
const UNSENT: &str = "nearmiss: nothing was sent: ";

/// A client from its `initialize` on.
#[derive(Debug)]
pub struct Session {
    /// Which one.
    pub number: u64,
    /// Whether `initialize` was answered.
    pub ready: AtomicBool,
}

impl Session {
    /// A client that has not said anything yet.
    pub fn new(number: u64) -> Self {
        Self {
            number,
            ready: AtomicBool::new(false),
        }
    }
}

/// A request that a job answers.
#[derive(Debug)]
pub struct Work {
    /// What it is about.
    pub entry: Entry,
    /// The obstacle that is its ego; else the one recorded beside it.
    pub ego: Option<i64>,
    /// Whether it needs one.
    pub needs_ego: bool,
    /// The command.
    pub job: &'static Job,
    /// Its arguments.
    pub words: Vec<String>,
    /// What its output becomes.
    pub becomes: fn(&Job, &[u8], &Places) -> Value,
    /// What it may cost, reserved of the budget.
    pub reserved: Option<f64>,
}

/// Requests by session and id, with the flag that ends them.
type Running = HashMap<(u64, String), Arc<AtomicBool>>;

/// All jobs of a server.
#[derive(Debug, Default)]
pub struct Jobs {
    running: Mutex<Running>,
    /// Requests that are answered without a command, and wait for files.
    calls: Mutex<Running>,
    threads: Mutex<Vec<JoinHandle<()>>>,
}

impl Jobs {
    fn running(&self) -> MutexGuard<'_, Running> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn calls(&self) -> MutexGuard<'_, Running> {
        self.calls.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends the job of a request, or takes the request back; one that is answered already needs no end.
    pub fn cancel(&self, session: u64, id: &Value) {
        let key = (session, id.to_string());
        for running in [self.running(), self.calls()] {
            if let Some(cancel) = running.get(&key) {
                cancel.store(true, Ordering::SeqCst);
            }
        }
    }

    /// Notes a request that is answered later, without a command.
    pub fn begin_call(&self, session: u64, id: &Value) -> Arc<AtomicBool> {
        let cancel = Arc::<AtomicBool>::default();
        let key = (session, id.to_string());
        self.calls().insert(key, Arc::clone(&cancel));
        cancel
    }

    /// Forgets it.
    pub fn end_call(&self, session: u64, id: &Value) {
        self.calls().remove(&(session, id.to_string()));
    }

    /// Whether a client has jobs that run.
    pub fn has(&self, session: u64) -> bool {
        self.running().keys().any(|(of, _)| *of == session)
    }

    /// Ends the jobs of a client, or of all, and takes back what waits for files.
    pub fn cancel_all(&self, session: Option<u64>) {
        for running in [self.running(), self.calls()] {
            let meant = running
                .iter()
                .filter(|((of, _), _)| session.is_none_or(|session| session == *of));
            meant.for_each(|(_, cancel)| cancel.store(true, Ordering::SeqCst));
        }
    }

    /// Does what takes long in a thread of its own.
    pub fn spawn(&self, work: impl FnOnce() + Send + 'static) {
        let mut threads = self.threads.lock().unwrap_or_else(PoisonError::into_inner);
        threads.retain(|thread| !thread.is_finished());
        threads.push(std::thread::spawn(work));
    }

    /// Waits until all jobs have ended.
    pub fn wait(&self) {
        let threads = self
            .threads
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .split_off(0);
        for thread in threads {
            let _ = thread.join();
        }
    }

    /// A place for a job; `Ok(Err)` says why the caller has to wait.
    ///
    /// # Errors
    /// The id is that of a request that is still running.
    pub fn place(
        &self,
        session: u64,
        id: &Value,
    ) -> Result<Result<Arc<AtomicBool>, String>, RpcError> {
        let key = (session, id.to_string());
        let mut running = self.running();
        if running.contains_key(&key) {
            return Err(RpcError::request("a request with this id is still running"));
        }
        if running.len() >= MOST_JOBS {
            return Ok(Err(format!(
                "{MOST_JOBS} jobs run already; wait for one or cancel it"
            )));
        }
        let cancel = Arc::new(AtomicBool::new(false));
        running.insert(key, Arc::clone(&cancel));
        Ok(Ok(cancel))
    }

    /// Gives a place back.
    pub fn leave(&self, session: u64, id: &Value) {
        self.running().remove(&(session, id.to_string()));
    }
}

/// Runs a job that has its place; its answer is sent when it ends.
pub fn launch(
    server: &Arc<Server>,
    (session, id): (u64, Value),
    wire: Wire,
    cancel: Arc<AtomicBool>,
    parameters: Value,
    work: Work,
) {
    let of = Arc::clone(server);
    server.jobs.spawn(move || {
        let answer = work.done(&of, &Aside::new(&cancel, &wire, &parameters));
        of.jobs.leave(session, &id);
        match answer {
            Some(Ok(result)) => wire.result(&id, &result),
            Some(Err(error)) => wire.error(&id, &error),
            // A cancelled request gets no answer.
            None => {}
        }
    });
}

impl Work {
    /// Does it; nothing if it was cancelled.
    pub fn done(&self, of: &Server, aside: &Aside<'_>) -> Option<Result<Value, RpcError>> {
        let seen = of.places.check(&self.entry, self.ego, self.needs_ego);
        let is_seen = seen.is_ok();
        let scenario = Places::argument(&self.entry);
        let end = match seen {
            Ok(()) => jobs::run(self.job, &scenario, &self.words, aside),
            Err(why) => JobEnd::Failed(why),
        };
        let purse = of.purse.as_ref().zip(self.reserved);
        match end {
            JobEnd::Done(given) => {
                if let Some((purse, usd)) = purse {
                    purse.settle(usd, &given);
                }
                Some(Ok((self.becomes)(self.job, &given, &of.places)))
            }
            JobEnd::Failed(why) => {
                if let Some((purse, usd)) = purse
                    && (!is_seen || why.starts_with(UNSENT))
                {
                    purse.put_back(usd);
                }
                let why = jobs::told(self.job, &of.places.told(&why));
                Some(if self.job.is_tool() {
                    Ok(failed(&why))
                } else {
                    Err(RpcError::parameters(why))
                })
            }
            JobEnd::Cancelled => None,
        }
    }
}

//! The server: reads requests, answers those that need files one after the other beside that, and jobs in threads of
//! their own.

use std::cell::Cell;
use std::io::BufRead;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use serde_json::{Value, json};
use tempfile::TempDir;

use super::aside::Aside;
use super::catalogue::{self, EGO, Gives, JOBS, Job, LOOKS, Look, SCENARIO};
use super::jobs;
use super::lines::{Line, RpcError, Wire, id_of, next};
use super::places::Places;
use super::prompts;
use super::purse::Purse;
use super::resources;
use super::session::{Jobs, Session, Work, launch};
use crate::interrupt::{end, interrupted};
use nearmiss_scene::metrics::Thresholds;

/// Versions of the protocol that are spoken, the newest first.
/// That of 2025-03-26 asks for batches, which no client sends and later versions have dropped.
pub const VERSIONS: [&str; 3] = ["2025-11-25", "2025-06-18", "2024-11-05"];

/// What waits for files, and answers then.
pub type Deferred = Box<dyn FnOnce() + Send>;

/// Requests over standard input that wait for one before them; more are not read meanwhile.
const WAITING: usize = 64;

/// How often an interrupt is looked for.
const WATCHED: Duration = Duration::from_millis(100);

/// A server.
#[derive(Debug)]
pub struct Server {
    /// What clients may see.
    pub places: Places,
    /// What moments are measured with.
    pub thresholds: Thresholds,
    /// What may be spent on models; `None` where none may be asked.
    pub purse: Option<Purse>,
    /// What runs.
    pub jobs: Jobs,
    /// Jobs that are soon done run one after the other.
    quick: Mutex<()>,
    /// The index of the scenarios, once a client searched it.
    pub index: Mutex<Option<TempDir>>,
}

impl Server {
    /// A server of these places.
    pub fn new(places: Places, thresholds: Thresholds, purse: Option<Purse>) -> Self {
        Self {
            places,
            thresholds,
            purse,
            jobs: Jobs::default(),
            quick: Mutex::default(),
            index: Mutex::default(),
        }
    }

    /// Serves one client until the input ends, or the program is interrupted; then jobs that still run are ended.
    pub fn serve(self, mut input: impl BufRead) {
        let server = Arc::new(self);
        let watched = Arc::clone(&server);
        let stop = interrupted(true);
        std::thread::spawn(move || {
            while !stop.load(Ordering::SeqCst) {
                std::thread::sleep(WATCHED);
            }
            watched.end();
            end();
        });
        let (session, wire) = (Session::new(0), Wire::stdout());
        // Scenarios are read there, so that a ping is answered and a request taken back meanwhile.
        let (defer, deferred) = sync_channel::<Deferred>(WAITING);
        let answering = std::thread::spawn(move || deferred.into_iter().for_each(|work| work()));
        while let Some(line) = next(&mut input) {
            let message = match line {
                Line::TooLong(id) => {
                    wire.error(&id, &RpcError::too_long());
                    continue;
                }
                Line::Message(bytes) => bytes,
            };
            if message.iter().all(u8::is_ascii_whitespace) {
                continue;
            }
            let Ok(message) = serde_json::from_slice::<Value>(&message) else {
                let id = id_of(&message, std::io::empty());
                wire.error(&id, &RpcError::parse("the message is no JSON"));
                continue;
            };
            // The other end goes on as long as this one is there, unless it has panicked.
            let has_ended = Cell::new(false);
            server.message(&message, &session, &wire, &|work| {
                has_ended.set(defer.send(work).is_err());
            });
            if has_ended.get() {
                break;
            }
        }
        drop(defer);
        if let Err(panic) = answering.join() {
            std::panic::resume_unwind(panic);
        }
        server.end();
    }

    /// Ends what runs, and waits for it.
    pub fn end(&self) {
        self.jobs.cancel_all(None);
        self.jobs.wait();
        let index = self.index.lock();
        drop(index.unwrap_or_else(PoisonError::into_inner).take());
    }

    /// Reads a message of a client and answers it: now, when its job ends, or when `defer` does what waits for files.
    pub fn message(
        self: &Arc<Self>,
        message: &Value,
        session: &Session,
        wire: &Wire,
        defer: &dyn Fn(Deferred),
    ) {
        let id = message.get("id").cloned();
        let method = message.get("method").and_then(Value::as_str);
        let proper = message.get("jsonrpc").and_then(Value::as_str) == Some("2.0");
        let (Some(method), true) = (method, proper) else {
            // An answer to a request that was never made needs none itself.
            if message.get("result").is_none() && message.get("error").is_none() {
                let id = id.filter(|id| id.is_string() || id.is_number());
                let error = RpcError::request("the message is no request of JSON-RPC 2.0");
                wire.error(&id.unwrap_or_default(), &error);
            }
            return;
        };
        let empty = json!({});
        let parameters = message.get("params").unwrap_or(&empty);
        let Some(id) = id else {
            if method == "notifications/cancelled" {
                self.jobs.cancel(session.number, &parameters["requestId"]);
            }
            return;
        };
        if !(id.is_string() || id.is_number()) {
            let error = RpcError::request("`id` is neither a string nor a number");
            return wire.error(&Value::Null, &error);
        }
        let ready = session.ready.load(Ordering::SeqCst);
        if !ready && !["initialize", "ping"].contains(&method) {
            let error = RpcError::request("the first request must be `initialize`");
            return wire.error(&id, &error);
        }
        let request = (session.number, id.clone());
        let answer = match method {
            "initialize" => {
                session.ready.store(true, Ordering::SeqCst);
                Ok(initialized(parameters))
            }
            "ping" => Ok(json!({})),
            "tools/list" => resources::no_cursor(parameters)
                .map(|()| json!({"tools": catalogue::tools(self.purse.is_some())})),
            "tools/call" => {
                let name = parameters["name"].as_str().unwrap_or_default();
                let look = LOOKS.iter().find(|look| look.name == name);
                match look {
                    Some(look) if look.takes_long => {
                        return self.apart(request, wire, parameters, look);
                    }
                    Some(look) => {
                        let look = |server: &Self, parameters: &Value, aside: &Aside<'_>| {
                            Ok(server.look(look, &parameters["arguments"], aside))
                        };
                        return self.later(request, wire, parameters, defer, look);
                    }
                    None => {}
                }
                let is_offered = |job: &&Job| self.purse.is_some() || !job.paid;
                let mut jobs = JOBS.iter().filter(is_offered);
                let job = jobs.find(|job| job.name == name);
                match job {
                    // Several at once wait for each other.
                    Some(job) if job.gives != Gives::Json => {
                        let done = |server: &Self, parameters: &Value, aside: &Aside<'_>| {
                            server.done(job, parameters, aside)
                        };
                        return self.later(request, wire, parameters, defer, done);
                    }
                    Some(job) => {
                        let work = |server: &Self, parameters: &Value| server.work(job, parameters);
                        return self.start(request, wire, parameters, defer, work);
                    }
                    None => {}
                }
                let name: String = name.chars().take(80).collect();
                Err(RpcError::parameters(format!(
                    "no tool `{name}`; tools/list has all"
                )))
            }
            "resources/list" => {
                return self.later(request, wire, parameters, defer, |server, parameters, _| {
                    resources::list(&server.places, parameters)
                });
            }
            "resources/templates/list" => {
                resources::no_cursor(parameters).map(|()| json!({"resourceTemplates": []}))
            }
            "resources/read" => {
                return self.later(request, wire, parameters, defer, |server, parameters, _| {
                    resources::read(&server.places, parameters)
                });
            }
            "prompts/list" => {
                resources::no_cursor(parameters).map(|()| json!({"prompts": prompts::list()}))
            }
            "prompts/get" => {
                return self.start(request, wire, parameters, defer, |server, parameters| {
                    prompts::work(&server.places, parameters).map_err(Refused::Error)
                });
            }
            other => Err(RpcError::method(other)),
        };
        match answer {
            Ok(result) => wire.result(&id, &result),
            Err(error) => wire.error(&id, &error),
        }
    }

    /// Answers a request when `defer` does it, unless it was taken back by then.
    fn later(
        self: &Arc<Self>,
        (session, id): (u64, Value),
        wire: &Wire,
        parameters: &Value,
        defer: &dyn Fn(Deferred),
        answer: impl FnOnce(&Self, &Value, &Aside<'_>) -> Result<Value, RpcError> + Send + 'static,
    ) {
        let cancel = self.jobs.begin_call(session, &id);
        let (server, wire, parameters) = (Arc::clone(self), wire.clone(), parameters.clone());
        defer(Box::new(move || {
            let aside = Aside::new(&cancel, &wire, &parameters);
            let answer = (!aside.is_cancelled()).then(|| answer(&server, &parameters, &aside));
            server.jobs.end_call(session, &id);
            match answer.filter(|_| !aside.is_cancelled()) {
                Some(Ok(result)) => wire.result(&id, &result),
                Some(Err(error)) => wire.error(&id, &error),
                None => {}
            }
        }));
    }

    /// The result of a look. Mistakes of the caller are results, too, so that a model reads them.
    fn look(&self, look: &Look, arguments: &Value, aside: &Aside<'_>) -> Value {
        let checked = jobs::words(look.options, arguments);
        match checked.and_then(|_| (look.call)(self, arguments, aside)) {
            Ok(value) => {
                let text = self.places.told(&value.to_string());
                json!({
                    "structuredContent": serde_json::from_str::<Value>(&text).unwrap_or(value),
                    "content": [{"type": "text", "text": text}],
                    "isError": false,
                })
            }
            Err(why) => failed(&self.places.told(&why)),
        }
    }

    /// Answers a look that takes long in a thread of its own.
    fn apart(
        self: &Arc<Self>,
        (session, id): (u64, Value),
        wire: &Wire,
        parameters: &Value,
        look: &'static Look,
    ) {
        let Some(cancel) = self.place(session, &id, wire) else {
            return;
        };
        let (server, wire, parameters) = (Arc::clone(self), wire.clone(), parameters.clone());
        self.jobs.spawn(move || {
            let aside = Aside::new(&cancel, &wire, &parameters);
            let result = server.look(look, &parameters["arguments"], &aside);
            server.jobs.leave(session, &id);
            if !aside.is_cancelled() {
                wire.result(&id, &result);
            }
        });
    }

    /// The place of a request that takes long; where there is none, that is answered.
    fn place(&self, session: u64, id: &Value, wire: &Wire) -> Option<Arc<AtomicBool>> {
        match self.jobs.place(session, id) {
            Ok(Ok(cancel)) => return Some(cancel),
            Ok(Err(why)) => wire.result(id, &failed(&why)),
            Err(error) => wire.error(id, &error),
        }
        None
    }

    /// The result of a job that is soon done.
    fn done(
        &self,
        job: &'static Job,
        parameters: &Value,
        aside: &Aside<'_>,
    ) -> Result<Value, RpcError> {
        let _one = self.quick.lock().unwrap_or_else(PoisonError::into_inner);
        match self.work(job, parameters) {
            Ok(work) => work.done(self, aside).unwrap_or(Ok(Value::Null)),
            Err(Refused::Result(why)) => Ok(failed(&why)),
            Err(Refused::Error(error)) => Err(error),
        }
    }

    /// Starts a job when `defer` does it; its answer is sent when it ends.
    fn start(
        self: &Arc<Self>,
        (session, id): (u64, Value),
        wire: &Wire,
        parameters: &Value,
        defer: &dyn Fn(Deferred),
        work: impl FnOnce(&Self, &Value) -> Result<Work, Refused> + Send + 'static,
    ) {
        let Some(cancel) = self.place(session, &id, wire) else {
            return;
        };
        let (server, wire, parameters) = (Arc::clone(self), wire.clone(), parameters.clone());
        defer(Box::new(move || match work(&server, &parameters) {
            Ok(work) => launch(&server, (session, id), wire, cancel, parameters, work),
            Err(refused) => {
                server.jobs.leave(session, &id);
                match refused {
                    Refused::Result(why) => wire.result(&id, &failed(&why)),
                    Refused::Error(error) => wire.error(&id, &error),
                }
            }
        }));
    }

    /// The work of a job that is called as a tool, with what it may cost taken out of the budget.
    fn work(&self, job: &'static Job, parameters: &Value) -> Result<Work, Refused> {
        let arguments = &parameters["arguments"];
        let mut words = jobs::words(job.options, arguments).map_err(Refused::Result)?;
        let scenario = arguments[SCENARIO.name].as_str().unwrap_or_default();
        let entry = self.places.entry(scenario).map_err(Refused::Result)?;
        let purse = self.purse.as_ref().filter(|_| job.paid);
        let reserved = purse
            .map(|purse| purse.reserve(arguments))
            .transpose()
            .map_err(Refused::Result)?;
        if let Some(usd) = reserved.filter(|_| arguments["budget"].is_null()) {
            words.push(format!("--budget={usd}"));
        }
        Ok(Work {
            entry,
            ego: arguments[EGO.name].as_i64(),
            needs_ego: job.needs_ego,
            job,
            words,
            becomes: jobs::result,
            reserved,
        })
    }
}

/// Why a job is not started: told to the model, or to its client.
enum Refused {
    Result(String),
    Error(RpcError),
}

/// A result that says what went wrong.
pub fn failed(why: &str) -> Value {
    json!({"content": [{"type": "text", "text": why}], "isError": true})
}

fn initialized(parameters: &Value) -> Value {
    let wanted = parameters["protocolVersion"].as_str().unwrap_or_default();
    let version = VERSIONS.into_iter().find(|version| *version == wanted);
    json!({
        "protocolVersion": version.unwrap_or(VERSIONS[0]),
        "capabilities": {"tools": {}, "resources": {}, "prompts": {}},
        "serverInfo": {"name": "nearmiss", "version": env!("CARGO_PKG_VERSION")},
        "instructions": "Traffic scenarios, measured exactly. list_scenarios ranks them by danger; inspect says what is in \
                         one and when it is most severe; describe gives the table of a window, render its picture; find \
                         searches the windows of all. `at` is a time step; ids are those of obstacles.",
    })
}

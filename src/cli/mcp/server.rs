//! The server: reads requests, answers those that need files one after the other beside that, and jobs in threads of
//! their own.

use std::cell::Cell;
use std::io::BufRead;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::sync_channel;
use std::time::Duration;

use serde_json::{Value, json};

use super::catalogue::{self, JOBS, Job, PLACE, is_offered};
use super::jobs;
use super::lines::{LONGEST, Line, RpcError, Wire, next};
use super::places::Places;
use super::prompts;
use super::purse::Purse;
use super::resources;
use super::session::{Jobs, Session, Work, launch};
use crate::cli::interrupt::{end, interrupted};
use crate::metrics::Thresholds;
use crate::scenario::Window;
use crate::tools::{Arguments, TOOLS, Tool, WindowView};

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
    thresholds: Thresholds,
    oracles: bool,
    /// What may be spent on models; `None` where none may be asked.
    pub purse: Option<Purse>,
    /// What runs.
    pub jobs: Jobs,
}

impl Server {
    /// A server of these places.
    pub fn new(
        places: Places,
        thresholds: Thresholds,
        oracles: bool,
        purse: Option<Purse>,
    ) -> Self {
        Self {
            places,
            thresholds,
            oracles,
            purse,
            jobs: Jobs::default(),
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
            watched.jobs.cancel_all(None);
            watched.jobs.wait();
            end();
        });
        let (session, wire) = (Session::new(0), Wire::stdout());
        // Scenarios are read there, so that a ping is answered and a request taken back meanwhile.
        let (defer, deferred) = sync_channel::<Deferred>(WAITING);
        let answering = std::thread::spawn(move || deferred.into_iter().for_each(|work| work()));
        while let Some(line) = next(&mut input) {
            let message = match line {
                Line::TooLong => {
                    let why = format!("the message has more than {LONGEST} bytes");
                    wire.error(&Value::Null, &RpcError::request(why));
                    continue;
                }
                Line::Message(bytes) => bytes,
            };
            if message.iter().all(u8::is_ascii_whitespace) {
                continue;
            }
            let Ok(message) = serde_json::from_slice::<Value>(&message) else {
                let error = RpcError::parse("the message is no JSON");
                wire.error(&Value::Null, &error);
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
        server.jobs.cancel_all(None);
        server.jobs.wait();
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
                .map(|()| json!({"tools": catalogue::tools(self.oracles, self.purse.is_some())})),
            "tools/call" => {
                let name = parameters["name"].as_str().unwrap_or_default();
                let job = JOBS
                    .iter()
                    .find(|job| job.name == name && (self.purse.is_some() || !job.paid));
                if let Some(job) = job {
                    let work = |server: &Self, parameters: &Value| server.work(job, parameters);
                    return self.start(request, wire, parameters, defer, work);
                }
                return self.later(request, wire, parameters, defer, |server, parameters| {
                    let name = parameters["name"].as_str().unwrap_or_default();
                    server.call(name, &parameters["arguments"])
                });
            }
            "resources/list" => {
                return self.later(request, wire, parameters, defer, |server, parameters| {
                    resources::list(&server.places, parameters)
                });
            }
            "resources/templates/list" => {
                resources::no_cursor(parameters).map(|()| json!({"resourceTemplates": []}))
            }
            "resources/read" => {
                return self.later(request, wire, parameters, defer, |server, parameters| {
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
        answer: impl FnOnce(&Self, &Value) -> Result<Value, RpcError> + Send + 'static,
    ) {
        let cancel = self.jobs.begin_call(session, &id);
        let (server, wire, parameters) = (Arc::clone(self), wire.clone(), parameters.clone());
        defer(Box::new(move || {
            let is_cancelled = || cancel.load(Ordering::SeqCst);
            let answer = (!is_cancelled()).then(|| answer(&server, &parameters));
            server.jobs.end_call(session, &id);
            match answer.filter(|_| !is_cancelled()) {
                Some(Ok(result)) => wire.result(&id, &result),
                Some(Err(error)) => wire.error(&id, &error),
                None => {}
            }
        }));
    }

    /// A call of a tool of the table. Mistakes of the caller are results, so that a model reads them.
    fn call(&self, name: &str, arguments: &Value) -> Result<Value, RpcError> {
        let mut offered = TOOLS.iter().filter(|tool| is_offered(tool, self.oracles));
        let Some(tool) = offered.find(|tool| tool.name == name) else {
            let name: String = name.chars().take(80).collect();
            return Err(RpcError::parameters(format!(
                "no tool `{name}`; tools/list has all"
            )));
        };
        Ok(match self.computed(tool, arguments) {
            Ok(value) => json!({
                "content": [{"type": "text", "text": value.to_string()}],
                "structuredContent": value,
                "isError": false,
            }),
            Err(why) => failed(&why),
        })
    }

    fn computed(&self, tool: &Tool, arguments: &Value) -> Result<Value, String> {
        let mut own = match arguments {
            Value::Object(map) => map.clone(),
            Value::Null => serde_json::Map::new(),
            _ => return Err("the arguments are no JSON object".into()),
        };
        let places = PLACE.iter().map(|(name, ..)| *name);
        let known = places.chain(tool.arguments.iter().map(|argument| argument.name));
        if let Some(name) = own.keys().find(|name| !known.clone().any(|k| k == *name)) {
            let name: String = name.chars().take(64).collect();
            return Err(crate::system::unknown("argument", &name, known));
        }
        let scenario = catalogue::scenario(arguments)?;
        let [_, at, history, ego] = PLACE.map(|(name, ..)| own.remove(name));
        let whole = |name: &str, value: Option<Value>| match value {
            None | Some(Value::Null) => Ok(None),
            Some(value) => match value.as_i64() {
                Some(number) => Ok(Some(number)),
                None => Err(format!("argument `{name}` is no whole number")),
            },
        };
        let (at, history) = (whole("at", at)?, whole("history", history)?);
        let scene = self.places.scene(scenario, whole("ego", ego)?)?;
        let last = at.unwrap_or_else(|| scene.last_step());
        if !scene.steps().contains(&last) {
            let steps = scene.steps();
            return Err(format!(
                "argument `at` is {last}; the ego is recorded from step {} to {}",
                steps.start,
                steps.end - 1
            ));
        }
        let history = history.unwrap_or(10);
        if !(1..=10_000).contains(&history) {
            return Err(format!(
                "argument `history` is {history}; 1 to 10000 steps are possible"
            ));
        }
        let history = history as usize;
        let window = Window::ending_at(&scene, last, history);
        let view = WindowView::new(&scene, &self.thresholds, window);
        let arguments = Arguments::of(Value::Object(own), tool.arguments);
        let arguments = arguments.map_err(|why| why.to_string())?;
        (tool.call)(&view, &arguments).map_err(|why| why.to_string())
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
        let cancel = match self.jobs.place(session, &id) {
            Ok(Ok(cancel)) => cancel,
            Ok(Err(why)) => return wire.result(&id, &failed(&why)),
            Err(error) => return wire.error(&id, &error),
        };
        let (server, wire, parameters) = (Arc::clone(self), wire.clone(), parameters.clone());
        defer(Box::new(move || match work(&server, &parameters) {
            Ok(mut work) => {
                let token = parameters.pointer("/_meta/progressToken").cloned();
                work.token =
                    token.filter(|token| token.is_string() || token.is_i64() || token.is_u64());
                launch(&server, (session, id), wire, cancel, work);
            }
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
        let entry = catalogue::scenario(arguments).and_then(|name| self.places.entry(name));
        let entry = entry.map_err(Refused::Result)?;
        let words = jobs::arguments(job, &Places::argument(&entry), arguments);
        let mut words = words.map_err(Refused::Result)?;
        let purse = self.purse.as_ref().filter(|_| job.paid);
        let reserved = purse.map(|purse| purse.reserve(arguments)).transpose();
        let reserved = reserved.map_err(Refused::Result)?;
        if let Some(usd) = reserved.filter(|_| arguments["budget"].is_null()) {
            words.push(format!("--budget={usd}"));
        }
        Ok(Work {
            entry,
            recorded_ego: job.needs_recorded_ego(arguments),
            job,
            words,
            becomes: jobs::result,
            reserved,
            token: None,
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
        "instructions": "Exact safety measures of recorded traffic scenes. Times are seconds relative to the end of the \
                         window, which `at` chooses; ids are those of list_obstacles, 0 is the ego.",
    })
}

//! The server: reads requests, answers those about numbers at once, and jobs in threads of their own.

use std::collections::HashMap;
use std::io::BufRead;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use serde_json::{Value, json};

use super::catalogue::{self, JOBS, Job, PLACE, is_offered};
use super::jobs::{self, JobEnd};
use super::lines::{LONGEST, Line, RpcError, Wire, next};
use super::places::Places;
use super::prompts;
use super::purse::Purse;
use crate::formats::Entry;
use crate::metrics::Thresholds;
use crate::scenario::Window;
use crate::tools::{Arguments, TOOLS, Tool, WindowView};

/// Versions of the protocol that are spoken, the newest first.
/// That of 2025-03-26 asks for batches, which no client sends and later versions have dropped.
const VERSIONS: [&str; 3] = ["2025-11-25", "2025-06-18", "2024-11-05"];

/// Resources of one page.
const PAGE: usize = 200;

/// Jobs that run at once.
const MOST_JOBS: usize = 4;

/// How the addresses of scenarios begin.
const SCHEME: &str = "nearmiss://scenario/";

/// Largest scenario that is given as a resource, bytes.
const LONGEST_SCENARIO: usize = 8 << 20;

/// A server for one client.
pub struct Server {
    places: Places,
    thresholds: Thresholds,
    oracles: bool,
    /// What may be spent on models; `None` where none may be asked.
    purse: Option<Purse>,
    wire: Wire,
    /// Jobs that run, by the id of their request, with the flag that ends them.
    running: Mutex<HashMap<String, Arc<AtomicBool>>>,
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
            wire: Wire::default(),
            running: Mutex::default(),
        }
    }

    /// Serves until the input ends; then jobs that still run are ended.
    pub fn serve(self, mut input: impl BufRead) {
        let server = &self;
        std::thread::scope(|scope| {
            let mut ready = false;
            while let Some(line) = next(&mut input) {
                let message = match line {
                    Line::TooLong => {
                        let why = format!("the message has more than {LONGEST} bytes");
                        server.wire.error(&Value::Null, &RpcError::request(why));
                        continue;
                    }
                    Line::Message(bytes) => bytes,
                };
                if message.iter().all(u8::is_ascii_whitespace) {
                    continue;
                }
                let Ok(message) = serde_json::from_slice::<Value>(&message) else {
                    let error = RpcError::parse("the message is no JSON");
                    server.wire.error(&Value::Null, &error);
                    continue;
                };
                server.message(&message, &mut ready, scope);
            }
            for cancel in server.jobs().values() {
                cancel.store(true, Ordering::SeqCst);
            }
        });
    }

    fn jobs(&self) -> std::sync::MutexGuard<'_, HashMap<String, Arc<AtomicBool>>> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn message<'s>(
        &'s self,
        message: &Value,
        ready: &mut bool,
        scope: &'s std::thread::Scope<'s, '_>,
    ) {
        let id = message.get("id").cloned();
        let method = message.get("method").and_then(Value::as_str);
        let proper = message.get("jsonrpc").and_then(Value::as_str) == Some("2.0");
        let (Some(method), true) = (method, proper) else {
            // An answer to a request that was never made needs none itself.
            if message.get("result").is_none() && message.get("error").is_none() {
                let id = id.filter(|id| id.is_string() || id.is_number());
                let error = RpcError::request("the message is no request of JSON-RPC 2.0");
                self.wire.error(&id.unwrap_or_default(), &error);
            }
            return;
        };
        let empty = json!({});
        let parameters = message.get("params").unwrap_or(&empty);
        let Some(id) = id else {
            if method == "notifications/cancelled" {
                let key = parameters["requestId"].to_string();
                if let Some(cancel) = self.jobs().get(&key) {
                    cancel.store(true, Ordering::SeqCst);
                }
            }
            return;
        };
        if !(id.is_string() || id.is_number()) {
            let error = RpcError::request("`id` is neither a string nor a number");
            return self.wire.error(&Value::Null, &error);
        }
        if !*ready && !["initialize", "ping"].contains(&method) {
            let error = RpcError::request("the first request must be `initialize`");
            return self.wire.error(&id, &error);
        }
        let answer = match method {
            "initialize" => {
                *ready = true;
                Ok(initialized(parameters))
            }
            "ping" => Ok(json!({})),
            "tools/list" => {
                Ok(json!({"tools": catalogue::tools(self.oracles, self.purse.is_some())}))
            }
            "tools/call" => {
                let name = parameters["name"].as_str().unwrap_or_default();
                let job = JOBS
                    .iter()
                    .find(|job| job.name == name && (self.purse.is_some() || !job.paid));
                match job {
                    Some(job) => return self.start(job, id, parameters.clone(), scope),
                    None => self.call(name, &parameters["arguments"]),
                }
            }
            "resources/list" => Ok(self.resources(parameters)),
            "resources/templates/list" => Ok(json!({"resourceTemplates": []})),
            "resources/read" => self.resource(parameters),
            "prompts/list" => Ok(json!({"prompts": prompts::list()})),
            "prompts/get" => prompts::get(&self.places, parameters),
            other => Err(RpcError::method(other)),
        };
        match answer {
            Ok(result) => self.wire.result(&id, &result),
            Err(error) => self.wire.error(&id, &error),
        }
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
        let [scenario, at, history] = PLACE.map(|(name, ..)| own.remove(name));
        let scenario = scenario.as_ref().and_then(Value::as_str);
        let scenario =
            scenario.ok_or("argument `scenario` is missing: the path or name of a scenario")?;
        let whole = |name: &str, value: Option<Value>| match value {
            None | Some(Value::Null) => Ok(None),
            Some(value) => match value.as_i64() {
                Some(number) => Ok(Some(number)),
                None => Err(format!("argument `{name}` is no whole number")),
            },
        };
        let (at, history) = (whole("at", at)?, whole("history", history)?);
        let scene = self.places.scene(scenario)?;
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

    /// Starts a job; its answer is sent when it ends.
    fn start<'s>(
        &'s self,
        job: &'static Job,
        id: Value,
        parameters: Value,
        scope: &'s std::thread::Scope<'s, '_>,
    ) {
        let arguments = &parameters["arguments"];
        let entry = match arguments["scenario"].as_str() {
            Some(name) => self.places.entry(name),
            None => Err("argument `scenario` is missing: the path or name of a scenario".into()),
        };
        let words =
            entry.and_then(|entry| jobs::arguments(job, &Places::argument(&entry), arguments));
        let mut words = match words {
            Ok(words) => words,
            Err(why) => return self.wire.result(&id, &failed(&why)),
        };
        let cancel = Arc::new(AtomicBool::new(false));
        let key = id.to_string();
        let mut running = self.jobs();
        if running.contains_key(&key) {
            drop(running);
            let error = RpcError::request("a request with this id is still running");
            return self.wire.error(&id, &error);
        }
        if running.len() >= MOST_JOBS {
            drop(running);
            let why = format!("{MOST_JOBS} jobs run already; wait for one or cancel it");
            return self.wire.result(&id, &failed(&why));
        }
        let purse = self.purse.as_ref().filter(|_| job.paid);
        let reserved = match purse.map(|purse| purse.reserve(arguments)).transpose() {
            Ok(reserved) => reserved,
            Err(why) => {
                drop(running);
                return self.wire.result(&id, &failed(&why));
            }
        };
        if let Some(usd) = reserved.filter(|_| arguments["budget"].is_null()) {
            words.push(format!("--budget={usd}"));
        }
        running.insert(key.clone(), Arc::clone(&cancel));
        drop(running);
        let token = parameters.pointer("/_meta/progressToken").cloned();
        scope.spawn(move || {
            let end = jobs::run(job, words, &cancel, |seconds| {
                if let Some(token) = &token {
                    self.wire.send(&json!({
                        "jsonrpc": "2.0", "method": "notifications/progress",
                        "params": {
                            "progressToken": token, "progress": seconds,
                            "message": format!("{} runs for {seconds} s", job.name),
                        },
                    }));
                }
            });
            self.jobs().remove(&key);
            match end {
                JobEnd::Done(text) => {
                    if let (Some(purse), Some(usd)) = (purse, reserved) {
                        purse.settle(usd, &text);
                    }
                    let text = self.places.told(&text);
                    self.wire.result(&id, &jobs::result(job, &text));
                }
                JobEnd::Failed(why) => self.wire.result(&id, &failed(&self.places.told(&why))),
                // A cancelled request gets no answer.
                JobEnd::Cancelled => {}
            }
        });
    }

    fn address(&self, entry: &Entry) -> String {
        let name = self.places.name(entry);
        let escaped = name.bytes().map(|byte| match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' | b'/' | b'#' => {
                char::from(byte).to_string()
            }
            other => format!("%{other:02X}"),
        });
        format!(
            "{SCHEME}{}",
            escaped.collect::<String>().replace('#', "%23")
        )
    }

    fn resources(&self, parameters: &Value) -> Value {
        let from = parameters["cursor"]
            .as_str()
            .and_then(|cursor| cursor.parse().ok());
        let from: usize = from.unwrap_or(0);
        let entries = self.places.entries();
        let page = entries.iter().skip(from).take(PAGE);
        let resources: Vec<Value> = page
            .map(|entry| {
                json!({
                    "uri": self.address(entry),
                    "name": self.places.name(entry),
                    "mimeType": "application/xml",
                })
            })
            .collect();
        let mut list = json!({"resources": resources});
        if from + PAGE < entries.len() {
            list["nextCursor"] = (from + PAGE).to_string().into();
        }
        list
    }

    fn resource(&self, parameters: &Value) -> Result<Value, RpcError> {
        let uri = parameters["uri"].as_str().unwrap_or_default();
        let unknown = |why: String| RpcError {
            code: -32002,
            message: why,
        };
        let entries = self.places.entries();
        let entry = entries.iter().find(|entry| self.address(entry) == uri);
        let Some(entry) = entry else {
            return Err(unknown("no such resource; resources/list has all".into()));
        };
        let text = entry
            .source()
            .map_err(|why| unknown(self.places.told(&why)))?;
        if text.len() > LONGEST_SCENARIO {
            return Err(unknown(format!(
                "the scenario has {} bytes, more than {LONGEST_SCENARIO}; ask tools about it",
                text.len()
            )));
        }
        let contents = json!({"uri": uri, "mimeType": "application/xml", "text": text});
        Ok(json!({"contents": [contents]}))
    }
}

fn failed(why: &str) -> Value {
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

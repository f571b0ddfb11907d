//! A provider on loopback that keeps files and batches, and speaks the batch APIs of OpenAI, Anthropic and Gemini.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard};

use serde_json::{Value, json};
use tokio::io::AsyncWriteExt;
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinHandle;

use super::server::{Recorded, read_request};

/// What becomes of one question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    Answered,
    Errored,
    Cancelled,
    Expired,
    /// There is no line about it.
    Forgotten,
}

/// What becomes of the creation of a batch, which is carried out in any case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Creation {
    #[default]
    Answered,
    /// The connection closes without a word.
    Lost,
    /// Nothing is ever said.
    Stalled,
}

#[derive(Clone, Debug)]
pub struct Batch {
    pub id: String,
    pub tag: String,
    pub method: String,
    /// Ids of questions and their bodies.
    pub items: Vec<(String, Value)>,
    created: jiff::Timestamp,
}

/// What the provider has, and how it behaves.
#[derive(Default)]
pub struct World {
    pub batches: Vec<Batch>,
    pub requests: Vec<Recorded>,
    files: BTreeMap<String, String>,
    /// How questions end, by their place in the batch; those beyond are answered.
    pub fates: Vec<Fate>,
    /// The provider's word for where all batches stand, in OpenAI's words; empty is `completed`.
    pub state: String,
    /// Numbers of requests, from 0, that are refused with 429.
    pub busy: BTreeSet<usize>,
    pub creation: Creation,
    /// Results break off after so many lines; with the length that the whole would have, or without any length.
    pub cut: Option<(usize, bool)>,
    /// Gemini names a file of results instead of giving them.
    pub in_a_file: bool,
    /// Words in errors and answers.
    pub words: String,
    /// Results were deleted.
    pub without_results: bool,
    /// All requests are refused with this status, and the words.
    pub refuse: Option<u16>,
    /// Models read no more tokens of a question.
    pub context: Option<usize>,
}

/// A running provider; it stops when dropped.
pub struct Provider {
    base_url: String,
    world: Arc<Mutex<World>>,
    task: JoinHandle<()>,
}

impl Provider {
    pub async fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let base_url = format!("http://{}", listener.local_addr().unwrap());
        let world = Arc::new(Mutex::new(World::default()));
        let shared = Arc::clone(&world);
        let task = tokio::spawn(async move {
            let mut connections = tokio::task::JoinSet::new();
            loop {
                let (stream, _) = listener.accept().await.unwrap();
                connections.spawn(serve(stream, Arc::clone(&shared)));
            }
        });
        Self {
            base_url,
            world,
            task,
        }
    }

    pub fn base_url(&self) -> &str {
        &self.base_url
    }

    pub fn world(&self) -> MutexGuard<'_, World> {
        self.world.lock().unwrap()
    }
}

impl Drop for Provider {
    fn drop(&mut self) {
        self.task.abort();
    }
}

async fn serve(mut stream: TcpStream, world: Arc<Mutex<World>>) {
    let Some(request) = read_request(&mut stream).await else {
        return;
    };
    let (answer, creation) = {
        let mut world = world.lock().unwrap();
        let creates = creates(&request);
        let answer = world.answer(request);
        (answer, creates.then_some(world.creation))
    };
    match creation {
        Some(Creation::Lost) => {}
        Some(Creation::Stalled) => std::future::pending().await,
        _ => drop(stream.write_all(&answer).await),
    }
}

fn creates(request: &Recorded) -> bool {
    let path = request.path.split('?').next().unwrap();
    request.method == "POST"
        && (path.ends_with("/batches") || path.ends_with(":batchGenerateContent"))
}

fn reply(status: u16, body: &str) -> Vec<u8> {
    let wait = match status {
        429 => "Retry-After: 0.01\r\n",
        _ => "",
    };
    format!(
        "HTTP/1.1 {status} X\r\nContent-Type: application/json\r\n{wait}Content-Length: {}\r\nConnection: close\r\n\r\n{body}",
        body.len()
    )
    .into_bytes()
}

impl World {
    fn answer(&mut self, request: Recorded) -> Vec<u8> {
        let number = self.requests.len();
        self.requests.push(request.clone());
        let path = request.path.split('?').next().unwrap().to_string();
        if self.busy.contains(&number) {
            return reply(
                429,
                r#"{"error":{"message":"slow down","type":"rate_limit"}}"#,
            );
        }
        if let Some(status) = self.refuse {
            let body = json!({"error": {"message": self.words, "type": "refused"}});
            return reply(status, &body.to_string());
        }
        let results = ["/content", "/results"];
        if self.without_results && results.iter().any(|end| path.ends_with(end)) {
            return reply(404, r#"{"error":{"message":"deleted"}}"#);
        }
        let parts: Vec<&str> = path.trim_matches('/').split('/').collect();
        let body = match (request.method.as_str(), &parts[..]) {
            ("POST", ["v1", "files"]) => self.upload(&request),
            ("GET", ["v1", "files", file, "content"]) => {
                let lines = self.openai_file(file);
                return self.lines(&lines);
            }
            ("POST", ["v1", "batches"]) => self.create_openai(&request.json()),
            ("GET", ["v1", "batches"]) => self.list(Self::openai),
            ("GET", ["v1", "batches", id]) => self.one(id, Self::openai),
            ("POST", ["v1", "batches", id, "cancel"]) => self.cancel(id, Self::openai),
            ("POST", ["v1", "messages", "batches"]) => self.create_anthropic(&request.json()),
            ("GET", ["v1", "messages", "batches"]) => self.list(Self::anthropic),
            ("GET", ["v1", "messages", "batches", id]) => self.one(id, Self::anthropic),
            ("GET", ["v1", "messages", "batches", id, "results"]) => {
                let batch = self.batch(id);
                let lines = self.results(&batch, Self::anthropic_line);
                return self.lines(&lines);
            }
            ("POST", ["v1", "messages", "batches", id, "cancel"]) => {
                self.cancel(id, Self::anthropic)
            }
            ("POST", ["v1beta", "models", method]) if method.ends_with(":batchGenerateContent") => {
                self.create_gemini(&request.json())
            }
            ("GET", ["download", "v1beta", "files", file]) => {
                assert!(
                    request.path.ends_with(":download?alt=media"),
                    "{}",
                    request.path
                );
                let id = file.trim_end_matches(":download");
                let batch = self.batch(&format!("batches/{id}"));
                let lines = self.results(&batch, Self::gemini_file_line);
                return self.lines(&lines);
            }
            ("GET", ["v1beta", "batches"]) => {
                let operations: Vec<Value> =
                    self.batches.iter().rev().map(|b| self.gemini(b)).collect();
                json!({"operations": operations})
            }
            ("GET", ["v1beta", "batches", id]) => self.one(&format!("batches/{id}"), Self::gemini),
            ("POST", ["v1beta", "batches", id]) if id.ends_with(":cancel") => {
                let id = id.trim_end_matches(":cancel");
                self.cancel(&format!("batches/{id}"), Self::gemini)
            }
            _ => return reply(404, &json!({"error": {"message": path}}).to_string()),
        };
        reply(200, &body.to_string())
    }

    fn batch(&self, id: &str) -> Batch {
        self.batches.iter().find(|b| b.id == id).unwrap().clone()
    }

    fn one(&mut self, id: &str, show: fn(&Self, &Batch) -> Value) -> Value {
        show(self, &self.batch(id))
    }

    fn list(&mut self, show: fn(&Self, &Batch) -> Value) -> Value {
        let data: Vec<Value> = self.batches.iter().rev().map(|b| show(self, b)).collect();
        json!({"data": data, "has_more": false})
    }

    fn cancel(&mut self, id: &str, show: fn(&Self, &Batch) -> Value) -> Value {
        self.state = "cancelling".into();
        self.one(id, show)
    }

    fn push(&mut self, id: String, tag: &str, method: &str, items: Vec<(String, Value)>) -> Batch {
        let batch = Batch {
            id,
            tag: tag.into(),
            method: method.into(),
            items,
            created: jiff::Timestamp::now(),
        };
        self.batches.push(batch.clone());
        batch
    }

    fn state(&self) -> &str {
        match self.state.as_str() {
            "" => "completed",
            state => state,
        }
    }

    fn is_over(&self) -> bool {
        !["validating", "in_progress", "cancelling"].contains(&self.state())
    }

    fn fate(&self, place: usize) -> Fate {
        self.fates.get(place).copied().unwrap_or(Fate::Answered)
    }

    fn count(&self, batch: &Batch, fate: Fate) -> usize {
        let places = 0..batch.items.len();
        places
            .filter(|p| self.is_over() && self.fate(*p) == fate)
            .count()
    }

    /// Results as lines, the last question first.
    fn results(&self, batch: &Batch, line: fn(&Self, Fate, &str) -> Value) -> String {
        let places = (0..batch.items.len())
            .rev()
            .filter(|p| self.fate(*p) != Fate::Forgotten);
        places
            .map(|p| line(self, self.fate(p), &batch.items[p].0).to_string() + "\n")
            .collect()
    }

    fn lines(&self, lines: &str) -> Vec<u8> {
        let Some((kept, told)) = self.cut else {
            return reply(200, lines);
        };
        let part: String = lines.split_inclusive('\n').take(kept).collect();
        let length = if told {
            format!("Content-Length: {}\r\n", lines.len())
        } else {
            String::new()
        };
        format!("HTTP/1.1 200 X\r\n{length}Connection: close\r\n\r\n{part}").into_bytes()
    }

    /// How many tokens of a question its model reads.
    fn tokens_read(&self, id: &str) -> usize {
        let mut items = self.batches.iter().flat_map(|batch| &batch.items);
        let (_, body) = items.find(|(name, _)| name == id).unwrap();
        let tokens = nearmiss::prompts::estimate_tokens(&body.to_string());
        self.context.map_or(tokens, |context| tokens.min(context))
    }

    /// What the model says to a question: its id, so that no two are taken for each other.
    fn said(&self, id: &str) -> String {
        json!({"collision": true, "obstacles": [], "justification": format!("{id} {}", self.words)})
            .to_string()
    }

    fn upload(&mut self, request: &Recorded) -> Value {
        let kind = request.header("content-type").unwrap();
        let boundary = kind.split("boundary=").nth(1).unwrap();
        let body = String::from_utf8(request.body.clone()).unwrap();
        let parts: Vec<&str> = body.split(&format!("--{boundary}")).collect();
        assert_eq!(parts.len(), 4, "two parts and the ends");
        assert!(parts[1].contains("name=\"purpose\"\r\n\r\nbatch\r\n"));
        let (head, lines) = parts[2].split_once("\r\n\r\n").unwrap();
        assert!(head.contains("name=\"file\"; filename="), "{head}");
        let id = format!("file-{}", self.files.len());
        self.files.insert(id.clone(), lines.trim_end().to_string());
        json!({"id": id, "object": "file"})
    }

    fn create_openai(&mut self, body: &Value) -> Value {
        let lines = self.files[body["input_file_id"].as_str().unwrap()].clone();
        let items = lines
            .lines()
            .map(|line| {
                let line: Value = serde_json::from_str(line).unwrap();
                assert_eq!(line["url"], body["endpoint"]);
                (
                    line["custom_id"].as_str().unwrap().to_string(),
                    line["body"].clone(),
                )
            })
            .collect();
        let id = format!("batch_{}", self.batches.len());
        let tag = body["metadata"]["nearmiss"].as_str().unwrap();
        let batch = self.push(id, tag, body["endpoint"].as_str().unwrap(), items);
        self.openai(&batch)
    }

    fn openai(&self, batch: &Batch) -> Value {
        let mut shown = json!({
            "id": batch.id, "object": "batch", "status": self.state(),
            "created_at": batch.created.as_second(), "metadata": {"nearmiss": batch.tag},
            "request_counts": {
                "total": batch.items.len(),
                "completed": self.count(batch, Fate::Answered),
                "failed": self.count(batch, Fate::Errored),
            },
        });
        if self.state() == "failed" {
            shown["errors"] = json!({"data": [{"message": self.words, "code": "invalid"}]});
        } else if self.is_over() {
            shown["output_file_id"] = json!(format!("{}.out", batch.id));
            shown["error_file_id"] = json!(format!("{}.err", batch.id));
        }
        shown
    }

    /// One of OpenAI's two files of results.
    fn openai_file(&self, file: &str) -> String {
        let (id, kind) = file.split_once('.').unwrap();
        let batch = self.batch(id);
        let all = match batch.method.as_str() {
            "/v1/responses" => self.results(&batch, Self::responses_line),
            _ => self.results(&batch, Self::chat_line),
        };
        let good = |line: &&str| line.contains("\"status_code\":200");
        let lines = all.split_inclusive('\n');
        lines.filter(|line| good(line) == (kind == "out")).collect()
    }

    fn chat_line(&self, fate: Fate, id: &str) -> Value {
        self.openai_line(fate, id, json!({
            "model": "tiny-1", "usage": {"prompt_tokens": self.tokens_read(id), "completion_tokens": 100},
            "choices": [{"index": 0, "finish_reason": "stop",
                "message": {"role": "assistant", "content": self.said(id), "reasoning_content": "because"}}],
        }))
    }

    fn responses_line(&self, fate: Fate, id: &str) -> Value {
        self.openai_line(fate, id, json!({
            "object": "response", "status": "completed", "model": "tiny-1", "error": null,
            "usage": {"input_tokens": self.tokens_read(id), "output_tokens": 100},
            "output": [
                {"type": "reasoning", "summary": [{"type": "summary_text", "text": "because"}]},
                {"type": "message", "content": [{"type": "output_text", "text": self.said(id)}]},
            ],
        }))
    }

    fn openai_line(&self, fate: Fate, id: &str, body: Value) -> Value {
        let (response, error) = match fate {
            Fate::Answered => (json!({"status_code": 200, "body": body}), Value::Null),
            Fate::Errored => {
                let body = json!({"error": {"message": self.words, "type": "server_error"}});
                (json!({"status_code": 500, "body": body}), Value::Null)
            }
            Fate::Cancelled => (
                Value::Null,
                json!({"code": "batch_cancelled", "message": "m"}),
            ),
            _ => (
                Value::Null,
                json!({"code": "batch_expired", "message": "m"}),
            ),
        };
        json!({"custom_id": id, "response": response, "error": error})
    }

    fn create_anthropic(&mut self, body: &Value) -> Value {
        let requests = body["requests"].as_array().unwrap().iter();
        let items = requests
            .map(|r| (r["custom_id"].as_str().unwrap().into(), r["params"].clone()))
            .collect();
        let id = format!("msgbatch_{}", self.batches.len());
        let batch = self.push(id, "", "", items);
        self.anthropic(&batch)
    }

    fn anthropic(&self, batch: &Batch) -> Value {
        let status = match self.state() {
            "cancelling" => "canceling",
            _ if self.is_over() => "ended",
            _ => "in_progress",
        };
        let working = if self.is_over() { 0 } else { batch.items.len() };
        json!({
            "id": batch.id, "type": "message_batch", "processing_status": status,
            "created_at": batch.created.to_string(),
            // Somewhere else, where the key must not go.
            "results_url": "http://127.0.0.1:9/results",
            "request_counts": {
                "processing": working,
                "succeeded": self.count(batch, Fate::Answered), "errored": self.count(batch, Fate::Errored),
                "canceled": self.count(batch, Fate::Cancelled), "expired": self.count(batch, Fate::Expired),
            },
        })
    }

    fn anthropic_line(&self, fate: Fate, id: &str) -> Value {
        let result = match fate {
            Fate::Answered => json!({"type": "succeeded", "message": {
                "type": "message", "model": "tiny-1", "stop_reason": "end_turn",
                "content": [{"type": "thinking", "thinking": "because"}, {"type": "text", "text": self.said(id)}],
                "usage": {"input_tokens": self.tokens_read(id), "output_tokens": 100},
            }}),
            Fate::Errored => json!({"type": "errored", "error": {
                "type": "error", "error": {"type": "api_error", "message": self.words},
            }}),
            Fate::Cancelled => json!({"type": "canceled"}),
            _ => json!({"type": "expired"}),
        };
        json!({"custom_id": id, "result": result})
    }

    fn create_gemini(&mut self, body: &Value) -> Value {
        let batch = &body["batch"];
        let requests = batch["inputConfig"]["requests"]["requests"].as_array();
        let items = requests
            .unwrap()
            .iter()
            .map(|r| {
                (
                    r["metadata"]["key"].as_str().unwrap().into(),
                    r["request"].clone(),
                )
            })
            .collect();
        let id = format!("batches/b{}", self.batches.len());
        let tag = batch["displayName"].as_str().unwrap();
        let batch = self.push(id, tag, "", items);
        self.gemini(&batch)
    }

    fn gemini(&self, batch: &Batch) -> Value {
        let state = match self.state() {
            "validating" => "PENDING",
            "in_progress" | "cancelling" => "RUNNING",
            "completed" => "SUCCEEDED",
            "cancelled" => "CANCELLED",
            "expired" => "EXPIRED",
            _ => "FAILED",
        };
        let mut shown = json!({
            "name": batch.id, "done": self.is_over(),
            "metadata": {
                "displayName": batch.tag, "state": format!("BATCH_STATE_{state}"),
                "batchStats": {
                    "requestCount": batch.items.len().to_string(),
                    "successfulRequestCount": self.count(batch, Fate::Answered).to_string(),
                    "failedRequestCount": self.count(batch, Fate::Errored).to_string(),
                },
            },
        });
        if state == "FAILED" {
            shown["error"] = json!({"code": 3, "message": self.words});
        } else if self.is_over() && self.in_a_file {
            let id = batch.id.trim_start_matches("batches/");
            shown["response"] = json!({"responsesFile": format!("files/{id}")});
        } else if self.is_over() {
            let lines = self.results(batch, Self::gemini_line);
            let lines: Vec<Value> = lines
                .lines()
                .map(|l| serde_json::from_str(l).unwrap())
                .collect();
            let given: Vec<&Value> = lines
                .iter()
                .filter(|l| !l["response"].is_null() || !l["error"].is_null())
                .collect();
            shown["response"] = json!({"inlinedResponses": {"inlinedResponses": given}});
        }
        shown
    }

    /// In files, the key stands where nothing else does.
    fn gemini_file_line(&self, fate: Fate, id: &str) -> Value {
        let mut line = self.gemini_line(fate, id);
        line["key"] = line["metadata"]["key"].take();
        line
    }

    /// Gemini says nothing of questions that were not reached.
    fn gemini_line(&self, fate: Fate, id: &str) -> Value {
        let key = json!({"key": id});
        match fate {
            Fate::Answered => json!({"metadata": key, "response": {
                "modelVersion": "tiny-1",
                "candidates": [{"index": 0, "finishReason": "STOP", "content": {"role": "model", "parts": [
                    {"text": "because", "thought": true}, {"text": self.said(id)},
                ]}}],
                "usageMetadata": {"promptTokenCount": self.tokens_read(id), "candidatesTokenCount": 100},
            }}),
            Fate::Errored => json!({"metadata": key, "error": {"code": 13, "message": self.words}}),
            _ => json!({"metadata": key}),
        }
    }
}

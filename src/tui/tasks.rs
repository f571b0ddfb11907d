//! Work outside the model: effects become tasks, and tasks send messages back.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use tokio::sync::mpsc::UnboundedSender;
use tokio::task::AbortHandle;

use super::loaded::{Facts, Opened};
use super::message::{AskId, Effect, Msg, OpenId};
use crate::config::{Config, Folders};
use crate::evaluation::{self, Answer, Judge, Question};
use crate::llm::{Client, Parameters, Registry};
use crate::prompts::Library;
use crate::scenario::{Entry, bundled, find};
use crate::store::Store;
use crate::verdict::Task;

/// Everything that tasks need.
pub struct Tasks {
    /// Where messages go.
    sender: UnboundedSender<Msg>,
    folders: Folders,
    registry: Registry,
    parameters: Parameters,
    client: Client,
    store: Option<Arc<Store>>,
    asking: HashMap<AskId, AbortHandle>,
    /// Raised whenever the list changes, so that surveys of an older list stop.
    survey: Arc<AtomicU64>,
}

/// What is left to the loop, which has the terminal.
#[derive(Debug)]
pub enum Remaining {
    /// Put text into the clipboard.
    Copy(String),
    /// Use the mouse, or not.
    UseMouse(bool),
    /// Go back to the shell for a while.
    Suspend,
    /// End the program.
    Quit,
}

impl Tasks {
    /// Ready for work.
    #[must_use]
    pub fn new(
        sender: UnboundedSender<Msg>,
        folders: Folders,
        registry: Registry,
        config: &Config,
        store: Option<Arc<Store>>,
    ) -> Self {
        Self {
            sender,
            folders,
            registry,
            parameters: Parameters {
                temperature: config.temperature,
                max_tokens: config.max_tokens,
                seed: None,
            },
            client: Client::new(),
            store,
            asking: HashMap::new(),
            survey: Arc::new(AtomicU64::new(0)),
        }
    }

    /// Begins what an effect asks for; gives back what only the loop can do.
    pub fn perform(&mut self, effect: Effect) -> Option<Remaining> {
        match effect {
            Effect::Find(paths) => self.background(move || Msg::Found(found(paths))),
            Effect::Survey(entries) => self.survey(entries),
            Effect::Open(id, entry, ego) => self.background(move || open(id, &entry, ego)),
            Effect::LoadStored(hash, task) => self.load_stored(hash, task),
            Effect::Ask(id, question, model) => self.ask(id, question, &model),
            Effect::Abort(id) => {
                // Dropping the task closes the connection and writes the run down as cancelled.
                if let Some(handle) = self.asking.remove(&id) {
                    handle.abort();
                }
            }
            Effect::SaveTemplate(file, text) => {
                let path = self.folders.prompts().join(&file);
                self.change_template(file, move || Folders::write(&path, &text));
            }
            Effect::RemoveTemplate(file) => {
                let path = self.folders.prompts().join(&file);
                self.change_template(file, move || match std::fs::remove_file(&path) {
                    Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(e),
                    _ => Ok(()),
                });
            }
            Effect::Copy(text) => return Some(Remaining::Copy(text)),
            Effect::UseMouse(on) => return Some(Remaining::UseMouse(on)),
            Effect::Suspend => return Some(Remaining::Suspend),
            Effect::Quit => return Some(Remaining::Quit),
        }
        None
    }

    fn background(&self, work: impl FnOnce() -> Msg + Send + 'static) {
        let sender = self.sender.clone();
        tokio::task::spawn_blocking(move || {
            // The loop may have ended meanwhile; then nobody wants to know.
            let _ = sender.send(work());
        });
    }

    fn survey(&self, entries: Vec<(usize, Entry)>) {
        let mine = self.survey.fetch_add(1, Ordering::SeqCst) + 1;
        let (current, sender) = (self.survey.clone(), self.sender.clone());
        tokio::task::spawn_blocking(move || {
            for (place, entry) in entries {
                if current.load(Ordering::SeqCst) != mine
                    || sender
                        .send(Msg::Surveyed(place, Facts::read(&entry)))
                        .is_err()
                {
                    return;
                }
            }
        });
    }

    fn load_stored(&self, hash: String, task: Task) {
        let Some(store) = self.store.clone() else {
            return;
        };
        self.background(move || {
            let runs = store.of_scenario(&hash, task, 20).unwrap_or_default();
            Msg::Stored(hash, task, runs.into_iter().map(Answer::from).collect())
        });
    }

    fn ask(&mut self, id: AskId, question: Box<Question>, model: &str) {
        let env = |name: &str| std::env::var(name).ok();
        let judge = Judge::resolve(model, &self.registry, &self.client, self.parameters, env);
        let judge = match judge {
            Ok(judge) => judge,
            Err(error) => {
                let _ = self.sender.send(Msg::Answered(id, Err(error.to_string())));
                return;
            }
        };
        let (sender, store) = (self.sender.clone(), self.store.clone());
        let task = tokio::spawn(async move {
            let events = sender.clone();
            let result = evaluation::run(&question, &judge, store, move |event| {
                let _ = events.send(Msg::Asked(id, event));
            });
            let result = result.await.map(Box::new).map_err(|e| e.to_string());
            let _ = sender.send(Msg::Answered(id, result));
        });
        self.asking.retain(|_, handle| !handle.is_finished());
        self.asking.insert(id, task.abort_handle());
    }

    fn change_template(
        &self,
        file: String,
        change: impl FnOnce() -> std::io::Result<()> + Send + 'static,
    ) {
        let folder = self.folders.prompts();
        self.background(move || {
            let result = change()
                .map(|()| Library::load(Some(&folder)))
                .map_err(|e| format!("{}: {e}", folder.join(&file).display()));
            Msg::Saved(file, result)
        });
    }
}

fn found(paths: Vec<PathBuf>) -> Result<Vec<Entry>, String> {
    if paths.is_empty() {
        Ok(bundled())
    } else {
        find(&paths).map_err(|e| e.to_string())
    }
}

fn open(id: OpenId, entry: &Entry, ego: Option<i64>) -> Msg {
    Msg::Opened(id, Opened::read(entry, ego).map(Box::new))
}

//! Batches with real tasks, a real store and a local server.

use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

use self::server::{Script, Server};
use crate::features::answers::Probe;
use crate::features::history::HistoryScreen;
use crate::keymap::Key;
use crate::message::{Effect, Msg};
use crate::model::{JobState, Model, Notice};
use crate::services::Services;
use crate::theme::Theme;
use crate::update::{start, update};
use nearmiss_ask::llm::{Environment, Registry};
use nearmiss_ask::prompts::Library;
use nearmiss_formats::EgoSelection;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_settings::{Config, Folders};
use nearmiss_store::{Filter, Store};

#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../../../tests/support/server.rs"]
pub(super) mod server;

/// Longer than any machine takes for one step.
const PATIENCE: Duration = Duration::from_secs(60);

/// A workbench without a screen.
pub(super) struct Whole {
    pub model: Model,
    pub tasks: Services,
    news: UnboundedReceiver<Msg>,
    folders: Folders,
    _folder: tempfile::TempDir,
}

impl Whole {
    pub fn start(server: &Server, more: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let folders = Folders {
            config: folder.path().join("config"),
            data: folder.path().join("data"),
        };
        let text = format!(
            "model = \"lab/small\"\n{more}\n[provider.lab]\nbase_url = \"{}\"\nattempts = 1\n\
             [[provider.lab.prices]]\nmodel = \"small\"\ninput = 1.0\noutput = 2.0\n",
            server.base_url()
        );
        let file = folders.config_file();
        Folders::write(&file, &text).unwrap();
        let config = Config::read(&file).unwrap();
        let registry = Registry::new(&config.providers).unwrap();
        let environment = Environment::with_files(&[]);
        let thresholds = Arc::new(Thresholds::shipped().clone());
        let store = Arc::new(Store::open(&folders.store()).unwrap());
        let (sender, news) = unbounded_channel();
        let tasks = Services::new(
            sender,
            folders.clone(),
            (registry, environment),
            &config,
            thresholds,
            Some(store),
            EgoSelection::Beside,
        );
        let library = Library::load(None);
        let model = Model::new(
            Vec::new(),
            config,
            Theme::default_theme(),
            library,
            Vec::new(),
        );
        let mut whole = Self {
            model,
            tasks,
            news,
            folders,
            _folder: folder,
        };
        let effects = start(&mut whole.model)
            // Servers on this machine are not what this is about.
            .into_iter()
            .filter(|e| !matches!(e.request(), Some(Probe)));
        whole.perform(effects.collect());
        whole
    }

    fn perform(&mut self, effects: Vec<Effect>) {
        for effect in effects {
            self.tasks.perform(effect);
        }
    }

    pub fn press(&mut self, keys: &str) {
        for name in keys.split(' ') {
            let effects = update(&mut self.model, Msg::Key(Key::parse(name).unwrap()));
            self.perform(effects);
        }
    }

    /// Its folders, for another look at the store.
    pub fn folders(&self) -> &Folders {
        &self.folders
    }

    /// Takes messages until something holds.
    pub async fn until(&mut self, what: &str, holds: impl Fn(&Model) -> bool) {
        let begun = Instant::now();
        while !holds(&self.model) {
            let left = PATIENCE.saturating_sub(begun.elapsed());
            let msg = tokio::time::timeout(left, self.news.recv())
                .await
                .unwrap_or_else(|_| panic!("{what}: {:?}", self.model.toasts));
            let effects = update(&mut self.model, msg.unwrap());
            self.perform(effects);
        }
    }

    /// Opens the card and waits until everything is counted.
    async fn count(&mut self) {
        self.until("scenarios", |model| {
            model.list.found && model.opened.is_some()
        })
        .await;
        self.press("space a a");
        let counted = |model: &Model| model.card.as_ref().is_some_and(|card| card.is_counted());
        self.until("counted", counted).await;
    }

    async fn over(&mut self) {
        let over = |model: &Model| !model.jobs.has_batch();
        self.until("the end of the batch", over).await;
    }

    fn state(&self) -> JobState {
        let mut jobs = self.model.jobs.all.iter().rev();
        jobs.find(|job| job.asks()).unwrap().state.clone()
    }

    /// States of the runs in the store, the oldest first.
    pub fn states(&self) -> Vec<String> {
        let store = Store::open(&self.folders.store()).unwrap();
        let mut runs = store.list(&Filter::default(), 100).unwrap();
        runs.reverse();
        runs.into_iter()
            .map(|run| run.state.name().into())
            .collect()
    }
}

/// A server's whole answer.
fn said(collision: bool) -> Script {
    let verdict = serde_json::json!({
        "collision": collision, "obstacles": [], "justification": "so it is",
    });
    let delta = serde_json::json!({
        "model": "small",
        "choices": [{ "index": 0, "delta": { "content": verdict.to_string() } }],
    });
    Script::chunked_events()
        .chunk(format!("data: {delta}\n\n"))
        .chunk("data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"stop\"}]}\n\n")
        .chunk("data: {\"choices\":[],\"usage\":{\"prompt_tokens\":9000,\"completion_tokens\":100}}\n\n")
        .chunk("data: [DONE]\n\n")
        .end_of_chunks()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_scenario_is_asked_about_once_and_the_store_answers_the_second_time() {
    let server = Server::start((0..8).map(|_| said(true)).collect()).await;
    let mut whole = Whole::start(&server, "max_tokens = 500");
    whole.count().await;
    let counts = whole.model.card.as_ref().unwrap().counts.clone();
    assert_eq!(
        (
            counts.estimate.requests,
            counts.estimate.stored,
            counts.estimate.unaskable
        ),
        (8, 0, 0)
    );
    assert!(counts.estimate.tokens > 1000 && counts.refused.is_none());
    let price = counts.estimate.price();
    assert!(price.starts_with("at most $0."), "{price}");
    assert!(server.requests().is_empty(), "counting sends nothing");
    whole.press("enter");
    whole.over().await;
    // Two of the eight scenarios end in a collision.
    assert_eq!(
        whole.state(),
        JobState::Done("2 agree, 6 differ, 0 failed".into())
    );
    assert_eq!(
        (server.requests().len(), whole.states()),
        (8, vec!["answered".to_string(); 8])
    );
    let (usd, unknown) = whole.model.jobs.cost();
    assert!(
        (usd - 8.0 * (9000.0 + 2.0 * 100.0) / 1e6).abs() < 1e-9 && unknown == 0,
        "{usd}"
    );
    let columns = &whole.model.answers.columns;
    assert_eq!(columns.len(), 1, "the answer about what is open is shown");
    // The same again: nothing is sent, nothing is paid.
    whole.count().await;
    let counts = &whole.model.card.as_ref().unwrap().counts;
    assert_eq!((counts.estimate.requests, counts.estimate.stored), (0, 8));
    assert_eq!(counts.estimate.price(), "free");
    whole.press("enter");
    whole.over().await;
    assert_eq!(
        whole.state(),
        JobState::Done("2 agree, 6 differ, 0 failed".into())
    );
    assert_eq!(
        (server.requests().len(), whole.model.jobs.cost().0),
        (8, usd)
    );
    // And the history has them, under the name of their batch.
    whole.press("space o j");
    whole.model.jobs.selected = 1;
    whole.press("enter");
    whole
        .until("the runs", |model| model.history.total == Some(8))
        .await;
    assert!(whole.model.screens.is_top::<HistoryScreen>());
    assert!(whole.model.history.line.starts_with("batch:"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn so_many_at_once_and_what_was_not_begun_is_not_asked_after_a_cancel() {
    let held = || Script::chunked_events().await_close();
    let server = Server::start((0..8).map(|_| held()).collect()).await;
    let mut whole = Whole::start(&server, "concurrency = 3");
    whole.count().await;
    assert_eq!(whole.model.card.as_ref().unwrap().counts.at_once, 3);
    whole.press("enter");
    let begun = Instant::now();
    while server.requests().len() < 3 && begun.elapsed() < PATIENCE {
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    tokio::time::sleep(Duration::from_millis(200)).await;
    assert_eq!(server.requests().len(), 3, "the bound holds");
    whole.press("space o j x");
    assert_eq!(whole.state(), JobState::Stopping);
    whole.press("x");
    whole.over().await;
    assert!(matches!(whole.state(), JobState::Cancelled(words) if words.contains("8 not asked")));
    whole.tasks.finish().await;
    assert_eq!(server.requests().len(), 3);
    assert_eq!(
        whole.states(),
        vec!["cancelled".to_string(); 3],
        "and that is written down"
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn leaving_cancels_a_batch_and_writes_that_down() {
    let held = || Script::chunked_events().await_close();
    let server = Server::start((0..8).map(|_| held()).collect()).await;
    let mut whole = Whole::start(&server, "concurrency = 2");
    whole.count().await;
    whole.press("enter");
    let begun = Instant::now();
    while server.requests().len() < 2 && begun.elapsed() < PATIENCE {
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    whole.tasks.finish().await;
    assert_eq!(whole.states(), vec!["cancelled".to_string(); 2]);
    assert!(server.seen_close().await);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn faults_are_counted_and_told_once_and_the_budget_holds() {
    let fault = Script::json(400, r#"{"error":{"message":"no such model"}}"#);
    let server = Server::start(vec![fault; 8]).await;
    let mut whole = Whole::start(&server, "");
    whole.count().await;
    whole.press("enter");
    whole.over().await;
    assert!(matches!(whole.state(), JobState::Failed(words) if words.contains("8 failed")));
    let toasts = whole.model.toasts.iter();
    let errors = toasts.filter(|t| t.kind == Notice::Error);
    let errors: Vec<_> = errors.map(|t| t.text.clone()).collect();
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert!(
        errors[0].contains("8 failed") && errors[0].contains("no such model"),
        "{errors:?}"
    );

    let server = Server::start(vec![said(true); 8]).await;
    let mut whole = Whole::start(&server, "max_tokens = 500\nbudget = 0.0001");
    whole.count().await;
    let refused = whole.model.card.as_ref().unwrap().counts.refused.clone();
    assert!(refused.is_some_and(|why| why.contains("budget")));
    whole.press("enter");
    assert!(!whole.model.jobs.has_batch() && server.requests().is_empty());
}

//! Questions, batches, tools and attacks with real tasks, a real store and a local server.

#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../../../tests/support/server.rs"]
pub(super) mod server;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use nearmiss_ask::llm::{Environment, Registry};
use nearmiss_ask::prompts::Library;
use nearmiss_drive::generation::{
    AllowedAttacks, AttackSetup, ClosedLoop, Progress, VariantGenerator, search_until,
};
use nearmiss_drive::planner::{Cancel, Forecast};
use nearmiss_formats::{EgoSelection, bundled};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::verdict::Motion;
use nearmiss_settings::{Config, Folders};
use nearmiss_store::{Filter, RunId, Store};
use nearmiss_study::evaluation;
use nearmiss_workflow::AttackSource;
use serde_json::{Value, json};
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

use crate::features::answers::Probe;
use crate::features::history::HistoryScreen;
use crate::keymap::Key;
use crate::loaded::{
    GenerationInputs, GenerationProgress, GenerationStage, Opened, VariantRequest, Writer,
};
use crate::message::{Effect, Msg};
use crate::model::{JobKind, JobState, Model, Notice};
use crate::services::Services;
use crate::tests::asking::server::{Script, Server};
use crate::tests::bench::{SHORT, coarse, with};
use crate::tests::written::{Canned, found};
use crate::theme::Theme;
use crate::update::{start, update};
use server::Recorded;

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
        let registry = Registry::new(&config.provider).unwrap();
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
        let counted = |model: &Model| {
            model
                .proposal
                .as_ref()
                .is_some_and(|card| card.is_counted())
        };
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
    let counts = whole.model.proposal.as_ref().unwrap().counts.clone();
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
    let counts = &whole.model.proposal.as_ref().unwrap().counts;
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
    assert_eq!(whole.model.proposal.as_ref().unwrap().counts.at_once, 3);
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
    let refused = whole
        .model
        .proposal
        .as_ref()
        .unwrap()
        .counts
        .refused
        .clone();
    assert!(refused.is_some_and(|why| why.contains("budget")));
    whole.press("enter");
    assert!(!whole.model.jobs.has_batch() && server.requests().is_empty());
}

/// Any attack on the ego that turns right.
pub fn right_turn() -> VariantRequest {
    let mut all = bundled().into_iter();
    VariantRequest {
        style: Default::default(),
        entry: all.find(|e| e.name.contains("RightTurn")).unwrap(),
        change: None,
        forecast: Forecast::Lane,
        planner: 0,
        only: None,
        wish: None,
        attackers: 1,
        seed: 1,
        writer: None,
        folder: None,
    }
}

#[test]
fn who_cancels_hears_nothing_more() {
    let wish = right_turn();
    let settings = coarse(wish.forecast);
    let thresholds = Thresholds::shipped();
    let ends = [
        |at: GenerationStage| matches!(at, GenerationStage::Driving(4, _)),
        |at: GenerationStage| matches!(at, GenerationStage::Searching(progress, _) if progress.tried > 0),
    ];
    for end in ends {
        let cancel = Cancel::default();
        let mut heard = Vec::new();
        let mut on_event = |event| {
            if let GenerationProgress::Working(at) = event {
                heard.push(at);
                if end(at) {
                    cancel.ask();
                }
            }
        };
        let (ego, how) = (EgoSelection::Beside, with(&settings));
        let made = Opened::generated(&wish, &ego, thresholds, &how, &cancel, &mut on_event);
        assert!(matches!(made, Ok(None)));
        let ended = heard.iter().position(|at| end(*at));
        assert_eq!(ended, Some(heard.len() - 1), "{heard:?}");
    }
}

#[test]
fn a_search_that_is_to_stop_begins_no_motion_and_no_drive_more() {
    let wish = right_turn();
    let settings = coarse(wish.forecast);
    let scenario = wish.entry.read().unwrap();
    let problem = &scenario.planning_problems[0];
    let cancel = Cancel::default();
    let driven = ClosedLoop::watched(
        scenario.clone(),
        problem,
        &settings,
        &cancel,
        &mut |_, _| true,
    );
    let workshop = VariantGenerator::from_closed_loop(driven.unwrap()).unwrap();
    // In the middle of the first round, of 32 motions in groups.
    let asked = AtomicUsize::new(0);
    let stop = || asked.fetch_add(1, Ordering::Relaxed) >= 10;
    let mut last = Progress::default();
    let mut watch = |progress| {
        last = progress;
        asked.load(Ordering::Relaxed) < 10
    };
    let search = |ground: &AttackSetup<'_>| {
        search_until(ground, &SHORT, AllowedAttacks::default(), &mut watch, &stop)
    };
    let found = workshop.on(search).unwrap();
    // Every motion after the tenth is refused unmade, and no further group of motions begins.
    assert!(last.tried >= 10 && last.tried <= 32, "{last:?}");
    assert!(
        last.refused >= last.tried - 10 && last.driven == 0,
        "{last:?}"
    );
    assert_eq!(found.progress(), last);
}

#[test]
fn who_cancels_is_driven_against_nothing_more() {
    let wish = VariantRequest {
        style: Default::default(),
        writer: Some(Box::new(Writer {
            model: "lab/small".into(),
            name: "test".into(),
            library: Library::load(None),
            settings: evaluation::Settings::default(),
            method: evaluation::generating::Method::default(),
            fresh: false,
        })),
        ..right_turn()
    };
    let (settings, thresholds) = (coarse(wish.forecast), Thresholds::shipped());
    for end in [GenerationStage::Proving, GenerationStage::Trying(0, 2)] {
        let cancel = Cancel::default();
        let mut heard = Vec::new();
        let mut on_event = |event| {
            if let GenerationProgress::Working(at) = event {
                heard.push(at);
                if at == end {
                    cancel.ask();
                }
            }
        };
        let how = GenerationInputs {
            settings: &settings,
            planner: None,
            source: AttackSource::Model(&Canned),
        };
        let ego = EgoSelection::Beside;
        let made = Opened::generated(&wish, &ego, thresholds, &how, &cancel, &mut on_event);
        assert!(matches!(made, Ok(None)));
        assert_eq!(heard.last(), Some(&end));
    }
}

/// A server that calls a tool once where it may, and then answers.
async fn tools_server() -> Server {
    Server::answering(|_, request: &Recorded| {
        let body = request.json();
        let messages = body["messages"].as_array().unwrap();
        let told = messages.iter().any(|message| message["role"] == "tool");
        let message = if body.get("tools").is_some() && !told { json!({
                "role": "assistant", "content": null, "tool_calls": [{
                    "id": "c", "type": "function",
                    "function": {"name": "list_obstacles", "arguments": "{}"},
                }],
            }) } else { json!({
                "role": "assistant",
                "content": r#"{"collision": false, "obstacles": [], "justification": "so"}"#,
            }) };
        let turn = json!({
            "model": "small", "choices": [{"index": 0, "message": message, "finish_reason": "stop"}],
            "usage": {"prompt_tokens": 100, "completion_tokens": 10},
        });
        Some(Script::json(200, &turn.to_string()))
    })
    .await
}

fn with_tools(server: &Server) -> Vec<bool> {
    let requests = server.requests();
    let bodies = requests.iter().map(Recorded::json);
    bodies
        .map(|body: Value| body.get("tools").is_some())
        .collect()
}

async fn answered(whole: &mut Whole, columns: usize) {
    let done = move |model: &Model| {
        let all = &model.answers.columns;
        all.len() == columns && all.iter().all(|column| column.answer().is_some())
    };
    whole.until("an answer", done).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_switch_reaches_the_server_and_what_was_asked_is_in_the_store() {
    let server = tools_server().await;
    let mut whole = Whole::start(&server, "max_tokens = 100");
    let open = |model: &Model| model.list.found && model.opened.is_some();
    whole.until("scenarios", open).await;
    whole.press("r");
    answered(&mut whole, 1).await;
    whole.press("space a u r");
    answered(&mut whole, 2).await;
    assert_eq!(with_tools(&server), [false, true, true]);
    let column = whole.model.answers.column().unwrap();
    assert!(column.how.ends_with("+tools"), "{}", column.how);
    assert_eq!(column.tool_rounds.len(), 1);
    // Both are two questions, each answered by the store from now on.
    whole.press("r");
    answered(&mut whole, 2).await;
    whole.press("space a u r");
    answered(&mut whole, 2).await;
    assert_eq!(server.requests().len(), 3);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_configuration_begins_with_tools_and_attacks_use_none() {
    let server = tools_server().await;
    let mut whole = Whole::start(&server, "tools = true\nattack_within = 300.0");
    let open = |model: &Model| model.list.found && model.opened.is_some();
    whole.until("scenarios", open).await;
    assert!(whole.model.tools);
    whole.press("r");
    answered(&mut whole, 1).await;
    assert_eq!(with_tools(&server), [true, true]);
    // As `generate` asks, which has no tools.
    whole.press("space g m enter");
    whole
        .until("the end", |model| model.jobs.asking() == 0)
        .await;
    let asked = with_tools(&server);
    assert!(asked.len() > 2 && !asked[2..].contains(&true), "{asked:?}");
}

/// An answer as a server streams it.
fn says(answer: &serde_json::Value) -> Script {
    let delta = serde_json::json!({
        "model": "small",
        "choices": [{ "index": 0, "delta": { "content": answer.to_string() } }],
    });
    Script::chunked_events()
        .chunk(format!("data: {delta}\n\n"))
        .chunk("data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"stop\"}]}\n\n")
        .chunk("data: {\"choices\":[],\"usage\":{\"prompt_tokens\":9000,\"completion_tokens\":100}}\n\n")
        .chunk("data: [DONE]\n\n")
        .end_of_chunks()
}

fn chooses(attacker: i64) -> Script {
    says(&serde_json::json!({
        "attacker": attacker,
        "obstacles": [{ "id": attacker, "risk_score": 2, "reason": "near" }],
        "justification": "It is the nearest.",
    }))
}

/// Grades an obstacle.
fn grades(obstacle: i64) -> Script {
    says(&serde_json::json!({
        "justification": "It closes in.",
        "obstacles": [{ "id": obstacle, "risk_score": 1, "reason": "near" }],
        "critical_obstacles": [{ "id": obstacle, "probability": 0.9 }],
        "probability": 0.9,
        "safety_critical": true,
    }))
}

/// Moves an obstacle as the search found it.
fn moves(attacker: i64, motion: &Motion) -> Script {
    let asked = serde_json::json!(nearmiss_drive::generation::RequestedMotion::from(motion));
    says(&serde_json::json!({
        "obstacle": attacker,
        "waypoints": null,
        "manoeuvre": asked["manoeuvre"],
        "justification": "It leaves no room.",
    }))
}

/// The planner of [`coarse`], one request at a time.
const COARSE: &str = "concurrency = 1\nmax_tokens = 500\n[planner]\nhorizon = 3.0\n[planner.sampling]\ndurations = 2\n\
                      speeds = 4\noffsets = 5\nchanges = 1\nrefinements = 0";

impl Whole {
    /// Opens the right turn, and lets the model attack.
    async fn attack(&mut self) {
        self.until("scenarios", |model| model.list.found).await;
        self.press("/ r i g h t t u r n enter");
        let open = |model: &Model| {
            let opened = model.opened.as_ref();
            model.opening.is_none() && opened.is_some_and(|o| o.name.contains("RightTurn"))
        };
        self.until("the right turn", open).await;
        self.press("space g m enter");
    }

    async fn end(&mut self) -> JobState {
        self.until("the end", |model| model.jobs.asking() == 0)
            .await;
        let job = self.model.jobs.all.iter().rev().find(|job| job.asks());
        job.unwrap().state.clone()
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_server_writes_it_and_nothing_is_paid_for_twice() {
    let (id, motion) = found();
    let server = Server::answering(move |_, request| {
        let body = request.json().to_string();
        Some(if body.contains("Which obstacle should be the attacker") {
            chooses(id)
        } else if body.contains("Write a new motion for obstacle") {
            moves(id, &motion)
        } else {
            grades(id)
        })
    })
    .await;
    let far = format!("attack_within = 300.0\n{COARSE}");
    let mut whole = Whole::start(&server, &far);
    whole.attack().await;
    let state = whole.end().await;
    assert!(
        matches!(&state, JobState::Done(words) if words.starts_with("collision, attacker")),
        "{state:?} {:?}",
        whole.model.toasts
    );
    let job = whole.model.jobs.all.last().unwrap();
    // Three votes and at least five motions; all motions are the same, so one grade is asked for, and the rest is in the
    // store.
    let asked = server.requests().len();
    assert!((9..=19).contains(&asked), "{asked}");
    assert_eq!(job.tokens, asked as u64 * 9100);
    assert!(
        (job.cost - asked as f64 * 9200e-6).abs() < 1e-9,
        "{}",
        job.cost
    );
    assert_eq!(whole.states(), vec!["answered".to_string(); asked]);
    let made = whole.model.variant().unwrap().made.clone();
    let wrote = made.authorship.as_ref().unwrap();
    let papers = made.variant().author.unwrap();
    assert!(
        papers["justification"].is_string() && papers["requests"].as_u64() > Some(0),
        "{papers}"
    );
    assert_eq!(
        (made.by.as_str(), wrote.authored.attacks.len()),
        ("lab/small", asked - 4)
    );
    let run = wrote.taken.unwrap().run;
    assert!(run.is_some_and(|run| run > RunId(1)), "{run:?}");
    assert_eq!(made.effect.main().obstacle, id);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_cancelled_is_closed_and_written_down() {
    let held = Script::chunked_events().await_close();
    let server = Server::start(vec![held]).await;
    let mut whole = Whole::start(&server, COARSE);
    whole.attack().await;
    let asked = |model: &Model| {
        let search = model.generation.under_way.as_ref();
        search.is_some_and(|s| matches!(s.at, Some(GenerationStage::Writing(_))))
    };
    whole.until("a question", asked).await;
    while server.requests().is_empty() {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    whole.press("esc esc");
    assert!(matches!(whole.end().await, JobState::Cancelled(_)));
    assert!(server.seen_close().await);
    assert_eq!(whole.states(), ["cancelled"]);
    assert!(whole.model.variant().is_none() && !whole.model.jobs.is_stopping(JobKind::Generate));
    // Who leaves in the middle of it pays for nothing that is not written down.
    whole.press("space g m enter");
    whole.until("a question", asked).await;
    whole.tasks.finish().await;
    assert!(
        !whole.states().contains(&"running".to_string()),
        "{:?}",
        whole.states()
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn that_nothing_can_be_asked_is_said() {
    let fault = Script::json(401, r#"{"error":{"message":"no such key"}}"#);
    let server = Server::start(vec![fault]).await;
    let mut whole = Whole::start(&server, COARSE);
    whole.attack().await;
    let state = whole.end().await;
    assert!(
        matches!(&state, JobState::Failed(why) if why.contains("401")),
        "{state:?}"
    );
    let errors = whole
        .model
        .toasts
        .iter()
        .filter(|t| t.kind == Notice::Error);
    let errors: Vec<&str> = errors.map(|t| t.text.as_str()).collect();
    assert!(
        errors.len() == 1 && errors[0].contains("no such key"),
        "{errors:?}"
    );
    assert_eq!(server.requests().len(), 1);

    // More than the budget allows, and an unknown model.
    let server = Server::start(Vec::new()).await;
    let mut whole = Whole::start(&server, &format!("budget = 0.00001\n{COARSE}"));
    whole.attack().await;
    let state = whole.end().await;
    assert!(
        matches!(&state, JobState::Failed(why) if why.contains("budget")),
        "{state:?}"
    );
    assert!(server.requests().is_empty());
    whole.model.model = "nobody/knows".into();
    whole.press("space g m enter");
    let state = whole.end().await;
    assert!(
        matches!(&state, JobState::Failed(why) if why.contains("nobody")),
        "{state:?}"
    );
}

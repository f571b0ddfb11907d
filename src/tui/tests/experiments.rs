//! Experiments with real tasks, a real store and a local server: read, counted, asked, gone on with, written.

use std::path::{Path, PathBuf};

use crate::features::experiment::ExperimentScreen;
use crate::features::results::ResultsScreen;
use crate::model::Model;
use crate::tests::asking::Whole;
use crate::tests::asking::server::{Script, Server};
use nearmiss_ask::prompts::Library;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_store::{SplitPart, Store};
use nearmiss_study::evaluation::batch::{AnswerSet, BatchPart};
use nearmiss_workflow::{ExperimentContext, find_scenarios, prepare_experiment, read_experiment};

pub(super) const HEAD: &str = "scenarios = [\"ZAM_CutIn-1_1_T-1\", \"ZAM_RedLight-1_1_T-1\"]\n";

/// A server's whole answer.
fn said() -> Script {
    let verdict = serde_json::json!({
        "safety_critical": true, "obstacles": [], "justification": "so it is",
    });
    let delta = serde_json::json!({
        "model": "small",
        "choices": [{ "index": 0, "delta": { "content": verdict.to_string() } }],
    });
    Script::chunked_events()
        .chunk(format!("data: {delta}\n\n"))
        .chunk("data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"stop\"}]}\n\n")
        .chunk("data: {\"choices\":[],\"usage\":{\"prompt_tokens\":1000,\"completion_tokens\":100}}\n\n")
        .chunk("data: [DONE]\n\n")
        .end_of_chunks()
}

pub(super) fn write(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

pub(super) fn toasts(model: &Model) -> String {
    let all = model.toasts.iter().map(|toast| toast.text.clone());
    all.collect::<Vec<_>>().join("\n")
}

/// Opens a file and waits until it is counted, or cannot be.
pub(super) async fn open(whole: &mut Whole, file: &Path) {
    whole.model.experiment.chosen = Some(file.to_path_buf());
    whole.press(if whole.model.screens.is_top::<ExperimentScreen>() {
        "o"
    } else {
        "space o e"
    });
    counted(whole).await;
}

pub(super) async fn counted(whole: &mut Whole) {
    whole
        .until("the experiment", |model| {
            let view = &model.experiment;
            view.working.is_none() && (view.counted.is_some() || view.problem.is_some())
        })
        .await;
}

async fn over(whole: &mut Whole) {
    let over = |model: &Model| model.experiment.asking.is_none() && !model.jobs.has_batch();
    whole.until("the end of the experiment", over).await;
}

pub(super) fn problem(whole: &Whole) -> &str {
    whole
        .model
        .experiment
        .problem
        .as_deref()
        .unwrap_or_default()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn it_is_counted_asked_after_a_yes_and_gone_on_with() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!(
        "title = \"Is it?\"\n{HEAD}models = [\"lab/small\"]\nsamples = 2\nmax_tokens = 500\n"
    );
    let file = write(folder.path(), "e.toml", &text);
    let mut answers: Vec<Script> = (0..3).map(|_| said()).collect();
    let refusal = "{\"error\":{\"message\":\"not this one\"}}";
    answers.push(Script::json(400, refusal));
    answers.extend((0..4).map(|_| said()));
    let server = Server::start(answers).await;
    let mut whole = Whole::start(&server, "concurrency = 1");
    open(&mut whole, &file).await;
    let view = &whole.model.experiment;
    assert_eq!(problem(&whole), "");
    let outline = view.outline.as_ref().unwrap();
    assert_eq!(
        (outline.title.as_deref(), outline.ways),
        (Some("Is it?"), 1)
    );
    let counted_now = view.counted.as_ref().unwrap();
    let (requests, windows) = (counted_now.requests, view.progress.windows);
    assert_eq!((counted_now.batch, requests), (None, 2 * windows as u64));
    assert!(counted_now.price.starts_with("at most $0."));
    assert_eq!(view.progress.sums(), [0, 0, requests as usize, 0]);
    assert!(server.requests().is_empty(), "counting sends nothing");
    // A no, then a yes.
    whole.press("r");
    assert!(whole.model.experiment.confirming);
    whole.press("x n");
    assert!(!whole.model.experiment.confirming && server.requests().is_empty());
    whole.press("r y");
    over(&mut whole).await;
    counted(&mut whole).await;
    let view = &whole.model.experiment;
    let batch = view.counted.as_ref().unwrap().batch.unwrap();
    let [answered, failed, open_now, _] = view.progress.sums();
    assert_eq!((answered + 1, failed, open_now), (requests as usize, 1, 0));
    let spent = view.counted.as_ref().unwrap().spent;
    assert!(
        (spent.0 - answered as f64 * 1200.0 / 1e6).abs() < 1e-9,
        "{spent:?}"
    );
    // The failed one is open again; what was answered is not asked a second time.
    assert_eq!(view.counted.as_ref().unwrap().requests, 1);
    whole.press("r enter");
    over(&mut whole).await;
    counted(&mut whole).await;
    let view = &whole.model.experiment;
    assert_eq!(view.counted.as_ref().unwrap().batch, Some(batch));
    assert_eq!(view.progress.sums(), [requests as usize, 0, 0, 0]);
    assert_eq!(server.requests().len(), requests as usize + 1);
    whole.press("r");
    assert!(toasts(&whole.model).contains("every question has its answer"));
    assert!(!whole.model.experiment.confirming);
    // Its results, and back.
    whole.press("enter");
    assert!(whole.model.screens.is_top::<ResultsScreen>());
    let chosen = whole.model.results.chosen;
    assert_eq!(chosen, Some(AnswerSet::Batch(batch, BatchPart::Plain)));
    whole
        .until("the results", |model| !model.results.reading)
        .await;
    assert_eq!(whole.model.results.rows.len(), 1);
    whole.press("esc");
    assert!(whole.model.screens.is_top::<ExperimentScreen>());
    // A file opened again goes on with its batch; a changed one is another.
    whole.press("esc");
    open(&mut whole, &file).await;
    assert_eq!(
        whole.model.experiment.counted.as_ref().unwrap().batch,
        Some(batch)
    );
    write(
        folder.path(),
        "e.toml",
        &text.replace("samples = 2", "samples = 1"),
    );
    whole.press("shift-r");
    counted(&mut whole).await;
    let counted_now = whole.model.experiment.counted.as_ref().unwrap();
    assert_eq!(
        (counted_now.batch, counted_now.requests),
        (None, 0),
        "the store has the answers"
    );
    assert_eq!(counted_now.free, requests / 2);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_workbench_asks_what_the_workflow_of_the_command_line_asks() {
    let folder = tempfile::tempdir().unwrap();
    let text =
        format!("{HEAD}models = [\"reference/geometry\"]\nleads = [0.5, 1]\nselect = \"cutin\"\n");
    let file = write(folder.path(), "e.toml", &text);
    let server = Server::start(Vec::new()).await;
    let mut whole = Whole::start(&server, "");
    open(&mut whole, &file).await;
    assert_eq!(problem(&whole), "");
    whole.press("r y");
    over(&mut whole).await;
    counted(&mut whole).await;
    let store = Store::open(&whole.folders().store()).unwrap();
    let stored = store.last_batch().unwrap().unwrap();
    let (library, thresholds) = (
        Library::load(None),
        std::sync::Arc::new(Thresholds::shipped().clone()),
    );
    let experiment = read_experiment(&text, &file, &library).unwrap();
    let context = ExperimentContext {
        library: &library,
        thresholds: &thresholds,
        store: &store,
    };
    let found = find_scenarios(&experiment).unwrap().entries;
    let prepared = prepare_experiment(&experiment, &file, found, None, context).unwrap();
    assert_eq!(prepared.batch(), Some(stored.id), "the same specification");
    assert_eq!(prepared.request().entries.len(), 1);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn stopping_leaves_the_rest_open_and_closing_the_screen_does_not_stop() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("{HEAD}models = [\"lab/small\"]\n");
    let file = write(folder.path(), "e.toml", &text);
    let held = || Script::chunked_events().await_close();
    let server = Server::start(vec![said(), held()]).await;
    let mut whole = Whole::start(&server, "concurrency = 1");
    open(&mut whole, &file).await;
    whole.press("r y");
    whole
        .until("an answer", |model| {
            model.experiment.progress.sums()[0] == 1
        })
        .await;
    // Another file has to wait, and so does a change of this one.
    whole.press("e shift-r");
    assert!(toasts(&whole.model).contains("it is being asked"));
    whole.press("esc");
    assert!(whole.model.screens.is_empty() && whole.model.jobs.has_batch());
    let other = write(folder.path(), "other.toml", &text);
    whole.model.experiment.chosen = Some(other);
    whole.press("space o e");
    assert_eq!(whole.model.experiment.file.as_ref(), Some(&file));
    assert!(toasts(&whole.model).contains("still being asked"));
    whole.press("x x");
    over(&mut whole).await;
    counted(&mut whole).await;
    let view = &whole.model.experiment;
    let [answered, failed, open_now, _] = view.progress.sums();
    assert_eq!((answered, failed), (1, 0));
    assert!(open_now > 0 && view.counted.as_ref().unwrap().batch.is_some());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_locked_test_split_shows_its_progress_alone() {
    let folder = tempfile::tempdir().unwrap();
    let text = "scenarios = [\"ZAM_CutIn-1_1_T-1\", \"ZAM_RedLight-1_1_T-1\", \"ZAM_Merge-1_1_T-1\", \"ZAM_Overtaking-1_1_T-1\"]\n\
        models = [\"reference/geometry\"]\nsplit = { test = 0.5, seed = 7 }\n";
    let file = write(folder.path(), "e.toml", text);
    let server = Server::start(Vec::new()).await;
    let mut whole = Whole::start(&server, "");
    open(&mut whole, &file).await;
    assert_eq!(problem(&whole), "");
    let split = whole.model.experiment.counted.as_ref().unwrap().split;
    let (dev, test) = split.unwrap();
    assert!(dev > 0 && test > 0 && dev + test == 4, "{split:?}");
    whole.press("p");
    assert_eq!(whole.model.experiment.part, Some(SplitPart::Dev));
    counted(&mut whole).await;
    let of_dev = whole.model.experiment.counted.as_ref().unwrap().free;
    whole.press("r y");
    over(&mut whole).await;
    counted(&mut whole).await;
    let view = &whole.model.experiment;
    assert_eq!(view.progress.sums()[0] as u64, of_dev);
    let lock = view.counted.as_ref().unwrap().test.join("\n");
    assert!(
        lock.contains("test split: 0 of") && lock.contains("locked"),
        "{lock}"
    );
    whole.press("p");
    counted(&mut whole).await;
    whole.press("enter");
    whole
        .until("the results", |model| !model.results.reading)
        .await;
    assert!(whole.model.results.rows.is_empty());
    assert!(whole.model.results.locked.is_some());
    whole.press("esc r y");
    over(&mut whole).await;
    counted(&mut whole).await;
    let lock = whole
        .model
        .experiment
        .counted
        .as_ref()
        .unwrap()
        .test
        .join("\n");
    assert!(!lock.contains("locked"), "{lock}");
    whole.press("enter");
    whole
        .until("the figures", |model| {
            !model.results.reading && !model.results.rows.is_empty()
        })
        .await;
}

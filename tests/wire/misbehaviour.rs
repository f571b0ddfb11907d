//! A server that misbehaves, a row each way: whatever it does, every question ends in time, with an answer or a
//! sentence that says what to do. What went wrong once becomes another row of the table.
#![allow(clippy::unwrap_used)]

mod endless;
mod library;
mod protocol;
mod streams;
use crate::support;
mod unstored;
mod usage;
#[cfg(unix)]
mod workbench;

use std::collections::BTreeSet;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use support::program::{Ended, Home};
use support::server::{Script, Server};
use tokio::sync::Semaphore;

const KEY: &str = "sk-test-0a1b2c3d4e5f6789";

const SCENARIO: &str = "ZAM_CutIn-1_1_T-1";

/// Seconds of silence, and in all, that the program waits for in these tests.
const IDLE: u64 = 1;
const TOTAL: u64 = 3;

/// How long a run may take on a busy machine: the limits above, and what the program itself needs.
const LIMIT: Duration = Duration::from_secs(TOTAL + 50);

/// Questions on their way at once, of all tests together.
const AT_ONCE: usize = 10;
static PLACES: OnceLock<Arc<Semaphore>> = OnceLock::new();

const MS: Duration = Duration::from_millis(1);

/// A way to misbehave.
struct Row {
    name: String,
    dialect: &'static str,
    script: Script,
    end: End,
}

/// How a question ends.
#[derive(Clone, Copy)]
enum End {
    /// With a verdict all the same.
    Verdict,
    /// Without one; this is said.
    Says(&'static str),
    /// In either way.
    Any,
}

fn row(name: &str, script: Script, end: End) -> Row {
    Row {
        name: name.to_string(),
        dialect: "openai_chat",
        script,
        end,
    }
}

/// What a model would say.
fn verdict() -> String {
    json!({
        "collision": true,
        "obstacles": [{"id": 301, "risk_score": 1, "reason": "close"}],
        "justification": "It cuts in.",
    })
    .to_string()
}

fn data(value: &Value) -> String {
    format!("data: {value}\n\n")
}

fn delta(text: &str) -> String {
    data(&json!({"model": "m", "choices": [{"index": 0, "delta": {"content": text}}]}))
}

fn usual() -> String {
    delta(&verdict()) + STOP + DONE
}

const STOP: &str =
    "data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"stop\"}]}\n\n";
const DONE: &str = "data: [DONE]\n\n";

fn table() -> Vec<Row> {
    let mut rows = usage::rows();
    rows.extend(protocol::rows());
    rows.extend(streams::rows());
    rows.extend(endless::rows());
    rows
}

/// Words of which one is in every sentence about a failure: they tell what to do.
const ADVICE: &[&str] = &[
    "check",
    "try again",
    "ask again",
    "raise",
    "set ",
    "change the",
    "ask again",
    "wait",
    "top it up",
    "choose",
    "ask for less",
    "no verdict",
];

fn configured(home: &Home, url: &str, dialect: &str) {
    let config = format!(
        "model = \"lab/m\"\n[provider.lab]\nbase_url = \"{url}\"\ndialect = \"{dialect}\"\nkey_env = \"LAB_KEY\"\n\
         models = [\"m\"]\nattempts = 1\nidle_timeout = {IDLE}\ntotal_timeout = {TOTAL}\n"
    );
    home.write(home.config().join("config.toml"), config);
}

/// Asks in one way and looks at what must hold whatever the server did.
fn ask(home: &Home, row: &str, more: &[&str]) -> Ended {
    let mut arguments = vec!["ask", SCENARIO, "--fresh"];
    arguments.extend(more);
    let begun = Instant::now();
    let ended = home.run_with(&arguments, &[("LAB_KEY", KEY)]);
    assert!(begun.elapsed() < LIMIT, "{row}: {:?}", begun.elapsed());
    let status = ended.status;
    assert!(matches!(status, Some(0 | 1)), "{row}: {ended:?}");
    for text in [&ended.stdout, &ended.stderr] {
        let raw = text
            .chars()
            .find(|c| c.is_control() && !matches!(c, '\n' | '\t'));
        assert_eq!(raw, None, "{row}: {text:?}");
        assert!(!text.contains(KEY), "{row}: {text}");
        assert!(text.len() < 12 << 20, "{row}: {} bytes", text.len());
    }
    if status == Some(1) {
        let last = ended.stderr.trim_end().lines().last().unwrap_or_default();
        let advised = ADVICE.iter().any(|word| last.contains(word));
        assert!(
            last.starts_with("nearmiss: ") && advised,
            "{row}: says `{last}`"
        );
        assert!(
            last.chars().count() < 2500,
            "{row}: says {} characters",
            last.len()
        );
    }
    ended
}

fn check(row: &Row, ended: &Ended) {
    match row.end {
        End::Verdict => assert_eq!(ended.status, Some(0), "{}: {ended:?}", row.name),
        End::Says(words) => {
            let said = ended.status == Some(1) && ended.stderr.contains(words);
            assert!(said, "{}: not `{words}`: {}", row.name, ended.stderr);
        }
        End::Any => {}
    }
}

/// Asks for words and for JSON; then nothing on the disk holds the key.
fn run(row: &Row, url: &str) {
    let home = Home::new();
    configured(&home, url, row.dialect);
    check(row, &ask(&home, &row.name, &[]));
    let ended = ask(&home, &row.name, &["--format=json"]);
    check(row, &ended);
    assert_eq!(ended.json()["model"], "lab/m", "{}", row.name);
    let found = home.files_with(KEY);
    assert!(found.is_empty(), "{}: the key is in {found:?}", row.name);
    assert_eq!(home.runs().len(), 2, "{}: each is kept", row.name);
}

/// Plays each row that is chosen, by its number, to `ask`, which is given the row and the server's address.
///
/// `NEARMISS_ROW` narrows them to those whose name holds it.
async fn play(chosen: impl Fn(usize) -> bool, ask: fn(&Row, &str)) {
    let wanted = std::env::var("NEARMISS_ROW").unwrap_or_default();
    let rows: Arc<Vec<Row>> = Arc::new(table());
    let scripts: Vec<Script> = rows.iter().map(|row| row.script.clone()).collect();
    let server = Server::answering(move |_, request| {
        let number = request.path.split('/').nth(1)?.parse::<usize>().ok()?;
        scripts.get(number).cloned()
    })
    .await;
    let places = PLACES.get_or_init(|| Arc::new(Semaphore::new(AT_ONCE)));
    let mut going = Vec::new();
    for number in 0..rows.len() {
        if !chosen(number) || !rows[number].name.contains(&wanted) {
            continue;
        }
        let (rows, places) = (Arc::clone(&rows), Arc::clone(places));
        let url = format!("{}/{number}/v1", server.base_url());
        going.push(tokio::spawn(async move {
            let _place = places.acquire_owned().await.unwrap();
            let asked = tokio::task::spawn_blocking(move || ask(&rows[number], &url));
            asked.await.map_err(|failed| {
                let words = failed.into_panic().downcast::<String>();
                format!(
                    "row {number}: {}",
                    words.map_or_else(|_| "failed".into(), |w| *w)
                )
            })
        }));
    }
    let mut failed = Vec::new();
    for one in going {
        failed.extend(one.await.unwrap().err());
    }
    assert!(
        failed.is_empty(),
        "{} rows:\n{}",
        failed.len(),
        failed.join("\n")
    );
}

#[test]
fn each_row_has_its_own_name() {
    let rows = table();
    let names: BTreeSet<&str> = rows.iter().map(|row| row.name.as_str()).collect();
    assert_eq!(names.len(), rows.len());
    assert!(rows.len() >= 100, "{} rows", rows.len());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_question_ends_in_time_with_an_answer_or_advice() {
    play(|_| true, run).await;
}

/// One row of five as a rule, as each takes seconds; `NEARMISS_EVERY_ROW` tries them all.
#[cfg(unix)]
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_workbench_survives_them_too() {
    let all = ["NEARMISS_EVERY_ROW", "NEARMISS_ROW"].map(std::env::var_os);
    let every = all.iter().any(Option::is_some);
    play(|number| every || number % 5 == 0, workbench::run).await;
}

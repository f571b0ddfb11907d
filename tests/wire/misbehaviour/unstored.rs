//! A store that fails while an answer arrives: the answer is printed, kept in a file, taken in later, and not paid
//! twice.

use std::time::Duration;

use super::support::program::{Ended, Home};
use super::support::server::{Script, Server};
use super::{DONE, KEY, STOP, delta, usual, verdict};

const SCENARIOS: [&str; 3] = [
    "ZAM_CutIn-1_1_T-1",
    "ZAM_HardBraking-1_1_T-1",
    "ZAM_RedLight-1_1_T-1",
];

/// Questions about them: each collision has a window of its own in the safe scenario.
const QUESTIONS: usize = 4;

fn home(url: &str) -> Home {
    let home = Home::new();
    let config = format!(
        "[provider.lab]\nbase_url = \"{url}\"\nkey_env = \"LAB_KEY\"\nattempts = 1\nconcurrency = 1\n"
    );
    home.write(home.config().join("config.toml"), config);
    // An empty store, which the tests break.
    nearmiss::store::Store::open(&home.data().join("runs.sqlite")).unwrap();
    home
}

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run_with(arguments, &[("LAB_KEY", KEY)]))
}

fn execute(home: &Home, sql: &str) {
    let store = rusqlite::Connection::open(home.data().join("runs.sqlite")).unwrap();
    store.busy_timeout(Duration::from_secs(5)).unwrap();
    store.execute_batch(sql).unwrap();
}

/// From now on nothing that arrives can be written, as on a full disk; questions can.
fn fill(home: &Home) {
    execute(
        home,
        "CREATE TRIGGER full_1 BEFORE INSERT ON pieces BEGIN SELECT RAISE(ABORT, 'database or disk is full'); END;
         CREATE TRIGGER full_2 BEFORE UPDATE OF state ON runs WHEN NEW.state NOT IN ('running', 'interrupted')
             BEGIN SELECT RAISE(ABORT, 'database or disk is full'); END;",
    );
}

fn make_room(home: &Home) {
    execute(home, "DROP TRIGGER full_1; DROP TRIGGER full_2;");
}

fn set_aside(home: &Home) -> usize {
    let files = std::fs::read_dir(home.data()).unwrap().flatten();
    let names = files.map(|file| file.file_name().to_string_lossy().into_owned());
    names.filter(|name| name.starts_with("unstored-")).count()
}

const ASK: [&str; 4] = ["ask", SCENARIOS[0], "--model", "lab/m"];

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_answer_that_cannot_be_stored_is_printed_and_taken_in_later() {
    let script = Script::events()
        .send(delta("Let me see. "))
        .pause(Duration::from_millis(200))
        .send(delta(&verdict()))
        .send(STOP.to_string() + DONE);
    let server = Server::start(vec![script]).await;
    let home = home(server.base_url());
    fill(&home);
    let ended = run(&home, &ASK).status(2);
    let words = [
        "could not be stored",
        "disk is full",
        "unstored-",
        "imported when",
    ];
    let ended = ended.says(&words);
    assert!(
        ended.stdout.contains("collision (lab/m)"),
        "{}",
        ended.stdout
    );
    assert_eq!(set_aside(&home), 1);
    assert!(home.files_with(KEY).is_empty());

    make_room(&home);
    let ended = run(&home, &ASK).status(0);
    assert!(ended.stdout.contains("from the store"), "{}", ended.stdout);
    assert_eq!((server.requests().len(), set_aside(&home)), (1, 0));
    let runs = home.runs();
    assert_eq!(runs.len(), 1);
    let answer = format!("Let me see. {}", verdict());
    assert_eq!(runs[0]["answer"].as_deref(), Some(answer.as_str()));
    assert_eq!(runs[0]["state"].as_deref(), Some("answered"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn json_of_an_answer_that_cannot_be_stored_is_whole() {
    let server = Server::start(vec![Script::events().send(usual())]).await;
    let home = home(server.base_url());
    fill(&home);
    let ended = run(&home, &[&ASK[..], &["--format=json"]].concat()).status(2);
    assert_eq!(ended.json()["verdict"]["collision"], true);
    assert_eq!(ended.json()["run"], serde_json::Value::Null);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_store_that_is_locked_for_long_costs_no_answer() {
    let folder = std::sync::Arc::new(std::sync::Mutex::new(std::path::PathBuf::new()));
    let lock = std::sync::Mutex::new(None);
    let store = std::sync::Arc::clone(&folder);
    let server = Server::answering(move |_, _| {
        // From the moment at which the question arrives.
        let connection = rusqlite::Connection::open(&*store.lock().unwrap()).unwrap();
        connection.execute_batch("BEGIN IMMEDIATE").unwrap();
        *lock.lock().unwrap() = Some(connection);
        Some(Script::events().send(usual()))
    })
    .await;
    let home = home(server.base_url());
    *folder.lock().unwrap() = home.data().join("runs.sqlite");
    let ended = run(&home, &ASK)
        .status(2)
        .says(&["could not be stored", "locked", "unstored-"]);
    assert!(
        ended.stdout.contains("collision (lab/m)"),
        "{}",
        ended.stdout
    );
    drop(server);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_batch_stops_at_a_store_that_fails_and_pays_for_nothing_twice() {
    let server = Server::answering(|_, _| Some(Script::events().send(usual()))).await;
    let home = home(server.base_url());
    fill(&home);
    let begin = [
        &["evaluate"],
        &SCENARIOS[..],
        &["--model", "lab/m", "--task", "collision"],
    ]
    .concat();
    let ended = run(&home, &begin).status(2);
    ended.says(&["could not be stored", "disk is full", "unstored-"]);
    let asked = server.requests().len();
    assert_eq!(asked, 1, "nothing more is asked");
    assert_eq!(set_aside(&home), asked);
    make_room(&home);
    run(&home, &["evaluate", "last"]).status(0);
    assert_eq!(server.requests().len(), QUESTIONS, "nothing is paid twice");
    assert_eq!(set_aside(&home), 0);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_was_deleted_is_asked_again_by_resume() {
    let server = Server::answering(|_, _| Some(Script::events().send(usual()))).await;
    let home = home(server.base_url());
    let begin = [
        &["evaluate"],
        &SCENARIOS[..],
        &["--model", "lab/m", "--task", "collision"],
    ]
    .concat();
    run(&home, &begin).status(0);
    run(&home, &["runs", "delete", "2"]).status(0);
    run(&home, &["evaluate", "last"]).status(0);
    assert_eq!(server.requests().len(), QUESTIONS + 1);
    run(&home, &["evaluate", "last"])
        .status(0)
        .says(&["nothing to ask"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_answer_is_cut_off_at_its_limit_and_says_so() {
    let endless = || Script::events().endless(delta(&"so ".repeat(4000)), Duration::ZERO);
    let server = Server::answering(move |_, _| Some(endless())).await;
    let home = home(server.base_url());
    let words = ["nearmiss cut the answer off", "4 MiB", "max_tokens"];
    run(&home, &ASK).status(1).says(&words);
    let ended = run(&home, &[&ASK[..], &["--format=json"]].concat())
        .status(1)
        .says(&words);
    let document = ended.json();
    let cut = |text: &serde_json::Value| text.as_str().is_some_and(|t| t.contains(words[0]));
    assert!(cut(&document["cut_off"]) && cut(&document["problem"]));
    for run in home.runs() {
        assert_eq!(run["answer"].as_ref().map(String::len), Some(4 << 20));
        let ended = (run["state"].as_deref(), run["finish"].as_deref());
        assert_eq!(ended, (Some("truncated"), Some("too_long")));
    }
    let begin = [
        "evaluate",
        SCENARIOS[1],
        "--model",
        "lab/m",
        "--task",
        "collision",
    ];
    run(&home, &begin).status(1).says(&words[..2]);
    assert_eq!(server.requests().len(), 3);
    run(&home, &["evaluate", "last"]);
    assert_eq!(server.requests().len(), 3, "it would be cut off again");
}

#[cfg(unix)]
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_endless_stream_obeys_an_interrupt() {
    for filler in ["\n", "data: {}\n\n"] {
        let slow = filler.repeat(1 << 15);
        let script = Script::events().endless(slow, Duration::from_millis(20));
        let server = Server::start(vec![script]).await;
        let home = home(server.base_url());
        let mut command = home.command();
        let mut child = command.args(ASK).env("LAB_KEY", KEY).spawn().unwrap();
        while server.requests().is_empty() {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
        tokio::time::sleep(Duration::from_millis(500)).await;
        let id = child.id().to_string();
        std::process::Command::new("kill")
            .args(["-INT", &id])
            .status()
            .unwrap();
        let begun = std::time::Instant::now();
        let status = tokio::task::block_in_place(|| child.wait().unwrap());
        assert_eq!(status.code(), Some(130), "{filler:?}");
        assert!(
            begun.elapsed() < Duration::from_secs(8),
            "{:?}",
            begun.elapsed()
        );
    }
}

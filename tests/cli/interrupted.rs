//! An answer that is paid for is in the store, however the program ends.

use std::time::{Duration, Instant};

use nearmiss::store::{LEASE, RunId, RunState, Store};

use super::CUT_IN;
use super::remote::delta;
use super::support::program::{Ended, Home};
use super::support::server::{Script, Server};

const SAID: [&str; 3] = ["The car in front ", "brakes — 車 — ", "and then"];

/// Starts a question whose answer stops half-way, and waits until all that was said is in the store.
async fn half_an_answer(home: &Home) -> (Server, std::process::Child) {
    let script = SAID
        .iter()
        .fold(Script::chunked_events(), |s, text| s.chunk(delta(text)));
    let server = Server::start(vec![script.await_close()]).await;
    let arguments = [
        "ask",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--base-url",
        server.base_url(),
        "--json",
    ];
    let child = home.start(&arguments);
    let begun = Instant::now();
    let kept = || {
        let rows = home.rows("SELECT text FROM pieces ORDER BY id");
        rows.iter()
            .filter_map(|row| row["text"].clone())
            .collect::<String>()
    };
    while kept() != SAID.concat() {
        assert!(
            begun.elapsed() < Duration::from_secs(20),
            "only `{}` is in the store",
            kept()
        );
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    (server, child)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_arrived_before_a_kill_is_in_the_store() {
    let home = Home::new();
    let (_server, mut child) = half_an_answer(&home).await;
    child.kill().unwrap();
    let status = tokio::task::block_in_place(|| child.wait()).unwrap();
    assert_eq!(status.code(), None, "killed");
    assert_eq!(home.runs()[0]["state"].as_deref(), Some("running"));
    let killed = || {
        let store = Store::open(&home.data().join("runs.sqlite")).unwrap();
        store.run(RunId(1)).unwrap().expect("the run is there")
    };
    assert_eq!(killed().answer, SAID.concat());
    // Nobody renews its claim.
    let begun = Instant::now();
    while killed().ending.state != RunState::Interrupted {
        assert!(begun.elapsed() < LEASE + Duration::from_secs(20));
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    assert_eq!(killed().answer, SAID.concat());
    let shown = tokio::task::block_in_place(|| home.run(&["runs", "show", "1"]).status(0).stdout);
    assert!(
        shown.contains("interrupted") && shown.contains(&SAID.concat()),
        "{shown}"
    );
    // The next question is not disturbed by it.
    tokio::task::block_in_place(|| home.run(&["ask", CUT_IN]).status(0));
    assert_eq!(home.runs().len(), 2);
}

#[cfg(unix)]
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_interrupt_closes_the_connection_and_is_written_down() {
    let home = Home::new();
    let (server, child) = half_an_answer(&home).await;
    let id = child.id().to_string();
    let sent = std::process::Command::new("kill")
        .args(["-INT", &id])
        .status()
        .unwrap();
    assert!(sent.success());
    let output = tokio::task::block_in_place(|| child.wait_with_output()).unwrap();
    let ended =
        Ended::of(&output)
            .status(130)
            .says(&["interrupted", "in the store", "runs show 1"]);
    assert_eq!(ended.stdout, "");
    assert!(server.seen_close().await);
    let runs = home.runs();
    assert_eq!(runs[0]["state"].as_deref(), Some("cancelled"));
    assert_eq!(runs[0]["answer"], Some(SAID.concat()));
}

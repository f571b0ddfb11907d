//! A store that an older version wrote: what is in it can be read, reported and completed.
//!
//! `older_store.sqlite` was written by the program of commit 25e682e: a question to a model (run 1), a batch of two
//! questions of which the second was refused (runs 2 and 3), and a question to the built-in judge (run 4).

use super::batches::telling;
use super::support::program::Home;
use super::support::server::Server;

const STORE: &[u8] = include_bytes!("older_store.sqlite");

/// A user with this store, and a provider `lab` at `url`.
fn home(url: &str) -> Home {
    let home = super::batches::home(url);
    std::fs::create_dir_all(home.data()).unwrap();
    std::fs::write(home.data().join("runs.sqlite"), STORE).unwrap();
    home
}

#[test]
fn its_runs_are_listed_shown_and_exported() {
    let home = home("http://127.0.0.1:9/v1");
    let listed = home.run(&["runs", "list"]).status(0).stdout;
    for words in ["lab/tiny", "reference/geometry", "failed"] {
        assert!(listed.contains(words), "{words}: {listed}");
    }
    let shown = home
        .run(&["runs", "show", "1", "--format=json"])
        .status(0)
        .json();
    assert_eq!(shown["model"], "lab/tiny");
    assert_eq!(shown["input_tokens"], 900);
    assert!(
        shown["answer"].as_str().unwrap().contains("keeps its lane"),
        "{shown}"
    );
    let exported = home
        .run(&["runs", "export", "--format", "jsonl"])
        .status(0)
        .stdout;
    let runs = exported
        .lines()
        .filter(|line| line.contains("\"nearmiss_run\""));
    assert_eq!(runs.count(), 4, "{exported}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn its_batch_is_reported_and_not_mixed_with_other_templates() {
    let server = Server::answering(|_, _| {
        Some(telling(
            r#"{"collision": false, "obstacles": [], "justification": "no contact"}"#,
        ))
    })
    .await;
    let home = home(server.base_url());
    let run = |arguments: &[&str]| tokio::task::block_in_place(|| home.run(arguments).status(0));
    let listed = run(&["evaluate", "list"]).stdout;
    assert!(listed.contains("1 of 2 answered, 1 failed"), "{listed}");
    let cells = |answered: &serde_json::Value| {
        let cells = answered["cells"].as_array().unwrap().clone();
        let all = cells
            .into_iter()
            .find(|cell| cell["label"] == "all")
            .unwrap();
        ["tn", "fn", "failed"].map(|count| all[count].as_u64().unwrap())
    };
    let before = run(&["report", "--batch", "b1", "--format=json"]).json();
    assert_eq!(cells(&before), [1, 0, 1]);
    // It pins its template, which is not the one of today: what was answered must not be mixed with other questions.
    let resume = ["evaluate", "b1"];
    tokio::task::block_in_place(|| home.run(&resume))
        .status(2)
        .says(&["collision-ego.md", "start a new batch"]);
    assert_eq!(server.requests().len(), 0);
    let after = run(&["report", "--batch", "b1", "--format=json"]).json();
    assert_eq!(cells(&after), [1, 0, 1], "nothing is lost");
}

//! A store that an older version wrote: what is in it can be read, reported and completed.
//!
//! `older_store.sqlite` was written by the program of commit 292b2450: a question to a model (run 1), a batch of two
//! questions with a template of the user's own, of which the second was refused (runs 2 and 3), and a question to the
//! built-in judge (run 4).

use super::CUT_IN;
use super::batches::telling;
use super::support::program::Home;
use super::support::server::Server;

const STORE: &[u8] = include_bytes!("older_store.sqlite");

/// What `export` wrote before records had one name for each thing, commit 987d6972: a batch of one question to a model,
/// its run, and a run of the built-in judge.
const EXPORT: &str = include_str!("older_export.jsonl");

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
    assert_eq!(shown["input_tokens"], 4000);
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

#[test]
fn its_tables_are_those_of_a_new_store() {
    let home = home("http://127.0.0.1:9/v1");
    // It is brought to the newest version when it is opened.
    home.run(&["runs", "list"]).status(0);
    let new = super::batches::home("http://127.0.0.1:9/v1");
    new.run(&["ask", CUT_IN, "--model", "reference/geometry"])
        .status(0);
    let columns = |home: &Home| {
        let store = rusqlite::Connection::open(home.data().join("runs.sqlite")).unwrap();
        let all = "SELECT m.type, m.name, c.name, c.type, c.\"notnull\", c.pk, c.hidden FROM sqlite_schema m
            LEFT JOIN pragma_table_xinfo(m.name) c ORDER BY m.name, c.cid";
        let mut rows = store.prepare(all).unwrap();
        let words = |row: &rusqlite::Row<'_>| {
            let value = |at| row.get::<_, rusqlite::types::Value>(at);
            (0..7).map(value).collect::<Result<Vec<_>, _>>()
        };
        let found = rows.query_map([], words).unwrap();
        found.collect::<Result<Vec<_>, _>>().unwrap()
    };
    assert_eq!(columns(&home), columns(&new));
}

#[test]
fn an_older_export_is_imported_once_and_written_anew() {
    let home = super::batches::home("http://127.0.0.1:9/v1");
    home.write("older.jsonl", EXPORT);
    home.write("wrong.jsonl", EXPORT.replace("You read", "You see"));
    home.run(&["runs", "import", "wrong.jsonl"])
        .status(1)
        .says(&["the line was changed"]);
    let counts = home
        .run(&["runs", "import", "older.jsonl"])
        .status(0)
        .stdout;
    let known = "1 imported, 1 already in the store, 0 unreadable\n";
    assert_eq!(counts, known, "that of the built-in judge was right");
    let shown = home
        .run(&["runs", "list", "--format=json"])
        .status(0)
        .stdout;
    let runs = shown
        .lines()
        .map(|line| serde_json::from_str(line).unwrap());
    let runs: Vec<serde_json::Value> = runs.collect();
    let of_model = runs.iter().find(|run| run["model"] == "lab/tiny").unwrap();
    assert_eq!(
        (&of_model["dangerous"], &of_model["answer_state"]),
        (&false.into(), &"answered".into())
    );
    let report = home
        .run(&["report", "--batch", "b1", "--format=json"])
        .status(0);
    assert_eq!(report.json()["cells"][0]["fn"], 1);
    let written = home.run(&["runs", "export"]).status(0).stdout;
    let other = super::batches::home("http://127.0.0.1:9/v1");
    other.write("newer.jsonl", &written);
    let counts = other
        .run(&["runs", "import", "newer.jsonl"])
        .status(0)
        .stdout;
    assert_eq!(counts, "2 imported, 0 already in the store, 0 unreadable\n");
    let again = other.run(&["runs", "export"]).status(0).stdout;
    let without_origin = |text: &str| text.replace("\"asked\"", "\"replayed\"");
    assert_eq!(without_origin(&again), without_origin(&written));
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
    // It pins its template, which this user does not have: what was answered must not be mixed with other questions.
    let resume = ["evaluate", "b1"];
    tokio::task::block_in_place(|| home.run(&resume))
        .status(2)
        .says(&["collision-ego.md", "start a new batch"]);
    assert_eq!(server.requests().len(), 0);
    let after = run(&["report", "--batch", "b1", "--format=json"]).json();
    assert_eq!(cells(&after), [1, 0, 1], "nothing is lost");
}

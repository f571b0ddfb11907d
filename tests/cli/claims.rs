//! Claims of answers as a measure: counted when an answer is stored, or by the next report that finds the scenario.

use nearmiss::formats::bundled;
use nearmiss::store::{ClaimCounts, Filter, Store};
use serde_json::{Value, json};

use super::CUT_IN;
use super::batches::{home as home_with, telling};
use super::support::program::{Ended, Home};
use super::support::server::Server;

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

fn cell(report: &Value) -> &Value {
    let cells = report["cells"].as_array().unwrap();
    let whole = |cell: &&Value| cell["label"] == "all" && cell["model"] == "lab/tiny";
    cells.iter().find(whole).unwrap()
}

fn counts(cell: &Value) -> Vec<Option<u64>> {
    let names = [
        "claims_of",
        "claims_unchecked",
        "claims_right",
        "claims_wrong",
        "claims_open",
        "claims_invented",
        "sentences",
        "sentences_contradictory",
    ];
    names.map(|name| cell[name].as_u64()).to_vec()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn claims_are_counted_in_reports_exports_and_of_older_answers() {
    let entry = bundled().into_iter().find(|e| e.name == CUT_IN).unwrap();
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
    let moving = scenario
        .obstacles
        .iter()
        .find(|o| o.id != ego.id)
        .unwrap()
        .id;
    // Both are wrong: it drives, and nobody is touched.
    let words = format!(
        "Obstacle {moving} is stationary. Obstacle {moving} has collided with the ego vehicle."
    );
    let said = json!({"justification": words, "obstacles": [], "collision": false}).to_string();
    let server = Server::answering(move |_, _| Some(telling(&said))).await;
    let home = home_with(server.base_url());
    let asked = [
        "--model",
        "lab/tiny",
        "--task",
        "collision",
        "--samples",
        "2",
    ];
    run(&home, &[&["evaluate", CUT_IN], &asked[..]].concat()).status(0);
    let report = |more: &[&str]| {
        run(&home, &[&["report", "--format=json"], more].concat())
            .status(0)
            .json()
    };
    let all = vec![
        Some(2),
        Some(0),
        Some(0),
        Some(4),
        Some(0),
        Some(0),
        Some(4),
        // "Has collided", and `"collision": false`.
        Some(2),
    ];
    for more in [&[][..], &["--batch", "b1"]] {
        let report = report(more);
        let cell = cell(&report);
        assert_eq!(counts(cell), all, "{cell}");
        assert_eq!(cell["claims_wrong_share"], 1.0);
        assert_eq!(cell["claims_per_answer"], 2.0);
    }
    let table = run(&home, &["report", "--batch", "b1"]).status(0).stdout;
    assert!(table.contains("Claims about obstacles"), "{table}");
    let exported = run(&home, &["runs", "export", "--format", "csv"])
        .status(0)
        .stdout;
    assert!(exported.lines().next().unwrap().contains("claims_wrong"));
    // As an older version left them: not checked, and so not 0.
    let file = home.data().join("runs.sqlite");
    let unchecked = || {
        let store = Store::open(&file).unwrap();
        let runs = store.outcomes(&Filter::default()).unwrap();
        let none = runs.iter().map(|one| (one.run, ClaimCounts::default()));
        store.keep_claims(&none.collect::<Vec<_>>()).unwrap();
    };
    unchecked();
    let shown = |run: &str| -> Value {
        self::run(&home, &["runs", "show", run, "--format=json"])
            .status(0)
            .json()
    };
    assert!(shown("1")["claims_wrong"].is_null());
    assert_eq!(counts(cell(&report(&["--batch", "b1"]))), all);
    assert_eq!(shown("1")["claims_wrong"], 2, "they are kept");
    unchecked();
    assert_eq!(counts(cell(&report(&[]))), all);
}

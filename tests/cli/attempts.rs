//! Every attempt at a question counts once and is paid for once: in reports, in lists, on the screen of results, in
//! exports, and after an import.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use nearmiss::evaluation::batch::{BatchPart, counted};
use nearmiss::evaluation::report::{Truth, stored};
use nearmiss::evaluation::{Outcome, Results, results};
use nearmiss::store::{BatchId, Filter, Store};
use serde_json::{Value, json};

use super::BUNDLED;
use super::remote::delta;
use super::support::program::{Ended, Home};
use super::support::server::{Script, Server};

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

/// A streamed answer that ends for this reason, with its tokens.
fn ended(text: &str, reason: &str, tokens: u32) -> Script {
    let finish =
        json!({"choices": [{"index": 0, "delta": {}, "finish_reason": reason}]}).to_string();
    let usage =
        json!({"choices": [], "usage": {"prompt_tokens": 9000, "completion_tokens": tokens}});
    let text = match text {
        "" => Script::chunked_events(),
        text => Script::chunked_events().chunk(delta(text)),
    };
    text.chunk(format!("data: {finish}\n\n"))
        .chunk(format!("data: {usage}\n\n"))
        .chunk("data: [DONE]\n\n")
        .end_of_chunks()
}

const SAYS: &str = r#"{"collision": true, "obstacles": [], "justification": "so"}"#;

/// What becomes of the n-th question at first; later every question has a whole answer.
fn at_first(question: usize) -> Script {
    match question {
        0 => Script::answer(429, &[("Retry-After", "0")], "{}"),
        2 => Script::answer(500, &[], "{}"),
        4 => Script::chunked_events().chunk(delta(SAYS)),
        5 => ended(SAYS, "length", 50),
        6 => ended(SAYS, "content_filter", 60),
        7 => ended("", "stop", 70),
        n => ended(SAYS, "stop", 100 + n as u32),
    }
}

async fn server(better: Arc<AtomicBool>) -> Server {
    let seen: Mutex<Vec<Vec<u8>>> = Mutex::default();
    Server::answering(move |_, request| {
        if better.load(Ordering::Relaxed) {
            return Some(ended(SAYS, "stop", 10));
        }
        let mut seen = seen.lock().unwrap();
        let place = seen
            .iter()
            .position(|body| *body == request.body)
            .unwrap_or_else(|| {
                seen.push(request.body.clone());
                seen.len() - 1
            });
        Some(at_first(place))
    })
    .await
}

fn home(url: &str) -> Home {
    let home = Home::new();
    let config = format!(
        "[provider.lab]\nbase_url = \"{url}\"\nkey_env = []\nconcurrency = 1\n\
         [[provider.lab.prices]]\nmodel = \"tiny\"\ninput = 1\noutput = 1000\n"
    );
    home.write(home.config().join("config.toml"), config);
    home
}

/// The cell of all answers.
fn whole(home: &Home, arguments: &[&str]) -> Value {
    let report = run(home, &[&["report", "--format=json"], arguments].concat())
        .status(0)
        .json();
    let cells = report["cells"].as_array().unwrap();
    let all = cells.iter().find(|cell| cell["label"] == "all");
    all.unwrap().clone()
}

const COUNTS: [&str; 7] = ["tp", "fp", "fn", "tn", "unparsed", "failed", "unasked"];

/// Counts and costs, dollars in millionths.
fn figures(cell: &Value) -> BTreeMap<String, i64> {
    let costs = ["cost_usd", "cost_unknown_most_usd"];
    let counts = COUNTS
        .iter()
        .chain(&[
            "cost_unknown",
            "superseded",
            "input_tokens",
            "output_tokens",
        ])
        .map(|name| (name.to_string(), cell[*name].as_i64().unwrap_or(0)));
    let micro = |name: &&str| (cell[*name].as_f64().unwrap_or(0.0) * 1e6).round() as i64;
    let costs = costs.iter().map(|name| (name.to_string(), micro(name)));
    counts.chain(costs).collect()
}

fn lines(text: &str) -> Vec<Value> {
    let lines = text.lines().map(|line| serde_json::from_str(line).unwrap());
    lines.collect()
}

/// The same figures as the screen of results has, of the whole store and of the batch.
fn on_screen(home: &Home) -> [Vec<i64>; 2] {
    let store = Store::open_to_read(&home.data().join("runs.sqlite")).unwrap();
    let outcomes = store.outcomes(&Filter::default()).unwrap();
    let mut truth = Truth::default();
    let labels = nearmiss::workflow::batch_labels(&store).unwrap();
    (truth.windows, truth.of_batches) = (labels.windows, labels.all);
    let everything = stored(&outcomes, &truth, &store.asides().unwrap());
    let stop = AtomicBool::new(false);
    let batch = counted(&store, BatchId(1), BatchPart::Plain, None, &stop);
    let rows = [results(&everything.scored), batch.unwrap().unwrap().rows];
    rows.map(|rows| match rows.as_slice() {
        [row] => screen_figures(row),
        rows => panic!("{rows:?}"),
    })
}

fn screen_figures(row: &Results) -> Vec<i64> {
    let [tp, fp, missed, tn, _, unparsed, failed] =
        Outcome::ALL.map(|outcome| i64::from(row.count(outcome)));
    let micro = |usd: Option<f64>| (usd.unwrap_or(0.0) * 1e6).round() as i64;
    let of = &row.spending;
    let costs = [micro(of.cost()), micro(of.most()), i64::from(of.unpriced())];
    [&[tp, fp, missed, tn, unparsed, failed][..], &costs].concat()
}

/// Holds every table against the report of the batch.
fn agree(home: &Home) -> BTreeMap<String, i64> {
    let batch = figures(&whole(home, &["--batch", "b1"]));
    assert_eq!(figures(&whole(home, &[])), batch, "report");
    let runs = lines(
        &run(home, &["runs", "list", "--format=json", "-n", "1000"])
            .status(0)
            .stdout,
    );
    let dollars = |name: &str, of: &dyn Fn(&Value) -> bool| {
        let some = runs.iter().filter(|run| of(run));
        let usd: f64 = some.filter_map(|run| run[name].as_f64()).sum();
        (usd * 1e6).round() as i64
    };
    let unpriced = |run: &Value| run["cost_usd"].is_null() && run["most_usd"] != 0.0;
    assert_eq!(dollars("cost_usd", &|_| true), batch["cost_usd"]);
    assert_eq!(
        dollars("most_usd", &unpriced),
        batch["cost_unknown_most_usd"]
    );
    assert_eq!(
        runs.iter().filter(|run| unpriced(run)).count() as i64,
        batch["cost_unknown"]
    );
    let states = |names: &[&str]| {
        let is = |run: &&Value| names.contains(&run["answer_state"].as_str().unwrap());
        runs.iter().filter(is).count() as i64
    };
    let said: i64 = ["tp", "fp", "fn", "tn"]
        .iter()
        .map(|name| batch[*name])
        .sum();
    assert_eq!(states(&["answered"]), said);
    assert_eq!(states(&["unparsed"]), batch["unparsed"]);
    assert_eq!(
        states(&["truncated", "filtered", "failed"]),
        batch["failed"]
    );
    assert_eq!(states(&["superseded"]), batch["superseded"]);
    let wanted = [
        "tp",
        "fp",
        "fn",
        "tn",
        "unparsed",
        "failed",
        "cost_usd",
        "cost_unknown_most_usd",
        "cost_unknown",
    ];
    let wanted: Vec<i64> = wanted.iter().map(|name| batch[*name]).collect();
    assert_eq!(
        on_screen(home),
        [wanted.clone(), wanted],
        "the screen of results"
    );
    let exported = lines(&run(home, &["runs", "export"]).status(0).stdout);
    let exported: Vec<&Value> = exported
        .iter()
        .filter(|line| line["nearmiss_run"].is_number())
        .collect();
    let by_run = |all: &[&Value]| -> BTreeMap<i64, (Value, Value, Value)> {
        let one = |run: &&Value| {
            let figures = (
                run["answer_state"].clone(),
                run["cost_usd"].clone(),
                run["most_usd"].clone(),
            );
            (run["run"].as_i64().unwrap(), figures)
        };
        all.iter().map(one).collect()
    };
    assert_eq!(
        by_run(&exported),
        by_run(&runs.iter().collect::<Vec<_>>()),
        "export"
    );
    batch
}

/// The tables of a store, as people read them.
fn tables(home: &Home) -> [String; 3] {
    [
        &["report"][..],
        &["report", "--batch", "b1"],
        &["report", "--batch", "b1", "--format", "html"],
    ]
    .map(|arguments| run(home, arguments).status(0).stdout)
}

/// Labels after which half of the bundled scenarios collide, so that each has a window.
fn four_and_four(home: &Home) -> String {
    let mut rows = BUNDLED;
    rows.sort_by_key(|(_, collides)| !collides);
    let rows = rows.iter().enumerate();
    let rows: String = rows
        .map(|(place, (name, _))| format!("{name},{}\n", u8::from(place < BUNDLED.len() / 2)))
        .collect();
    let file = home.write("truth.csv", format!("scenario,label\n{rows}"));
    file.display().to_string()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_table_agrees_to_the_answer_and_to_the_cent_also_after_an_import() {
    let better = Arc::new(AtomicBool::new(false));
    let server = server(Arc::clone(&better)).await;
    let home = home(server.base_url());
    let names = BUNDLED.map(|(name, _)| name);
    assert!(names.len() >= 8);
    let asked = [
        "--model",
        "lab/tiny",
        "--task",
        "collision",
        "--set",
        "max_tokens=200",
        "--truth",
        &four_and_four(&home),
    ];
    run(&home, &[&["evaluate"], &names[..], &asked].concat()).status(1);
    let first = agree(&home);
    // 429, 500 and the broken stream; the cut, the filtered and the blank answer.
    assert_eq!((first["failed"], first["unasked"]), (6, 0), "{first:?}");
    // 1, 3 and those from 8 on are whole; all but the first three attempts have tokens.
    assert_eq!(first["cost_unknown"], 3, "{first:?}");
    assert!(first["cost_unknown_most_usd"] > 0, "{first:?}");
    let cut = run(&home, &["runs", "list"]).status(0).stdout;
    assert!(
        cut.contains("truncated") && cut.contains("filtered"),
        "{cut}"
    );
    better.store(true, Ordering::Relaxed);
    run(&home, &["evaluate", "b1", "--retry-failed"]).status(0);
    let second = agree(&home);
    assert_eq!(
        (second["failed"], second["superseded"]),
        (0, 6),
        "{second:?}"
    );
    // Six more of 9000 and 10 tokens at a millionth and a thousandth of a dollar.
    assert_eq!(
        second["cost_usd"] - first["cost_usd"],
        6 * (9000 + 10_000),
        "{second:?}"
    );
    assert_eq!(second["cost_unknown"], 3, "{second:?}");

    let file = home.files().join("all.jsonl");
    run(&home, &["runs", "export", "-o", file.to_str().unwrap()]).status(0);
    let other = Home::new();
    let file = file.to_str().unwrap();
    run(&other, &["runs", "import", file])
        .status(0)
        .says(&["1 new batch"]);
    agree(&other);
    assert_eq!(tables(&other), tables(&home));
    let again = run(&other, &["runs", "import", file, "--format=json"])
        .status(0)
        .json();
    assert_eq!(again["imported"], 0, "each once");
    assert_eq!(tables(&other), tables(&home));
    let listed = |batch: &str| {
        run(&home, &["runs", "list", "--batch", batch])
            .status(0)
            .stdout
    };
    assert_eq!(listed("last"), listed("b1"));
    run(&Home::new(), &["runs", "list", "--batch", "last"])
        .status(2)
        .says(&["no batch yet"]);
    for command in ["list", "export"] {
        run(&home, &["runs", command, "--batch", "b9"])
            .status(2)
            .says(&["no batch b9;"]);
    }
    // The batch alone is the same.
    let alone = home.files().join("b1.jsonl");
    let alone = alone.to_str().unwrap();
    run(&home, &["runs", "export", "--batch", "b1", "-o", alone]).status(0);
    let third = Home::new();
    run(&third, &["runs", "import", alone]).status(0);
    assert_eq!(tables(&third), tables(&home));
}

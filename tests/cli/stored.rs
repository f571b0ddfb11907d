//! The store of answers: what is there is not asked for again, and what leaves it comes back the same.

use serde_json::{Value, json};

use super::CUT_IN;
use super::remote::{KEY, ask, delta, streamed};
use super::support::program::{Ended, Home};
use super::support::server::{Script, Server};

fn says(words: &str) -> Script {
    let verdict = json!({"collision": true, "obstacles": [], "justification": words});
    streamed(&verdict.to_string())
}

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_same_request_is_sent_once() {
    let home = Home::new();
    let server = Server::start(["a", "b", "c", "d"].map(says).to_vec()).await;
    let ask = |more: &[&str]| {
        ask(
            &home,
            server.base_url(),
            &[&["--format=json"], more].concat(),
        )
        .status(0)
        .json()
    };
    assert_eq!(ask(&[])["stored"], Value::Null);
    let again = ask(&[]);
    assert_eq!(
        (&again["verdict"]["justification"], server.requests().len()),
        (&json!("a"), 1)
    );
    assert_eq!(again["stored"]["run"], 1);
    assert_eq!(again["stored"]["origin"], "asked");
    let words = super::remote::ask(&home, server.base_url(), &[])
        .status(0)
        .stdout;
    assert!(
        words.contains("run           1, from the store, asked 20"),
        "{words}"
    );
    assert_eq!(ask(&["--fresh"])["verdict"]["justification"], "b");
    assert_eq!(
        ask(&[])["verdict"]["justification"],
        "b",
        "the newest counts"
    );
    assert_eq!(ask(&["--sample", "1"])["verdict"]["justification"], "c");
    assert_eq!(ask(&["--sample", "1"])["verdict"]["justification"], "c");
    assert_eq!(
        ask(&["--set=temperature=0.3"])["verdict"]["justification"],
        "d"
    );
    assert_eq!((server.requests().len(), home.runs().len()), (4, 4));
    run(&home, &["runs", "delete", "3"]).status(0);
    let none = super::remote::ask(&home, server.base_url(), &["--sample", "1"]);
    none.status(1).says(&["no answer"]);
    assert_eq!(server.requests().len(), 5, "a deleted answer is none");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_truncated_answer_is_asked_for_again() {
    let home = Home::new();
    let cut = Script::chunked_events()
        .chunk(delta(
            "{\"collision\": false, \"obstacles\": [], \"justification\": \"a\"}",
        ))
        .chunk("data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"length\"}]}\n\n")
        .chunk("data: [DONE]\n\n")
        .end_of_chunks();
    let server = Server::start(vec![cut, says("whole")]).await;
    ask(&home, server.base_url(), &["--format=json"]);
    assert_eq!(home.runs()[0]["state"].as_deref(), Some("truncated"));
    let next = ask(&home, server.base_url(), &["--format=json"])
        .status(0)
        .json();
    assert_eq!(next["verdict"]["justification"], "whole");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn programs_that_ask_the_same_at_once_ask_once() {
    let home = Home::new();
    let words = json!({"collision": true, "obstacles": [], "justification": "one"}).to_string();
    let slow = Script::chunked_events()
        .pause(std::time::Duration::from_millis(1500))
        .chunk(delta(&words))
        .chunk("data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"stop\"}]}\n\n")
        .chunk("data: [DONE]\n\n")
        .end_of_chunks();
    let server = Server::start(vec![slow, says("two")]).await;
    let arguments = [
        "ask",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--base-url",
        server.base_url(),
        "--format=json",
    ];
    let children: Vec<_> = (0..4).map(|_| home.start(&arguments)).collect();
    for child in children {
        let output = tokio::task::block_in_place(|| child.wait_with_output()).unwrap();
        assert_eq!(
            Ended::of(&output).status(0).json()["verdict"]["justification"],
            "one"
        );
    }
    assert_eq!((server.requests().len(), home.runs().len()), (1, 1));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn exported_runs_answer_elsewhere_and_are_there_once() {
    let (home, other) = (Home::new(), Home::new());
    let server = Server::start(vec![says("brakes \u{7}hard"), says("second")]).await;
    ask(&home, server.base_url(), &[]).status(0);
    ask(&home, server.base_url(), &["--sample", "1"]).status(0);
    run(&home, &["ask", CUT_IN]).status(0);
    run(&home, &["runs", "export", "-o", "runs.jsonl"])
        .status(0)
        .says(&["3 runs exported"]);
    run(&home, &["runs", "export", "-o", "runs.jsonl"])
        .status(2)
        .says(&["--overwrite"]);
    let lines = std::fs::read_to_string(home.files().join("runs.jsonl")).unwrap();
    assert_eq!(lines.lines().count(), 3);
    assert_eq!(run(&home, &["runs", "export"]).status(0).stdout, lines);
    let own = run(&home, &["runs", "import", "runs.jsonl"])
        .status(0)
        .stdout;
    assert_eq!(own, "0 imported, 3 already in the store, 0 unreadable\n");

    let file = other.write("runs.jsonl", &lines);
    let file = file.to_str().unwrap();
    let children: Vec<_> = (0..4)
        .map(|_| other.start(&["runs", "import", "--format=json", file]))
        .collect();
    let counts = children.into_iter().map(|child| {
        let output = tokio::task::block_in_place(|| child.wait_with_output()).unwrap();
        let counts = Ended::of(&output).status(0).json();
        counts["imported"].as_u64().unwrap()
    });
    assert_eq!(counts.sum::<u64>(), 3, "four programs at once");
    let replayed = ask(&other, server.base_url(), &["--format=json"])
        .status(0)
        .json();
    assert_eq!(replayed["verdict"]["justification"], "brakes \u{7}hard");
    assert_eq!(replayed["stored"]["origin"], "replayed");
    assert_eq!(server.requests().len(), 2);

    let bad = lines
        .replacen("hard", "softly", 1)
        .replacen("\"temperature\"", "\"t\"", 1);
    let changed = bad.replacen("You are an expert", "You are no expert", 1);
    other.write("bad.jsonl", format!("hello\n\n{changed}{{}}\n"));
    let ended = run(&other, &["runs", "import", "bad.jsonl"])
        .status(1)
        .says(&[
            "bad.jsonl:1:1: not a run: expected value",
            "bad.jsonl:3:",
            "was changed",
            "3 could not be read",
        ]);
    assert_eq!(
        ended.stdout,
        "0 imported, 2 already in the store, 3 unreadable\n"
    );
    // Line and column are those of the file, also where a record is spread over lines.
    other.write("spread.json", "{\"nearmiss_run\": 2,\n \"id\": oops}\n[\n");
    let ended = run(&other, &["runs", "import", "spread.json"])
        .status(1)
        .says(&[
            "spread.json:1:19: not a run: EOF",
            "spread.json:2:5: not a run: invalid type: string \"id\", expected a JSON object",
        ]);
    assert!(!ended.stderr.contains("at line"), "{}", ended.stderr);
    let misspelt = lines.replacen("\"task\"", "\"tsak\"", 1);
    other.write("misspelt.jsonl", misspelt);
    run(&other, &["runs", "import", "misspelt.jsonl"])
        .status(1)
        .says(&[
            "misspelt.jsonl:1: unknown field `tsak`",
            "the fields are run, created_ms",
        ]);
    run(&other, &["runs", "import", "nothing.jsonl"])
        .status(2)
        .says(&["nothing.jsonl"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn tables_have_the_same_rows() {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    let home = Home::new();
    let server = Server::start(vec![says("a, \"b\"\nc")]).await;
    ask(&home, server.base_url(), &[]).status(0);
    run(&home, &["ask", CUT_IN]).status(0);
    run(&home, &["runs", "export", "-o", "runs.csv", "model:lab"]).status(0);
    let mut reader = csv::Reader::from_path(home.files().join("runs.csv")).unwrap();
    let header = reader.headers().unwrap().clone();
    let row = reader.records().next().unwrap().unwrap();
    let cell = |name: &str| &row[header.iter().position(|h| h == name).unwrap()];
    assert_eq!(
        (cell("justification"), cell("dangerous")),
        ("a, \"b\"\nc", "true")
    );
    assert_eq!((cell("input_tokens"), cell("cost_usd")), ("9200", ""));
    run(&home, &["runs", "export", "-o", "runs.parquet"]).status(0);
    let file = std::fs::File::open(home.files().join("runs.parquet")).unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let rows: Vec<_> = reader
        .get_row_iter(None)
        .unwrap()
        .map(|row| {
            let row = row.unwrap();
            let cells = row
                .get_column_iter()
                .map(|(name, cell)| (name.clone(), cell.clone()));
            cells.collect::<std::collections::BTreeMap<_, _>>()
        })
        .collect();
    use parquet::record::Field;
    assert_eq!(rows.len(), 2);
    assert_eq!(rows[0]["justification"], Field::Str("a, \"b\"\nc".into()));
    assert_eq!(
        (&rows[0]["output_tokens"], &rows[0]["dangerous"]),
        (&Field::Long(34), &Field::Bool(true))
    );
    assert_eq!(
        (&rows[0]["batch"], &rows[1]["output_tokens"]),
        (&Field::Null, &Field::Null)
    );
    assert_eq!(rows[1]["model"], Field::Str("reference/geometry".into()));
    let piped = home.bytes(&["runs", "export", "--format", "parquet"]);
    assert!(piped.starts_with(b"PAR1"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn runs_are_listed_searched_shown_and_deleted() {
    let home = Home::new();
    let server = Server::start(vec![says("It pulls out \u{1b}[2J.")]).await;
    assert_eq!(run(&home, &["runs", "list"]).status(0).stdout, "");
    ask(&home, server.base_url(), &[]).status(0);
    run(&home, &["ask", CUT_IN, "--task", "safety"]).status(0);
    let lines = |arguments: &[&str]| {
        let text = run(&home, arguments).status(0).stdout;
        assert!(!text.contains('\u{1b}'), "{text}");
        text.lines().map(str::to_string).collect::<Vec<_>>()
    };
    let all = lines(&["runs", "list"]);
    assert!(
        all.len() == 3 && all[1].contains("reference/geometry"),
        "{all:?}"
    );
    assert!(all[2].contains(" collision ") && all[2].contains("lab/tiny"));
    assert_eq!(lines(&["runs", "list", "task:safety"]).len(), 2);
    assert_eq!(lines(&["runs", "list", "since:2100-01-01"]).len(), 0);
    run(&home, &["runs", "list", "since:soon"])
        .status(2)
        .says(&["2026-01-31"]);
    run(&home, &["runs", "list", "state:odd"])
        .status(2)
        .says(&["truncated"]);
    let found = lines(&["runs", "list", "PULL", "out"]);
    assert!(
        found.len() == 3 && found[2].contains("[pulls] [out]"),
        "{found:?}"
    );
    assert!(lines(&["runs", "list", "never"]).is_empty());
    let one: Value =
        serde_json::from_str(&lines(&["runs", "list", "--format=json", "-n", "1"])[0]).unwrap();
    assert_eq!((&one["run"], &one["task"]), (&json!(2), &json!("safety")));
    let shown = lines(&["runs", "show", "1"]).join("\n");
    assert!(
        shown.contains("It pulls out ␛[2J.") || shown.contains("It pulls out \\u001b[2J."),
        "{shown}"
    );
    run(&home, &["runs", "show", "9"])
        .status(2)
        .says(&["no run 9"]);
    run(&home, &["runs", "pin", "1"]).status(0);
    run(&home, &["runs", "delete", "1"])
        .status(2)
        .says(&["pinned", "unpin"]);
    run(&home, &["runs", "unpin", "1"]).status(0);
    run(&home, &["runs", "delete", "1"]).status(0);
    assert_eq!(lines(&["runs", "list"]).len(), 2);
    assert_eq!(lines(&["runs", "list", "deleted"]).len(), 2);
    run(&home, &["runs", "restore", "1"]).status(0);
    run(&home, &["runs", "note", "1", "look again"]).status(0);
    assert_eq!(lines(&["runs", "list", "again"]).len(), 3);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn no_secret_leaves_the_program() {
    let home = Home::new();
    let echo = json!({"error": {"message": format!("bad key {KEY}")}}).to_string();
    let server = Server::start(vec![says("fine"), Script::json(401, &echo)]).await;
    let secrets = [KEY, "hunter22", "tokeninquery"];
    let url =
        server.base_url().replace("http://", "http://me:hunter22@") + "/v1?token=tokeninquery";
    let mut said = String::new();
    let mut hear = |ended: Ended| said.push_str(&(ended.stdout + &ended.stderr));
    hear(ask(&home, &url, &[]).status(0));
    hear(ask(&home, &url, &["--sample", "1"]).status(1));
    hear(run(&home, &["runs", "export"]).status(0));
    for file in ["runs.jsonl", "runs.csv", "runs.parquet"] {
        hear(run(&home, &["runs", "export", "-o", file]).status(0));
    }
    for more in [
        &["runs", "list"][..],
        &["runs", "show", "1", "--format=json"],
        &["runs", "show", "2"],
    ] {
        hear(run(&home, more).status(0));
    }
    assert!(
        said.contains("fine") && said.contains("127.0.0.1"),
        "{said}"
    );
    for secret in secrets {
        assert!(!said.contains(secret), "{secret}: {said}");
        assert!(
            home.files_with(secret).is_empty(),
            "{secret}: {:?}",
            home.files_with(secret)
        );
    }
    assert!(
        !home.files_with("fine").is_empty(),
        "the files are looked into"
    );
}

#[test]
fn recorded_answers_are_tied_to_their_scenarios() {
    let home = Home::new();
    let answer = |half: &str, name: &str, way: &str, text: &str| {
        let path = format!("paper/Results/{half}/{name}/{way}/analysis/x_all_timesteps.txt");
        home.write(path, text);
    };
    let verdict = r#"{"collision": true, "obstacles": [], "justification": "It cuts in."}"#;
    answer(
        "output_validation",
        CUT_IN,
        "scenario/ego_cot/gemini",
        verdict,
    );
    answer(
        "output_validation",
        CUT_IN,
        "scenario/cart_base/openai",
        "I cannot say.",
    );
    answer(
        "output_validation",
        CUT_IN,
        "agent/ego_icl/gemini",
        "Obstacle ID: 301\nCollision Risk: 1",
    );
    answer(
        "output_validation_normal",
        "GONE-1_1_T-1",
        "scenario/ego_base/openai",
        verdict,
    );
    answer(
        "output_validation_normal",
        "GONE-1_1_T-1",
        "agent/ego_base/openai",
        "none",
    );
    home.write(
        format!("paper/Scenarios/collision_scenarios/{CUT_IN}.xml"),
        super::bundled_xml(CUT_IN),
    );
    let ego = format!("paper/Results/output_validation/{CUT_IN}/ego_trajectory.csv");
    home.write(ego, super::bundled_ego(CUT_IN));

    let first = home
        .run(&["runs", "import", "paper"])
        .status(0)
        .says(&["2 answers linked", "by name only"]);
    assert_eq!(
        first.stdout,
        "5 imported, 0 already in the store, 0 unreadable\n"
    );
    let again = home.run(&["runs", "import", "paper"]).status(0).stdout;
    assert_eq!(again, "0 imported, 5 already in the store, 0 unreadable\n");

    let runs = home.rows("SELECT * FROM runs WHERE scenario_hash IS NOT NULL ORDER BY task, frame");
    let column = |row: usize, name: &str| runs[row][name].clone().unwrap_or("NULL".into());
    assert_eq!(runs.len(), 3);
    assert_eq!(
        (column(0, "frame"), column(0, "techniques")),
        ("cartesian".into(), "base".into())
    );
    assert_eq!(
        (column(0, "verdict"), column(0, "answer")),
        ("NULL".into(), "I cannot say.".into())
    );
    assert_eq!(
        (column(1, "techniques"), column(1, "dangerous")),
        ("cp+cot".into(), "1".into())
    );
    assert_eq!(
        (column(1, "origin"), column(1, "provider")),
        ("recorded".into(), "recorded".into())
    );
    assert!(column(1, "source").starts_with("Results/output_validation/ZAM_CutIn"));
    let (start, end) = (column(2, "window_first"), column(2, "window_last"));
    let steps = super::bundled_ego(CUT_IN).lines().count() as i64 - 1;
    assert_eq!(
        column(1, "window_last"),
        (steps - 1).to_string(),
        "the end of the recording"
    );
    let last: i64 = end.parse().unwrap();
    assert_eq!(
        (last, start.parse::<i64>().unwrap()),
        (steps - 3, last - 9),
        "the paper's window"
    );

    let asked = home.run(&["ask", CUT_IN]).status(0);
    drop(asked);
    let hash = home.rows("SELECT scenario_hash FROM runs WHERE origin = 'asked'");
    assert_eq!(
        hash[0]["scenario_hash"].clone().unwrap(),
        column(0, "scenario_hash")
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn tables_for_spreadsheets_have_no_formulas() {
    let home = Home::new();
    let formula = "=HYPERLINK(\"http://evil.example\",\"see\")";
    let server = Server::start(vec![says(formula)]).await;
    ask(&home, server.base_url(), &[]).status(0);
    let export = ["runs", "export", "--format", "csv"];
    let quoted = formula.replace('"', "\"\"");
    let plain = run(&home, &export).status(0).stdout;
    assert!(plain.contains(&format!(",\"{quoted}\",")), "{plain}");
    let option = ["--for-spreadsheet"];
    let guarded = run(&home, &[&export[..], &option].concat())
        .status(0)
        .stdout;
    assert!(guarded.contains(&format!(",\"'{quoted}\",")), "{guarded}");
    assert!(!guarded.contains(&format!(",\"{quoted}")), "{guarded}");
    for other in [
        &["runs", "export"][..],
        &["metrics", CUT_IN, "--format=json"],
        &["plan", CUT_IN],
        &["report"],
    ] {
        let refused = run(&home, &[other, &option].concat()).status(2);
        refused.says(&["--for-spreadsheet is for CSV alone"]);
    }
    // Numbers stay as they are.
    let measures = ["metrics", CUT_IN];
    let plain = run(&home, &measures).status(0).stdout;
    let guarded = run(&home, &[&measures[..], &option].concat())
        .status(0)
        .stdout;
    assert!(plain.contains(",-") && plain == guarded);
    home.write("=1+1.xml", super::bundled_xml(CUT_IN));
    let named = ["metrics", "=1+1.xml", "--ego", "301", "--for-spreadsheet"];
    let named = run(&home, &named).stdout;
    assert!(
        named.contains("\n'=1+1,"),
        "{}",
        named.lines().nth(1).unwrap_or_default()
    );
}

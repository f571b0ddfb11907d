//! Experiments with axes, a filter, hashes, and a split whose test part is locked until it is complete.

use super::batches::{home as home_with, telling};
use super::support::program::{Ended, Home};
use super::support::server::{Script, Server};

const CUT_IN: &str = "ZAM_CutIn-1_1_T-1";
const RED_LIGHT: &str = "ZAM_RedLight-1_1_T-1";
const HARD_BRAKING: &str = "ZAM_HardBraking-1_1_T-1";
const MERGE: &str = "ZAM_Merge-1_1_T-1";
const SAYS: &str = r#"{"collision": true, "obstacles": [], "justification": "so"}"#;

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

/// An experiment about four maps.
fn split(more: &str) -> String {
    format!(
        "scenarios = [\"{CUT_IN}\", \"{RED_LIGHT}\", \"{HARD_BRAKING}\", \"{MERGE}\"]\n\
         models = [\"lab/tiny\"]\ntasks = [\"collision\"]\ntechniques = [\"base\"]\n{more}\n"
    )
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn each_value_of_an_axis_is_sent_and_has_its_row() {
    let server = Server::answering(|_, _| Some(telling(SAYS))).await;
    let home = home_with(server.base_url());
    let flags = [
        "evaluate",
        CUT_IN,
        "--model",
        "lab/tiny,reference/geometry",
        "--task",
        "collision",
        "--techniques",
        "base",
        "--set",
        "temperature=0,0.7",
        "--set",
        "seed=1,2",
        "--set",
        "form=compact",
        "--set",
        "stride=2",
    ];
    run(
        &home,
        &[&flags[..], &["--write-experiment", "e.toml"]].concat(),
    )
    .status(0);
    let text = std::fs::read_to_string(home.files().join("e.toml")).unwrap();
    for line in [
        "temperature = [0.0, 0.7]",
        "seed = [1, 2]",
        "form = \"compact\"",
        "stride = 2",
        "[hashes]\nZAM_CutIn-1_1_T-1 = \"",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let table = run(&home, &flags).status(0).stdout;
    assert!(table.contains("temperature 0.7, seed 2"), "{table}");
    let sent: Vec<(f64, u64)> = server
        .requests()
        .iter()
        .map(|request| {
            let body = request.json();
            let seed = body["seed"].as_u64().unwrap();
            (body["temperature"].as_f64().unwrap(), seed)
        })
        .collect();
    assert_eq!(sent.len(), 4, "each combination once: {sent:?}");
    let list = run(&home, &["evaluate", "list", "--format=json"])
        .status(0)
        .json();
    assert_eq!(
        list["axes"],
        serde_json::json!({ "temperature": [0.0, 0.7], "seed": [1, 2] })
    );
    for wanted in [(0.0, 1), (0.0, 2), (0.7, 1), (0.7, 2)] {
        assert!(sent.contains(&wanted), "{wanted:?}: {sent:?}");
    }
    let again = run(&home, &["evaluate", "e.toml", "--format=json"])
        .status(0)
        .says(&["going on with b1"])
        .json();
    let cells = again["cells"].as_array().unwrap();
    assert_eq!(cells.len(), 5, "and the judge once");
    let report = run(&home, &["report", "--batch", "b1", "--format=json"])
        .status(0)
        .json();
    let settings: Vec<&str> = report["cells"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|cell| cell["label"] == "all")
        .filter_map(|cell| cell["settings"].as_str())
        .collect();
    assert_eq!(settings.len(), 4);
    let pairs = report["pairs"].as_array().unwrap();
    let differs = |axis: &str| pairs.iter().filter(|pair| pair["differs"] == axis).count();
    assert_eq!((differs("temperature"), differs("seed")), (2, 2));
    // All runs of the store: each setting is a row of its own there, too.
    let all = run(&home, &["report", "--runs", "model:lab/tiny"]).status(0);
    assert!(
        all.stdout.contains("temperature 0.7, seed 1"),
        "{}",
        all.stdout
    );
    assert_eq!(server.requests().len(), 4);
}

#[test]
fn a_filter_selects_and_is_written_down() {
    let home = Home::new();
    let flags = [
        "evaluate",
        CUT_IN,
        RED_LIGHT,
        HARD_BRAKING,
        "--model",
        "reference/geometry",
        "--set",
        "select=!RedLight country:ZAM",
    ];
    home.run(&[&flags[..], &["--write-experiment", "e.toml"]].concat())
        .status(0);
    let text = std::fs::read_to_string(home.files().join("e.toml")).unwrap();
    assert!(
        text.contains("select = \"!RedLight country:ZAM\""),
        "{text}"
    );
    assert!(!text.contains("RedLight-1_1_T-1 ="), "{text}");
    home.run(&["evaluate", "e.toml"]).status(0);
    let list = home
        .run(&["evaluate", "list", "--format=json"])
        .status(0)
        .json();
    assert_eq!(list["scenarios"], 2);
    // Another filter is another batch.
    home.write("e.toml", text.replace("!RedLight", "!CutIn"));
    home.run(&["evaluate", "e.toml"])
        .status(2)
        .says(&["hashes: ZAM_CutIn-1_1_T-1 is not among the scenarios"]);
    home.run(&[&flags[..7], &["select=risk<"]].concat())
        .status(2)
        .says(&["--set select: `risk<`: a term has no value"]);
    home.run(&[&flags[..7], &["select=verdict:differ"]].concat())
        .status(2)
        .says(&["depends on your stored answers"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_test_split_is_locked_until_it_is_complete_and_looks_are_told() {
    // The fourth question has no answer at first.
    let broken = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(true));
    let is_broken = std::sync::Arc::clone(&broken);
    let server = Server::answering(move |number, _| {
        let fails = number >= 3 && is_broken.load(std::sync::atomic::Ordering::SeqCst);
        Some(if fails {
            Script::json(400, "{\"error\":{\"message\":\"no\"}}")
        } else {
            telling(SAYS)
        })
    })
    .await;
    let home = home_with(server.base_url());
    // Whole parts of two scenarios each.
    let seed = (1..100)
        .find(|seed| {
            let split = nearmiss::evaluation::batch::Split {
                test: 0.5,
                seed: *seed,
            };
            let all = [CUT_IN, RED_LIGHT, HARD_BRAKING, MERGE];
            let test = |name: &&str| split.part(name) == nearmiss::store::SplitPart::Test;
            all.into_iter().filter(|name| test(name)).count() == 2
        })
        .unwrap();
    let more = format!("split = {{ test = 0.5, seed = {seed} }}\ntruth = [\"auto\"]");
    home.write("e.toml", split(&more));
    let dev = run(&home, &["evaluate", "e.toml", "--split", "dev"]).status(0);
    assert!(
        dev.stdout.contains("dev split: 2 of 2 answered"),
        "{}",
        dev.stdout
    );
    assert!(
        dev.stdout.contains("test split: 0 of 2 answered, locked"),
        "{}",
        dev.stdout
    );
    assert_eq!(server.requests().len(), 2);
    let half = run(
        &home,
        &["evaluate", "e.toml", "--split", "test", "--format=json"],
    )
    .status(1)
    .json();
    let of = |cells: &serde_json::Value, part: &str| {
        let cells = cells["cells"].as_array().unwrap();
        cells.iter().filter(|cell| cell["split"] == part).count()
    };
    assert_eq!((of(&half, "dev"), of(&half, "test")), (1, 0), "{half}");
    assert_eq!(half["splits"][1]["locked"], true);
    assert_eq!(half["splits"][1]["answered"], 1);
    // No format of a report has its figures, nor has that of all runs.
    for format in ["md", "latex", "csv", "json", "html"] {
        let report = run(&home, &["report", "--batch", "b1", "--format", format])
            .status(0)
            .says(&["test split: 1 of 2 answered, locked"]);
        assert!(!report.stdout.contains("est split: 1 question"), "{format}");
        let rows = report.stdout.lines().filter(|line| line.ends_with(",test"));
        assert_eq!(rows.count(), 0, "{format}");
    }
    let all = run(&home, &["report"]).status(0);
    assert!(
        all.stdout.contains("of test splits that are not complete"),
        "{}",
        all.stdout
    );
    assert!(all.stdout.contains("2 runs of the store"), "{}", all.stdout);
    run(&home, &["report", "--unlock"])
        .status(2)
        .says(&["add --batch"]);
    single_answers_are_left_out(&home);
    // A table over axes is of one part.
    let rows = [
        "report",
        "--batch",
        "b1",
        "--rows",
        "model",
        "--format=json",
    ];
    let dev = run(&home, &rows).status(0).json();
    assert_eq!(dev["tables"][0]["n"], 2, "{dev}");
    run(&home, &[&rows[..], &["--split", "test"]].concat())
        .status(2)
        .says(&["test split: 1 of 2 answered, locked; --unlock"]);
    // A look is recorded, and told ever after.
    let look = run(
        &home,
        &["report", "--batch", "b1", "--unlock", "--format=json"],
    )
    .status(0)
    .json();
    assert!(of(&look, "test") > 0, "{look}");
    assert_eq!(look["splits"][1]["looks"], 1);
    let locked = run(&home, &["report", "--batch", "b1"]);
    locked
        .status(0)
        .says(&["the test split was looked at once before it was complete"]);
    run(&home, &["evaluate", "b1", "--unlock", "--dry-run"]).status(0);
    broken.store(false, std::sync::atomic::Ordering::SeqCst);
    let whole = run(&home, &["evaluate", "e.toml"]).status(0).stdout;
    assert!(whole.contains("test split: 2 of 2 answered\n"), "{whole}");
    let looked = "the test split was looked at once before it was complete";
    assert!(whole.contains(looked), "{whole}");
    let report = run(&home, &["report", "--batch", "b1"]).status(0).stdout;
    for words in [
        "The dev split",
        "The test split",
        "The test split was looked at once before it was complete.",
    ] {
        assert!(report.contains(words), "{words}: {report}");
    }
    let csv = run(&home, &["report", "--batch", "b1", "--format", "csv"])
        .status(0)
        .stdout;
    assert!(
        csv.lines()
            .next()
            .is_some_and(|head| head.ends_with(",split")),
        "{csv}"
    );
    let all = run(&home, &["report"]).status(0).stdout;
    assert!(all.contains("4 runs of the store"), "{all}");
    // Now there are two parts, which no table and no figure counts together.
    for more in [
        &["--rows", "model"][..],
        &["--figure", "bars", "-o", "f.svg"],
    ] {
        run(&home, &[&["report", "--batch", "b1"], more].concat())
            .status(2)
            .says(&["--split dev or --split test"]);
    }
    for part in ["dev", "test"] {
        let of_part = run(&home, &[&rows[..], &["--split", part]].concat()).status(0);
        let words = format!("Batch b1, {part} split: 2 questions.");
        assert!(of_part.stdout.contains(&words), "{}", of_part.stdout);
        let whole = run(&home, &["report", "--batch", "b1", "--split", part]).status(0);
        assert!(
            whole.stdout.contains(&format!("The {part} split")),
            "{}",
            whole.stdout
        );
        let other = if part == "dev" {
            "The test split\n"
        } else {
            "The dev split\n"
        };
        assert!(!whole.stdout.contains(other), "{}", whole.stdout);
    }
    run(&home, &["report", "--split", "dev"])
        .status(2)
        .says(&["add --batch"]);
    let listed = run(&home, &["runs", "list", "--format=json"]).status(0);
    assert_eq!(
        listed.json_lines().len(),
        5,
        "four answers, and one that failed"
    );
    assert!(!listed.stderr.contains("left out"), "{}", listed.stderr);
    // Complete, it needs no unlocking, and a look at it is none.
    run(&home, &["report", "--batch", "b1", "--unlock"]).status(0);
    let looks = home.rows("SELECT answered, questions FROM looks");
    assert_eq!(looks.len(), 1, "{looks:?}");
    assert_eq!(looks[0]["answered"].as_deref(), Some("1"));
}

/// Of two dev questions and two test ones, one of which has failed, `runs` and `export` show the dev ones.
fn single_answers_are_left_out(home: &Home) {
    let left_out = "left out 2 answers of test splits that are not complete; --unlock";
    let listed =
        |more: &[&str]| run(home, &[&["runs", "list", "--format=json"], more].concat()).status(0);
    let dev = listed(&[])
        .says(&[left_out, "lists them, too"])
        .json_lines();
    assert_eq!(dev.len(), 2);
    assert_eq!(
        listed(&["-n", "1"]).json_lines(),
        dev[..1],
        "the newest that may be shown"
    );
    run(home, &["runs", "list", "so"])
        .status(0)
        .says(&["left out"]);
    let all = home.rows("SELECT id FROM runs ORDER BY id");
    let dev: Vec<&serde_json::Value> = dev.iter().map(|run| &run["run"]).collect();
    let locked = all
        .iter()
        .filter_map(|row| row["id"].clone())
        .filter(|id| !dev.iter().any(|run| run.to_string() == *id));
    let locked: Vec<String> = locked.collect();
    assert_eq!((all.len(), locked.len()), (4, 2));
    run(home, &["runs", "show", &locked[0]])
        .status(2)
        .says(&["a test split that is not complete; --unlock"]);
    let exported = run(home, &["runs", "export"])
        .status(0)
        .says(&["left out 2 answers", "exports them"]);
    let kinds = |name: &str| {
        let lines = exported.json_lines();
        lines
            .into_iter()
            .filter(|line| !line[name].is_null())
            .collect::<Vec<_>>()
    };
    assert_eq!(kinds("nearmiss_run").len(), 2);
    let questions = kinds("nearmiss_question");
    let open = questions
        .iter()
        .filter(|line| line["state"] == "waiting" && line["run"].is_null());
    assert_eq!(
        (questions.len(), open.count()),
        (4, 2),
        "they are open elsewhere"
    );
    for format in ["csv", "parquet"] {
        let file = format!("runs.{format}");
        run(home, &["runs", "export", "-o", &file])
            .status(0)
            .says(&["left out 2 answers", "2 runs"]);
    }
    // Whatever of the others can be an example.
    run(home, &["runs", "export", "--format", "chat", "-o", "chats"])
        .says(&["left out 2 answers of test splits", "exports them"]);
    assert!(home.rows("SELECT * FROM looks").is_empty());
    // A copy of the store is looked at.
    let copy = Home::new();
    std::fs::copy(
        home.data().join("runs.sqlite"),
        copy.data().join("runs.sqlite"),
    )
    .unwrap();
    let unlocked = run(&copy, &["runs", "list", "--format=json", "--unlock"]).status(0);
    assert_eq!(
        unlocked
            .says(&["test split: 1 of 2 answered, unlocked"])
            .json_lines()
            .len(),
        4
    );
    run(&copy, &["runs", "show", &locked[0], "--unlock"]).status(0);
    run(&copy, &["runs", "export", "--unlock", "-o", "all.jsonl"])
        .status(0)
        .says(&["4 runs"]);
    assert_eq!(copy.rows("SELECT * FROM looks").len(), 3);
}

#[test]
fn a_split_without_one_of_its_parts_and_a_part_without_a_split_are_mistakes() {
    let home = Home::new();
    home.write(
        "e.toml",
        "scenarios = [\"ZAM_CutIn-1_1_T-1\"]\nmodels = [\"reference/geometry\"]\n",
    );
    home.run(&["evaluate", "e.toml", "--split", "dev"])
        .status(2)
        .says(&["--split: the scenarios have no split"]);
    let flags = [
        "evaluate",
        CUT_IN,
        "--model",
        "reference/geometry",
        "--set",
        "split.test=0.5",
    ];
    home.run(&flags)
        .status(2)
        .says(&["no scenario is in the", "change its seed or its share"]);
    home.run(&[&flags[..4], &["--set", "split.test=1"]].concat())
        .status(2)
        .says(&["above 0 and below 1"]);
}

//! `evaluate`: the built-in judge on many scenarios; and models on changed scenes and at several leads.

use super::batches::{home as home_with, telling};
use super::support::program::{Home, untimed};
use super::support::server::Server;
use super::{BUNDLED, CUT_IN, bundled_xml};

const RED_LIGHT: &str = "ZAM_RedLight-1_1_T-1";
const HARD_BRAKING: &str = "ZAM_HardBraking-1_1_T-1";

fn labels(home: &Home) -> String {
    let mut text = "scenario,label\n".to_string();
    for (name, collides) in BUNDLED {
        text.push_str(&format!(
            "{name},{}\n",
            if collides { "collision" } else { "safe" }
        ));
    }
    home.write("truth.csv", text).display().to_string()
}

fn rows(text: &str) -> Vec<std::collections::BTreeMap<String, String>> {
    csv::Reader::from_reader(text.as_bytes())
        .deserialize()
        .map(Result::unwrap)
        .collect()
}

#[test]
fn a_table_by_lead_with_everybody_side_by_side() {
    let home = Home::new();
    let arguments = ["evaluate", CUT_IN, RED_LIGHT, HARD_BRAKING];
    let ended = home.run(&arguments).status(0);
    assert_eq!(ended.stderr, "", "silent in a pipe");
    for words in [
        "2 collisions, 1 safe scenario\n",
        "horizon in seconds",
        "less\nthan 1 s apart",
        "exact geometry",
        "Lead  n  Recall  Named  False alarms  Safe  Precision    F1  Names right",
        "reference/geometry                   end",
        "reference/constant-velocity:1.5      0.2",
        "reference/constant-acceleration:2    1.5",
        "reference/geometry                   2.0  0.30",
        "false alarms over all",
    ] {
        assert!(ended.stdout.contains(words), "{words}: {}", ended.stdout);
    }
    assert!(ended.stdout.lines().all(|l| l.chars().count() <= 110));
}

#[test]
fn csv_and_json_hold_the_same_counts() {
    let home = Home::new();
    let scenarios = [CUT_IN, RED_LIGHT, HARD_BRAKING];
    let options = [
        "--set",
        "leads=0.2,1.5",
        "--model",
        "reference/geometry,reference/constant-velocity",
        "--horizon",
        "1",
        "--format",
    ];
    let run = |format| {
        let all = [&["evaluate"], &scenarios[..], &options[..], &[format]].concat();
        home.run(&all).status(0)
    };
    let rows = rows(&run("csv").stdout);
    assert_eq!(rows.len(), 4);
    let document = run("json").json();
    assert_eq!(
        document["batch"],
        serde_json::Value::Null,
        "nothing is stored"
    );
    assert_eq!(document["asked"]["truth"], serde_json::json!(["auto"]));
    let predictors = document["predictors"].as_array().unwrap();
    for (at, row) in rows.iter().enumerate() {
        let lead = &document["lead"][at];
        let is_its = |one: &&serde_json::Value| one["model"] == lead["model"];
        let predictor = predictors.iter().find(is_its).unwrap();
        assert_eq!(row["model"], lead["model"].as_str().unwrap());
        assert_eq!(row["lead"], lead["lead"].to_string());
        for count in ["n", "yes", "false_alarms", "false_alarms_of"] {
            assert_eq!(row[count], lead[count].to_string(), "{count}");
        }
        assert_eq!((&*row["n"], &*row["false_alarms_of"]), ("2", "2"));
        for figure in ["horizon", "threshold", "windows", "alarmed", "alarms"] {
            let (told, known) = (&row[figure], predictor[figure].as_f64());
            assert_eq!(told.parse().ok(), known, "{figure}");
        }
    }
    // 0.2 s before, all judges see both collisions; 1.5 s before, a horizon of 1 s cannot.
    let row = |model: &str, lead: &str| {
        let mut found = rows.iter();
        found
            .find(|row| row["model"] == model && row["lead"] == lead)
            .unwrap()
    };
    let early = row("reference/constant-velocity:1", "1.5");
    let late = row("reference/geometry", "0.2");
    assert_eq!((&*late["yes"], &*late["f1"]), ("2", "1.0"));
    assert_eq!((&*early["yes"], &*early["n"]), ("0", "2"));
    assert_eq!(early["precision"], "", "no model said yes");
    let missed = document["differences"].as_array().unwrap().iter();
    let missed = missed.filter(|one| {
        (&one["model"], &one["lead"], &one["label"])
            == (
                &"reference/constant-velocity:1".into(),
                &1.5.into(),
                &"dangerous".into(),
            )
    });
    assert_eq!(missed.count(), 2);
}

#[test]
fn labels_take_the_place_of_the_geometry() {
    let home = Home::new();
    let truth = home
        .write(
            "t.csv",
            format!("Scenario_Name,Obstacle_ID\n{CUT_IN},301\n"),
        )
        .display()
        .to_string();
    let run = |more: &[&str]| {
        let all = [
            &["evaluate", CUT_IN, "--truth", &truth, "--format", "json"],
            more,
        ]
        .concat();
        home.run(&all)
    };
    let ended = run(&[])
        .status(0)
        .says(&[CUT_IN, "no bodies overlap", "last recorded step"]);
    assert_eq!(ended.json()["collisions"], 1);
    let document = run(&["--task", "collision"]).status(0).json();
    assert_eq!(document["cells"][0]["fn"], 1);
    assert_eq!(document["differences"][0]["scenario"], CUT_IN);
    // One of two has no label.
    run(&[RED_LIGHT])
        .status(1)
        .says(&["of 2 scenarios, 1 without a label", RED_LIGHT]);
    home.run(&["evaluate", RED_LIGHT, "--truth", &truth])
        .status(2);
}

#[test]
fn the_collision_task_is_judged_against_labels() {
    let home = Home::new();
    let truth = labels(&home);
    let names = BUNDLED.map(|(name, _)| name);
    let run = |format| {
        let options = ["--task", "collision", "--truth", &truth, "--format", format];
        home.run(&[&["evaluate"], &names[..], &options[..]].concat())
            .status(0)
    };
    let document = run("json").json();
    let cell = &document["cells"][0];
    assert_eq!((&cell["tp"], &cell["tn"]), (&2.into(), &6.into()));
    assert_eq!(cell["f1"], 1.0);
    assert_eq!(document["differences"], serde_json::json!([]));
    let rows = rows(&run("csv").stdout);
    assert_eq!(rows.len(), 1);
    assert_eq!((&*rows[0]["tp"], &*rows[0]["tn"]), ("2", "6"));
    let table = run("table").stdout;
    assert!(
        table.contains("2 collisions, 6 safe scenarios\n"),
        "{table}"
    );
}

#[test]
fn what_cannot_be_evaluated_is_said() {
    let home = Home::new();
    let bad = home
        .write("bad.csv", "scenario,label\nx,perhaps\n")
        .display()
        .to_string();
    let broken = home
        .write("Broken-1_1_T-1.xml", "<commonRoad")
        .display()
        .to_string();
    for (arguments, status, words) in [
        (
            &["--model", "openai/gpt-4o"][..],
            2,
            &["openai/gpt-4o", "nothing was sent", "OPENAI_API_KEY"][..],
        ),
        (
            &["--model", "reference/magic"],
            2,
            &[
                "reference/magic",
                "the safety task takes reference/geometry",
            ],
        ),
        (&["--task", "collision"], 2, &["--truth CSV"]),
        (
            &[
                "--task",
                "collision",
                "--truth",
                "auto",
                "--model",
                "reference/constant-velocity",
            ],
            2,
            &["collision task"],
        ),
        (&["--truth", "nowhere.csv"], 2, &["nowhere.csv", "auto"]),
        (&["--truth", &bad], 2, &["line 2", "`perhaps`"]),
        (&["--set", "leads=soon"], 2, &["`end`"]),
        (&["--set", "leads=-1"], 2, &["seconds above 0"]),
        (&["--set", "leads=nan"], 2, &["seconds above 0"]),
        (&["--horizon", "11"], 2, &["at most 10"]),
        (
            &["--set", "history=0"],
            2,
            &["a whole number from 1 to 100000"],
        ),
        (&["--set", "radius=0"], 2, &["above 0"]),
        (
            &[&broken, "--set", "leads=1"],
            1,
            &["of 2 scenarios, 1 could not be opened"],
        ),
    ] {
        let all = [&["evaluate", CUT_IN], arguments].concat();
        home.run(&all).status(status).says(words);
    }
    home.run(&["evaluate", &broken]).status(2);
    home.run(&["evaluate"]).status(2);
    home.run(&["evaluate", "nowhere"])
        .status(2)
        .says(&["nowhere"]);
}

#[test]
fn scenarios_without_an_ego_are_told_together() {
    let home = Home::new();
    for i in 0..5 {
        home.write(format!("in/S-{i}.xml"), bundled_xml(CUT_IN));
    }
    let line = "nearmiss: 5 scenarios without a recorded ego: S-0, S-1, S-2 and 2 more; add --ego planner, or put NAME.ego_trajectory.csv";
    let ended = home.run(&["evaluate", "in"]).status(2).says(&[line]);
    assert_eq!(ended.stderr.lines().count(), 2, "{}", ended.stderr);
    home.run(&["evaluate", "in", RED_LIGHT])
        .status(1)
        .says(&[line, "of 6 scenarios, 5 without a recorded ego"]);
}

/// A server that says yes to the first question and no to all others.
async fn yes_first() -> Server {
    Server::answering(|number, _| {
        let text = format!(
            r#"{{"safety_critical": {}, "obstacles": [], "justification": "so"}}"#,
            number == 0
        );
        Some(telling(&text))
    })
    .await
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn changed_scenes_and_leads_are_counted_beside_the_table() {
    let run = |home: &Home, more: &[&str]| {
        let truth = labels(home);
        let all = [
            &["evaluate", HARD_BRAKING, CUT_IN, "--truth", &truth],
            &["--model", "lab/tiny", "--set", "frames=cartesian"][..],
            &["--set", "concurrency=1"],
            more,
        ];
        tokio::task::block_in_place(|| home.run(&all.concat()))
    };
    let plain = yes_first().await;
    let home = home_with(plain.base_url());
    let wanted = run(&home, &["--set", "leads=0.5", "--format=json"])
        .status(0)
        .json();
    assert_eq!(
        (&wanted["cells"][0]["tp"], &wanted["cells"][0]["tn"]),
        (&1.into(), &1.into())
    );
    assert!(
        wanted["invariance"].is_null() && wanted["lead"].is_null(),
        "{wanted}"
    );

    let server = yes_first().await;
    let home = home_with(server.base_url());
    let varied = ["--set", "transforms=mirror", "--set", "leads=0.5,1"];
    let dry = [&varied[..], &["--dry-run", "--format=json"]].concat();
    // The collision and the safe scenario at two leads, and both mirrored.
    assert_eq!(run(&home, &dry).status(0).json()["questions"], 6);
    let document = run(&home, &[&varied[..], &["--format=json"]].concat())
        .status(0)
        .json();
    // The safe windows of both leads are the same one, whose answer is in the store then.
    assert_eq!(server.requests().len(), 5);
    let bodies: std::collections::BTreeSet<_> = server.whole().into_iter().collect();
    assert_eq!(bodies.len(), 5, "each is another question");
    assert_eq!(
        untimed(document["cells"].clone()),
        untimed(wanted["cells"].clone()),
        "the table is of the originals"
    );
    let rows = document["invariance"].as_array().unwrap();
    assert_eq!(rows.len(), 1, "{rows:?}");
    for (name, value) in [("n", 2), ("flips", 1), ("without_verdict", 0)] {
        assert_eq!(rows[0][name], value, "{name}: {rows:?}");
    }
    assert_eq!(
        (&rows[0]["transform"], &rows[0]["flip_rate"]),
        (&"mirror".into(), &0.5.into())
    );
    let leads = document["lead"].as_array().unwrap().iter();
    let leads: Vec<_> = leads
        .map(|l| (l["lead"].as_f64(), l["n"].as_u64(), l["yes"].as_u64()))
        .collect();
    assert_eq!(
        leads,
        [(Some(0.5), Some(1), Some(1)), (Some(1.0), Some(1), Some(0))]
    );

    let resume = |more: &[&str]| {
        let all = [&["evaluate", "last"], more].concat();
        tokio::task::block_in_place(|| home.run(&all)).status(0)
    };
    assert_eq!(resume(&["--format=json"]).json(), document);
    assert_eq!(server.requests().len(), 5, "nothing is asked again");
    let table = resume(&[]).stdout;
    for words in ["mirror", "Flips", "to the collision", "0.5 "] {
        assert!(table.contains(words), "{words}: {table}");
    }
    let report = tokio::task::block_in_place(|| home.run(&["report", "--batch", "last"]))
        .status(0)
        .stdout;
    assert!(
        report.contains("2 questions") && report.contains("4 more"),
        "{report}"
    );
    for words in ["Transformed scenes and leads", "| mirror ", "Said yes"] {
        assert!(report.contains(words), "{words}: {report}");
    }
    let report =
        tokio::task::block_in_place(|| home.run(&["report", "--batch", "last", "--format=json"]))
            .status(0)
            .json();
    assert_eq!(report["lead"], document["lead"]);
    assert_eq!(report["invariance"], document["invariance"]);
    // Of the store as a whole the same questions are counted as of the batch.
    let whole = tokio::task::block_in_place(|| home.run(&["report", "--format=json"])).status(0);
    let cells = &whole.json()["cells"];
    let all = cells
        .as_array()
        .unwrap()
        .iter()
        .find(|c| c["label"] == "all");
    assert_eq!(
        (&all.unwrap()["n"], &all.unwrap()["unlabelled"]),
        (&2.into(), &0.into())
    );
    for words in [
        "skipped: 1 at further leads",
        "skipped: 2 about transformed scenes",
    ] {
        assert!(whole.stderr.contains(words), "{words}: {}", whole.stderr);
    }
    assert!(
        !whole.stderr.contains("no ground truth"),
        "{}",
        whole.stderr
    );
    let list = tokio::task::block_in_place(|| home.run(&["evaluate", "list"])).status(0);
    assert!(
        list.stdout.contains("lead 0.5,1 · mirror"),
        "{}",
        list.stdout
    );
    // A sample more of each, and no question that is there already.
    resume(&["--samples", "2"]);
    assert_eq!(server.requests().len(), 10);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn new_numbers_are_told_back() {
    use nearmiss::formats::bundled;
    use nearmiss::scenario::Transform;
    let entry = bundled()
        .into_iter()
        .find(|entry| entry.name == CUT_IN)
        .unwrap();
    let ids = Transform::Renumber(1).ids(&entry.read().unwrap());
    let (new, old) = ids.into_iter().find(|(new, old)| new != old).unwrap();
    let server = Server::answering(move |number, _| {
        let id = if number == 0 { old } else { new };
        let text = format!(
            r#"{{"safety_critical": true, "obstacles": [{{"id": {id}, "risk_score": 1, "reason": "near"}}], "justification": "so"}}"#
        );
        Some(telling(&text))
    })
    .await;
    let home = home_with(server.base_url());
    let arguments = [
        "evaluate",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--set",
        "concurrency=1",
        "--set",
        "transforms= renumber:1 ; mirror",
        "--format=json",
    ];
    let document = tokio::task::block_in_place(|| home.run(&arguments))
        .status(0)
        .json();
    let rows = document["invariance"].as_array().unwrap();
    let renamed = |change: &str| {
        let row = rows.iter().find(|row| row["transform"] == change).unwrap();
        row["renamed"].as_u64().unwrap()
    };
    assert_eq!(renamed("renumber:1"), 0, "it is the same obstacle");
    assert_eq!(renamed("mirror"), 1, "it is another obstacle");
    let wrong = [
        "evaluate",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--task",
        "collision",
        "--set",
        "leads=0.5,1",
    ];
    tokio::task::block_in_place(|| home.run(&wrong))
        .status(2)
        .says(&["--set leads", "safety task"]);
    let wrong = [
        "evaluate",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--set",
        "transforms=mirror,rotate:90",
    ];
    tokio::task::block_in_place(|| home.run(&wrong))
        .status(2)
        .says(&["invalid transform", "semicolons"]);
}

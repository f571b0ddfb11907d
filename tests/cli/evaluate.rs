//! `evaluate`: the built-in judge on many scenarios.

use super::support::program::Home;
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
        "horizon of the prediction",
        "less than 1 s apart",
        "exact geometry",
        " paper    0.2    0.5      1    1.5      2",
        "reference/geometry                2.0  0.30",
        "reference/constant-velocity       1.5",
        "reference/constant-acceleration   2.0",
        "precision",
        "recall",
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
        "--lead",
        "0.2,1.5",
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
    assert_eq!(document["truth"], "geometry");
    for (at, row) in rows.iter().enumerate() {
        let judge = &document["judges"][at / 2];
        let lead = &judge["leads"][at % 2];
        assert_eq!(row["model"], judge["model"].as_str().unwrap());
        assert_eq!(row["lead"], lead["lead"].to_string());
        for count in ["tp", "fp", "fn", "tn", "collisions", "safe"] {
            assert_eq!(row[count], lead[count].to_string(), "{count}");
        }
        assert_eq!((&*row["collisions"], &*row["safe"]), ("2", "1"));
        let windows = &judge["all_safe_windows"];
        assert_eq!(row["all_safe_windows"], windows["windows"].to_string());
    }
    // 0.2 s before, everybody sees both collisions; 1.5 s before, a horizon of 1 s cannot.
    assert_eq!((&*rows[0]["tp"], &*rows[0]["f1"]), ("2", "1"));
    assert_eq!((&*rows[3]["tp"], &*rows[3]["fn"]), ("0", "2"));
    assert_eq!(rows[3]["precision"], "", "nobody said yes");
    assert_eq!(
        document["judges"][1]["leads"][1]["missed"]
            .as_array()
            .unwrap()
            .len(),
        2
    );
}

#[test]
fn labels_take_the_place_of_the_geometry() {
    let home = Home::new();
    let truth = home.write(
        "t.csv",
        format!("Scenario_Name,Obstacle_ID\n{CUT_IN},301\n"),
    );
    let truth = truth.display().to_string();
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
    assert_eq!(document["fn"], 1);
    assert_eq!(document["differences"][0]["scenario"], CUT_IN);
    // One of two has no label.
    run(&[RED_LIGHT])
        .status(1)
        .says(&["of 2 scenarios, 1 has no label", RED_LIGHT]);
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
    assert_eq!((&document["tp"], &document["tn"]), (&2.into(), &6.into()));
    assert_eq!(document["f1"], 1.0);
    let rows = rows(&run("csv").stdout);
    assert_eq!(rows.len(), 8);
    assert!(rows.iter().all(|r| r["agrees"] == "true"), "{rows:?}");
    assert!(run("table").stdout.contains("F1 1.000"));
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
            &["reference/magic", "must be one of reference/geometry"],
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
        (&["--lead", "soon"], 2, &["paper"]),
        (&["--lead", "-1"], 2, &["seconds from 0"]),
        (&["--lead", "nan"], 2, &["seconds from 0"]),
        (&["--horizon", "11"], 2, &["up to 10"]),
        (&["--history", "0"], 2, &["1 to 100000 steps"]),
        (&["--radius", "0"], 2, &["above 0"]),
        (
            &[&broken, "--lead", "1"],
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
    let line = "nearmiss: 5 scenarios have no recorded ego: S-0, S-1, S-2 and 2 more; put NAME.ego_trajectory.csv";
    let ended = home.run(&["evaluate", "in"]).status(2).says(&[line]);
    assert_eq!(ended.stderr.lines().count(), 2, "{}", ended.stderr);
    assert!(!ended.stderr.contains("--ego"));
    home.run(&["evaluate", "in", RED_LIGHT])
        .status(1)
        .says(&[line, "of 6 scenarios, 5 have no recorded ego"]);
}

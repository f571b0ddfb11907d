//! `ask` with the built-in judge.

use super::support::program::Home;
use super::{BUNDLED, CUT_IN};

#[test]
fn the_verdict_is_one_json_document_of_a_fixed_form() {
    let home = Home::new();
    for (name, collides) in BUNDLED {
        let document = home.run(&["ask", name, "--format=json"]).status(0).json();
        assert_eq!(document["dangerous"], collides, "{name}");
        assert_eq!(document["task"], "collision");
        assert_eq!(document["verdict"]["collision"], collides, "{name}");
        assert_eq!(document["model"], "reference/geometry");
        assert!(
            document["verdict"]["justification"]
                .as_str()
                .is_some_and(|text| text.len() > 20)
        );
        let obstacles = document["verdict"]["obstacles"].as_array().unwrap();
        assert!(!obstacles.is_empty());
        for obstacle in obstacles {
            let keys: Vec<_> = obstacle.as_object().unwrap().keys().collect();
            assert_eq!(keys, ["id", "risk_score", "reason"]);
            assert!(
                obstacle["risk_score"]
                    .as_u64()
                    .is_some_and(|risk| risk <= 5)
            );
        }
        assert_eq!(obstacles[0]["risk_score"] == 0, collides, "{name}");
    }
    assert_eq!(home.runs().len(), BUNDLED.len());
}

#[test]
fn the_safety_task_has_its_own_key() {
    let home = Home::new();
    let arguments = [
        "ask",
        "ZAM_HardBraking-1_1_T-1",
        "--task",
        "safety",
        "--format=json",
    ];
    let document = home.run(&arguments).status(0).json();
    assert_eq!(
        document["dangerous"],
        document["verdict"]["safety_critical"]
    );
    let prediction = &document["prediction"];
    assert_eq!(prediction["horizon"], 2.0);
    assert_eq!(prediction["threshold"], 0.3);
    let last = prediction["last_step"].as_i64().unwrap();
    assert_eq!(prediction["first_step"].as_i64().unwrap(), last - 9);
    let first = &prediction["obstacles"][0];
    assert_eq!(first["id"], document["verdict"]["obstacles"][0]["id"]);
    assert!(
        first["probability"]
            .as_f64()
            .is_some_and(|p| p > 0.3 && p <= 1.0)
    );
    assert!(first["time"].as_f64().is_some_and(|t| t < 2.0));
}

#[test]
fn people_get_words_and_the_label_of_the_judge() {
    let home = Home::new();
    let text = home.run(&["ask", "ZAM_RedLight-1_1_T-1"]).status(0).stdout;
    for word in [
        "verdict       collision (reference/geometry)",
        "risk 0",
        "justification",
        "run ",
    ] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let text = home.run(&["ask", CUT_IN]).status(0).stdout;
    assert!(text.contains("no collision (reference/geometry)"), "{text}");
}

#[test]
fn the_same_question_has_the_same_answer() {
    let home = Home::new();
    let ask = || {
        home.run(&["ask", CUT_IN, "--format=json", "--no-store"])
            .status(0)
    };
    assert_eq!(ask().stdout, ask().stdout);
}

#[test]
fn a_run_is_kept_unless_told_otherwise() {
    let home = Home::new();
    home.run(&["ask", CUT_IN, "--no-store"]).status(0);
    assert!(!home.data().join("runs.sqlite").exists());
    home.run(&["ask", CUT_IN]).status(0);
    let runs = home.runs();
    assert_eq!(runs.len(), 1);
    let column = |name: &str| runs[0][name].as_deref();
    assert_eq!(column("scenario"), Some(CUT_IN));
    assert_eq!(column("model"), Some("reference/geometry"));
    assert_eq!(column("endpoint"), Some("built in"));
    assert_eq!(column("state"), Some("answered"));
    assert!(
        column("verdict")
            .unwrap()
            .starts_with("{\"task\":\"collision\"")
    );
}

#[test]
fn a_store_that_cannot_be_used_stops_before_anything_is_asked() {
    let home = Home::new();
    home.write(
        home.data().join("runs.sqlite"),
        "this is no database, but it is long enough to be read as one",
    );
    let ended = home
        .run(&["ask", CUT_IN])
        .status(2)
        .says(&["store", "--no-store"]);
    assert_eq!(ended.stdout, "");
    home.run(&["ask", CUT_IN, "--no-store"]).status(0);
}

#[test]
fn what_the_judge_does_not_look_at_is_said() {
    let home = Home::new();
    let ask = |more: &[&str]| home.run(&[&["ask", CUT_IN], more].concat()).status(0);
    assert_eq!(ask(&[]).stderr, "");
    let ended = ask(&["--at", "30"]).says(&["all recorded steps", "--at"]);
    assert!(ended.stdout.starts_with("verdict "), "{}", ended.stdout);
    ask(&["--history", "3"]).says(&["all recorded steps", "--history"]);
    assert_eq!(ask(&["--at", "30", "--task", "safety"]).stderr, "");
    home.run(&["ask", CUT_IN, "--history", "0"])
        .status(2)
        .says(&["1 to 100000 steps"]);
}

#[test]
fn critical_obstacles_of_the_safety_task_follow_the_probabilities() {
    let home = Home::new();
    for (name, _) in BUNDLED {
        for at in ["15", "30", "45"] {
            let ended = home.run(&["ask", name, "--task", "safety", "--at", at, "--format=json"]);
            let document = ended.status(0).json();
            let said = &document["verdict"];
            let scores = said["obstacles"].as_array().unwrap();
            let predicted = document["prediction"]["obstacles"].as_array().unwrap();
            let probability = |p: &serde_json::Value| p["probability"].as_f64().unwrap();
            let critical = |p: &&serde_json::Value| probability(p) >= 0.3;
            // The critical ones first, the most probable first; then the others by their present risk.
            let first: Vec<_> = predicted.iter().filter(critical).collect();
            let named = said["critical_obstacles"].as_array().unwrap();
            let id = |o: &serde_json::Value| o["id"].as_i64();
            let ids = |all: &[&serde_json::Value]| all.iter().map(|o| id(o)).collect::<Vec<_>>();
            assert_eq!(
                named.iter().map(id).collect::<Vec<_>>(),
                ids(&first),
                "{document}"
            );
            assert!(
                first
                    .windows(2)
                    .all(|p| probability(p[0]) >= probability(p[1]))
            );
            assert_eq!(document["dangerous"], !first.is_empty());
            for (score, predicted) in scores.iter().zip(predicted) {
                assert_eq!(score["id"], predicted["id"]);
            }
            let rest = &scores[first.len()..];
            let grave = |o: &serde_json::Value| o["risk_score"].as_u64();
            assert!(
                rest.windows(2).all(|o| grave(&o[0]) <= grave(&o[1])),
                "{document}"
            );
            let most = named.first().map_or(0.0, probability);
            assert!(said["probability"].as_f64().unwrap() >= most, "{document}");
        }
    }
}

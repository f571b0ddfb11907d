//! `generate --attackers`: several obstacles attack together.

use nearmiss::formats::commonroad;
use nearmiss::generation::Gate;
use serde_json::Value;

use super::support::program::Home;
use super::{CUT_IN, bundled_xml};

/// Very few motions and plans: what is made need not be good.
const TOLD: [&str; 7] = [
    "generate",
    CUT_IN,
    "--candidates",
    "6",
    "--set=replan=10",
    "--attackers",
    "2",
];

fn ids(line: &Value) -> Vec<i64> {
    let all = line["attackers"].as_array().unwrap().iter();
    all.map(|one| one["id"].as_i64().unwrap()).collect()
}

#[test]
fn a_variant_by_at_most_two_obstacles_passes_as_a_whole_and_is_taken_over() {
    let home = Home::new();
    let with = |more: &[&str]| home.run(&[&TOLD[..], more].concat());
    let said = with(&["--format=json", "-o", "out"]).json();
    let all = ids(&said);
    assert!((1..=2).contains(&all.len()), "{said}");
    assert!(all.contains(&said["attacker"].as_i64().unwrap()));
    for one in said["attackers"].as_array().unwrap() {
        assert!(one["asked"].is_object() && one["manoeuvre"].is_string());
        // Each of two is needed: the other one alone comes to less.
        assert_eq!(one["outcome_without"].is_string(), all.len() > 1);
        assert_ne!(one["outcome_without"], said["outcome"], "{said}");
    }
    let original = commonroad::read(bundled_xml(CUT_IN).as_bytes(), CUT_IN).unwrap();
    let file = said["variant"].as_str().unwrap();
    let variant = commonroad::read_file(&home.files().join(file)).unwrap();
    let gate = Gate::new(&original).with_attackers(all.len());
    let compared = gate.compare(&variant, None);
    assert!(compared.passed(), "{compared:?}");
    let many = all.len().to_string();
    let checked = ["generate", CUT_IN, "--check", file, "--attackers", &many];
    let passed = home.run(&checked).status(0).stdout;
    assert_eq!(passed.matches(": passes").count(), all.len(), "{passed}");

    // Once more it is the same.
    let mut again = with(&["--format=json", "-o", "again"]).json();
    let bytes = |line: &Value| {
        let path = line["variant"].as_str().unwrap();
        std::fs::read(home.files().join(path)).unwrap()
    };
    assert_eq!(bytes(&again), bytes(&said));
    for key in ["seconds", "variant", "ego"] {
        again[key] = said[key].clone();
    }
    assert_eq!(again, said);

    // An earlier run is continued, but not as one by a single attacker.
    let resumed = with(&["--format=json", "-o", "out", "--resume"]).json();
    assert_eq!(resumed["taken_over"], true);
    assert_eq!(ids(&resumed), all);
    let single = [&TOLD[..5], &["--format=json", "-o", "out", "--resume"]].concat();
    assert_eq!(home.run(&single).json()["taken_over"], false);
}

#[test]
fn how_many_attack_fits_who_may_and_where_attacks_come_from() {
    let home = Home::new();
    let refused = |more: &[&str]| {
        let all = [&["generate", CUT_IN, "--candidates", "1"], more].concat();
        home.run(&all).status(2).stderr
    };
    assert!(refused(&["--attackers", "4"]).contains("expected a number from 1 to 3"));
    let more = refused(&["--attackers", "2", "--attacker", "301"]);
    assert!(
        more.contains("--attackers 2: --attacker names 1 obstacle"),
        "{more}"
    );
    for several in [["--attackers", "2"], ["--attacker", "301,302"]] {
        let said = refused(&[&several[..], &["--model", "openai/gpt-4o"]].concat());
        assert!(said.contains("--model search"), "{said}");
    }
    assert!(refused(&["--attacker", "301,99999"]).contains("no obstacle 99999"));
}

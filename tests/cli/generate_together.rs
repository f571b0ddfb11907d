//! `generate --attackers`: several obstacles attack together.

use nearmiss::formats::commonroad;
use nearmiss::generation::Gate;
use serde_json::Value;

use super::support::program::Home;
use super::{CUT_IN, bundled_xml};

/// A scenario in which one obstacle alone reaches nothing with so few motions, and two do.
const SCENARIO: &str = "ZAM_RedLight-1_1_T-1";
const TOLD: [&str; 8] = [
    "generate",
    SCENARIO,
    "--candidates",
    "40",
    "--seed",
    "1",
    "--attackers",
    "2",
];

fn ids(line: &Value) -> Vec<i64> {
    let all = line["attackers"].as_array().unwrap().iter();
    all.map(|one| one["id"].as_i64().unwrap()).collect()
}

#[test]
fn two_obstacles_reach_what_one_does_not() {
    let home = Home::new();
    let with = |more: &[&str]| home.run(&[&TOLD[..], more].concat());
    let said = with(&["--json", "-o", "out"]).status(0).json();
    let both = ids(&said);
    assert_eq!(both.len(), 2, "{said}");
    assert!(both.contains(&said["attacker"].as_i64().unwrap()));
    for one in said["attackers"].as_array().unwrap() {
        // Each is needed: the others alone come to less.
        assert_ne!(one["outcome_without"], said["outcome"], "{said}");
        assert!(one["outcome_without"].is_string() && one["asked"].is_object());
    }
    let alone = home.run(&[&TOLD[..6], &["--json"]].concat()).json();
    assert_eq!(ids(&alone).len(), 1);
    assert_ne!(alone["outcome"], said["outcome"]);

    // The variant passes as a whole, and not where there may be one attacker only.
    let original = commonroad::read(bundled_xml(SCENARIO).as_bytes(), SCENARIO).unwrap();
    let file = said["variant"].as_str().unwrap();
    let variant = commonroad::read_file(&home.files().join(file)).unwrap();
    let compared = Gate::new(&original).compare(&variant, None);
    assert!(compared.passed(), "{compared:?}");
    let checked = ["generate", SCENARIO, "--check", file, "--style", "human"];
    let passed = home.run(&checked).status(0);
    assert_eq!(
        passed.stdout.matches(": passes").count(),
        2,
        "{}",
        passed.stdout
    );
    let single = home.run(&[&checked[..], &["--attackers", "1"]].concat());
    let single = single.status(1);
    assert!(
        single
            .stdout
            .contains("several changed obstacles: 2, at most 1")
    );

    // Once more it is the same, and an earlier run is continued.
    let mut again = with(&["--json", "-o", "again"]).json();
    let path = |line: &Value| home.files().join(line["variant"].as_str().unwrap());
    assert_eq!(
        std::fs::read(path(&again)).unwrap(),
        std::fs::read(path(&said)).unwrap()
    );
    for key in ["seconds", "variant", "ego"] {
        again[key] = said[key].clone();
    }
    assert_eq!(again, said);
    let resumed = with(&["--json", "-o", "out", "--resume"]).json();
    assert_eq!(
        (&resumed["taken_over"], ids(&resumed)),
        (&true.into(), both.clone())
    );
    let table = with(&["-o", "out", "--resume"]).stdout;
    assert!(
        table.contains(&format!("{}+{}", both[0], both[1])),
        "{table}"
    );
    assert!(table.contains("1 with 2 attackers"), "{table}");

    // Both motions of both are drawn.
    home.run(&["render", file, "-o", "picture.svg"]).status(0);
    let svg = std::fs::read_to_string(home.files().join("picture.svg")).unwrap();
    for id in both {
        assert!(svg.contains(&format!("obstacle {id} after step ")), "{id}");
    }
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

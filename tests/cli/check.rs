//! `check`: sentences about a scenario, as text and JSON, from a file and from standard input.

use serde_json::Value;

use super::support::program::Home;

const CUT_IN: &str = "ZAM_CutIn-1_1_T-1";

#[test]
fn sentences_are_held_against_the_scene() {
    let home = Home::new();
    let measured = home.run(&["metrics", CUT_IN, "--format", "json"]);
    let rows = measured.status(0).stdout;
    let row = |line: &str| serde_json::from_str::<Value>(line).unwrap();
    let at_44 = { rows.lines().map(row) }
        .find(|row| row["step"] == 44 && row["obstacle"] == 301)
        .unwrap();
    let distance = at_44["distance"].as_f64().unwrap();
    home.write(
        "said.txt",
        format!(
            "## Obstacle 301\n\nIts distance is {distance:.2} m.\n- The distance is 99.0 m.\nWe wait.\n\
             It blinks while it is moving in a strange way.\n"
        ),
    );
    let run = ["check", CUT_IN, "--text", "said.txt", "--at", "44"];
    let told = home.run(&run).status(0).stdout;
    for part in [
        "right: Its distance is",
        "wrong: - The distance is 99.0 m.",
        "3 sentences",
        "right 1, wrong 1, open 0, not understood 1",
    ] {
        assert!(told.contains(part), "{part}\n{told}");
    }
    let json = home
        .run(&[&run[..], &["--format", "json"]].concat())
        .status(0);
    let found: Vec<Value> = json.stdout.lines().map(row).collect();
    let outcomes: Vec<&str> = { found.iter() }
        .map(|one| one["outcome"].as_str().unwrap())
        .collect();
    assert_eq!(outcomes, ["right", "wrong", "not_understood"]);
    let claim = &found[1]["claims"][0];
    assert_eq!(
        (&claim["obstacle"], &claim["step"], &claim["unit"]),
        (&301.into(), &44.into(), &"m".into())
    );
    assert!(
        (claim["actual"].as_f64().unwrap() - distance).abs() < 1e-3,
        "{claim}"
    );
    home.run(&["check", CUT_IN, "--text", "nothing.txt"])
        .status(2)
        .says(&["nothing.txt"]);
    home.run(&["check", CUT_IN, "--text", "said.txt", "--at", "9999"])
        .status(2)
        .says(&["9999"]);
}

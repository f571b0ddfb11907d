//! Ratings: summed up and as a file.

use nearmiss::store::{Choice, NewRating, RatedAnswer, Store};
use nearmiss::verdict::Task;
use serde_json::Value;

use super::support::program::Home;

pub fn rate(store: &Store, choice: Choice) {
    let answer = |model: &str, prompt: &str, reason: Option<&str>| RatedAnswer {
        run: None,
        model: model.into(),
        prompt: prompt.into(),
        wrong: reason.is_some(),
        reason: reason.map(str::to_string),
        template: None,
    };
    let rating = NewRating {
        person: "ada\u{1b}[2J".into(),
        scenario: "ZAM_A-1".into(),
        task: Task::Collision,
        blind: true,
        seed: 9,
        choice,
        notes: String::new(),
        answers: vec![
            answer("lab/a", "ego · base", None),
            answer("lab/b", "ego · cp", Some("wrong numbers: \"3 m\", not 5")),
        ],
    };
    store.rate(&rating).unwrap();
}

#[test]
fn ratings_are_summed_up_and_exported() {
    let home = Home::new();
    home.run(&["runs", "ratings"])
        .status(0)
        .says(&["no ratings yet"]);
    let store = Store::open(&home.data().join("runs.sqlite")).unwrap();
    rate(&store, Choice::Best(0));
    home.run(&["runs", "ratings"])
        .status(0)
        .says(&["no strengths", "more ratings are needed"]);
    for choice in [
        Choice::Best(0),
        Choice::Best(1),
        Choice::Tie,
        Choice::AllWrong,
    ] {
        rate(&store, choice);
    }
    let table = home.run(&["runs", "ratings"]).status(0).stdout;
    // 2.5 to 1.5: ln(5/3)/2 = 0.255; the error is sqrt(1/(4·(5/8)·(3/8)))/2 = 0.516.
    let line = table.lines().nth(1).unwrap();
    assert!(
        line.starts_with("lab/a") && line.ends_with("0.26  -0.76  1.27"),
        "{table}"
    );
    let by = home
        .run(&["runs", "ratings", "--by", "prompt", "--format=json"])
        .status(0)
        .stdout;
    let first: Value = serde_json::from_str(by.lines().next().unwrap()).unwrap();
    assert_eq!(
        (&first["name"], &first["wins"], &first["wrong"]),
        (&"ego · base".into(), &2.into(), &1.into())
    );
    let path = home.files().join("ratings.csv");
    let file = path.to_str().unwrap();
    home.run(&["runs", "ratings", "export", "-o", file])
        .status(0)
        .says(&["5 ratings exported"]);
    home.run(&["runs", "ratings", "export", "-o", file])
        .status(2);
    let written = std::fs::read_to_string(&path).unwrap();
    assert_eq!(written.lines().count(), 11, "{written}");
    assert!(
        written.contains("\"wrong numbers: \"\"3 m\"\", not 5\"") && !written.contains('\u{1b}'),
        "{written}"
    );
    let lines = home.run(&["runs", "ratings", "export"]).status(0).stdout;
    let record: Value = serde_json::from_str(lines.lines().next().unwrap()).unwrap();
    assert_eq!(
        (&record["nearmiss_rating"], &record["best"]),
        (&1.into(), &0.into())
    );
    assert!(!lines.contains('\u{1b}'));
    home.run(&["runs", "ratings", "export", "-o", "a.txt"])
        .status(2)
        .says(&[".csv"]);
}

//! Requirements for continuous integration: exit status, reasons, JUnit XML, and a bundle as baseline.

use super::support::program::Home;
use super::{BUNDLED, CUT_IN};

const JUDGE: [&str; 3] = ["--model", "reference/geometry", "--samples"];

#[test]
fn what_is_not_met_ends_with_status_1_and_says_why() {
    let home = Home::new();
    let names = BUNDLED.map(|(name, _)| name);
    let all = [&["evaluate"], &names[..], &JUDGE, &["1"]].concat();
    let gate = ["--require", "n >= 1", "--require", "failed == 0"];
    home.run(&[&all[..], &gate].concat()).status(0);
    let report = |more: &[&str]| home.run(&[&["report", "--batch", "last"], more].concat());
    let met = report(&["--require", "n >= 1"]).status(0);
    assert!(!met.stderr.contains("not met"), "{}", met.stderr);
    let unmet = report(&[
        "--require",
        "n >= 1",
        "--require",
        "reference/geometry: n >= 1000",
        "--junit",
        "j.xml",
    ]);
    unmet.status(1).says(&[
        "not met: n >= 1000 (safety · reference/geometry): n is ",
        "1 of 2 requirements not met",
    ]);
    let junit = std::fs::read_to_string(home.files().join("j.xml")).unwrap();
    assert!(junit.contains("tests=\"2\" failures=\"1\""), "{junit}");
    assert!(junit.contains("name=\"n &gt;= 1000\""), "{junit}");
    // A batch that is gone on with is held against them, too.
    home.run(&["evaluate", "last", "--require", "n >= 1000"])
        .status(1)
        .says(&["not met: n >= 1000"]);
    for (requirement, words) in [
        ("recal >= 0.8", "did you mean"),
        ("f1 = = 1", "expected METRIC"),
        ("lab/x: f1 >= 0", "no such model or prompt configuration"),
    ] {
        report(&["--require", requirement]).status(2).says(&[words]);
    }
    // Refused before anything is asked.
    let batches = home.rows("SELECT * FROM batches").len();
    home.run(&["evaluate", CUT_IN, "--require", "f2 >= 1"])
        .status(2);
    assert_eq!(home.rows("SELECT * FROM batches").len(), batches);
}

#[test]
fn a_bundle_is_a_baseline_for_the_same_questions() {
    let home = Home::new();
    let names = BUNDLED.map(|(name, _)| name);
    let all = [&["evaluate"], &names[..], &JUDGE, &["1"]].concat();
    home.run(&all).status(0);
    home.run(&[
        "runs",
        "export",
        "--format=bundle",
        "--batch",
        "last",
        "-o",
        "b.nearmiss",
    ])
    .status(0);
    let against = ["--baseline-bundle", "b.nearmiss", "--no-worse-than", "0.02"];
    let batch = [&["report", "--batch", "b1"], &against[..]].concat();
    home.run(&batch).status(0);
    // Every answer turned: worse by as much as it was right.
    let store = rusqlite::Connection::open(home.data().join("runs.sqlite")).unwrap();
    let turned = "UPDATE runs SET answer = CASE WHEN instr(answer, 'true') > 0
        THEN replace(answer, 'true', 'false') ELSE replace(answer, 'false', 'true') END";
    store.execute(turned, []).unwrap();
    drop(store);
    home.run(&batch).status(1).says(&[
        "not met: no worse than the baseline by more than 0.02 (safety · reference/geometry): right of all asked differs by -",
        "common scenarios",
    ]);
    let without = [&["report"], &against[..]].concat();
    home.run(&without).status(2).says(&["--batch"]);
    home.run(&["report", "--batch", "b1", "--no-worse-than", "0.02"])
        .status(2)
        .says(&["--baseline-bundle"]);
}

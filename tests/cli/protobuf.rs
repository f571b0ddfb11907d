//! The commands on protobuf files: 2020a in one file, 2024 in three.

use nearmiss::formats::commonroad::read;
use nearmiss::scenario::Scenario;

use super::encode::{single, triple};
use super::support::program::Home;
use super::{CUT_IN, bundled_ego, bundled_xml};

fn cut_in() -> Scenario {
    read(bundled_xml(CUT_IN).as_bytes(), CUT_IN).unwrap()
}

/// What `inspect --format json` says of a file, without the hash of its bytes.
fn document(home: &Home, file: &str) -> serde_json::Value {
    let mut document = home
        .run(&["inspect", "--format=json", file])
        .status(0)
        .json();
    let hash = document.as_object_mut().unwrap().remove("hash");
    assert_eq!(hash.unwrap().as_str().map(str::len), Some(12));
    // Only the bundled scenario has its recording with it, and each file has its name.
    for key in ["ego", "file", "row", "scenario"] {
        document.as_object_mut().unwrap().remove(key);
    }
    document
}

#[test]
fn inspect_says_the_same_of_every_format() {
    let home = Home::new();
    let xml = document(&home, CUT_IN);
    home.write("single.pb", single::encode(&cut_in()));
    assert_eq!(document(&home, "single.pb"), xml);
    let names = triple::names(&cut_in());
    triple::write(&home.files(), &triple::encode(&cut_in()), &names);
    assert_eq!(document(&home, "ZAM_CutIn-1_1_T-1-SC.pb"), xml);
    home.write("ZAM_CutIn-1_1_T-1.ego_trajectory.csv", bundled_ego(CUT_IN));
    let ended = home.run(&["inspect", "ZAM_CutIn-1_1_T-1-SC.pb"]).status(0);
    for words in ["ZAM_CutIn-1_1_T-1\n", "diagnostics none", "recorded in"] {
        assert!(ended.stdout.contains(words), "{words}: {}", ended.stdout);
    }
    // The folder holds two scenarios, and one of them has a recorded ego.
    let rows = home
        .run(&["metrics", "ZAM_CutIn-1_1_T-1-SC.pb"])
        .status(0)
        .stdout;
    assert_eq!(
        rows.lines().nth(1).map(|row| row.starts_with(CUT_IN)),
        Some(true)
    );
}

#[test]
fn inspect_names_what_is_missing_and_what_is_noted() {
    let home = Home::new();
    let triple = triple::encode(&cut_in());
    home.write("ZAM_CutIn-1_1_T-1-SC.pb", &triple.scenario);
    home.run(&["inspect", "ZAM_CutIn-1_1_T-1-SC.pb"])
        .status(2)
        .says(&[
            "ZAM_CutIn-1_1_T-1-SC.pb",
            "dynamic file `ZAM_CutIn-1_1_T-1`",
            "same folder",
        ]);
    home.write("ZAM_CutIn-1.pb", &triple.map);
    let ended = home.run(&["inspect", "ZAM_CutIn-1.pb"]).status(0);
    assert!(
        ended.stdout.contains("  note: map: a map alone"),
        "{}",
        ended.stdout
    );
    assert!(!ended.stdout.contains("line 0"), "{}", ended.stdout);
    let bytes = single::encode(&cut_in());
    home.write("cut.pb", &bytes[..bytes.len() - 9]);
    home.run(&["inspect", "cut.pb"])
        .status(2)
        .says(&["cut.pb: ", "truncated"]);
    home.write("words.pb", "these are words");
    home.run(&["inspect", "words.pb"])
        .status(2)
        .says(&["words.pb: ", "CommonRoad"]);
}

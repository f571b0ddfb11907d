//! `corpus rate --like`: how often a corpus holds what scenarios do, and which drivers avoid it.

use super::index::indexed;
use super::support::program::Home;
use super::{CUT_IN, bundled_ego, bundled_xml};

const BRAKING: &str = "ZAM_HardBraking-1_1_T-1";
const RED_LIGHT: &str = "ZAM_RedLight-1_1_T-1";

#[test]
fn several_scenarios_are_rated_and_judged_and_one_without_events_stops_none() {
    let home = Home::new();
    indexed(&home);
    for name in [BRAKING, RED_LIGHT] {
        home.write(format!("some/{name}.xml"), bundled_xml(name));
        let ego = format!("some/{name}.ego_trajectory.csv");
        home.write(ego, bundled_ego(name));
    }
    let run = |more: &[&str]| {
        let like = [
            "corpus", "rate", "index", "--like", CUT_IN, "--like", "some",
        ];
        home.run(&[&like[..], more].concat())
    };
    let rated = run(&["--format=json", "-o", "axes.svg"]);
    let rated = rated.status(1).says(&[
        RED_LIGHT,
        "nobody ahead of the ego",
        "1 of 3 scenarios could not be compared",
        "wrote axes.svg",
    ]);
    let rows = rated.json_lines();
    let names: Vec<&str> = rows
        .iter()
        .filter_map(|row| row["scenario"].as_str())
        .collect();
    assert!(
        names.contains(&CUT_IN) && names.contains(&BRAKING),
        "{names:?}"
    );
    assert!(!names.contains(&RED_LIGHT));
    // The drivers are those of `nearmiss drivers`, in the same encounter.
    let judged = home
        .run(&["drivers", "some", "--format", "json"])
        .json_lines();
    let encounter = judged
        .iter()
        .find(|row| row["scenario"] == BRAKING)
        .unwrap();
    let braking = rows.iter().find(|row| row["scenario"] == BRAKING).unwrap();
    assert_eq!(braking["judged_from"], "encounter");
    for key in ["avoided", "decided"] {
        assert_eq!(braking[key], encounter[key], "{key}");
    }
    // The recorded ego and the others are never added: a row and a mark each.
    let of = |ego: &str| rows.iter().filter(|row| row["ego_source"] == ego).count();
    assert_eq!(of("recorded"), of("obstacle"));
    let svg = std::fs::read_to_string(home.files().join("axes.svg")).unwrap();
    for words in [
        "foreseeable and preventable",
        "has to be avoided",
        "recorded egos",
        "obstacle egos",
        BRAKING,
    ] {
        assert!(svg.contains(words), "{words}");
    }
    run(&["--events", "--format=csv"]).status(1);
    home.run(&["corpus", "rate", "index", "--like", RED_LIGHT])
        .status(2)
        .says(&["nobody ahead of the ego"]);
}

#[test]
fn a_variant_brings_its_drivers_in_its_manifest() {
    let home = Home::new();
    indexed(&home);
    home.run(&["generate", CUT_IN, "--candidates", "20", "-o", "variants"])
        .status(0);
    let manifest = std::fs::read_dir(home.files().join("variants")).unwrap();
    let manifest = manifest.flatten().map(|file| file.path());
    let manifest = manifest.filter(|file| file.extension().is_some_and(|end| end == "json"));
    let manifest = std::fs::read_to_string(manifest.last().unwrap()).unwrap();
    let manifest: serde_json::Value = serde_json::from_str(&manifest).unwrap();
    let rated = home.run(&[
        "corpus",
        "rate",
        "index",
        "--like",
        "variants",
        "--format=json",
    ]);
    let rows = rated.status(0).json_lines();
    for row in &rows {
        assert_eq!(row["judged_from"], "manifest");
        for key in ["avoided", "decided"] {
            assert_eq!(row[key], manifest["preventability"][key], "{key}");
        }
    }
    assert!(!rows.is_empty());
}

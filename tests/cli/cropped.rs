//! `convert` of a part of a scenario, and `inspect --diff`: measures stay, nothing new is doubted, what differs is named.

use std::collections::BTreeMap;

use nearmiss::formats::commonroad::read;
use serde_json::Value;

use super::support::program::{Ended, Home};
use super::{BUNDLED, CUT_IN, bundled_xml};

/// The part that most tests look at.
const PART: [&str; 4] = ["--from", "1s", "--to", "45"];

fn convert(home: &Home, name: &str, file: &str, more: &[&str]) -> Ended {
    home.run(&[&["convert", name, "-o", file], more].concat())
}

fn diff(home: &Home, a: &str, b: &str) -> Value {
    let arguments = ["inspect", a, b, "--diff", "--format", "json"];
    serde_json::from_str(&home.run(&arguments).stdout).unwrap()
}

/// The rows of `metrics` by step and obstacle: measures in the plane, which ask for no route of the ego.
fn measures(home: &Home, file: &str) -> BTreeMap<(String, String), Vec<String>> {
    let text = home
        .run(&["metrics", file, "--format", "csv"])
        .status(0)
        .stdout;
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    let header: Vec<String> = rows.headers().unwrap().iter().map(str::to_string).collect();
    let place = |name: &str| header.iter().position(|h| h == name).unwrap();
    let (step, obstacle) = (place("step"), place("obstacle"));
    let wanted = ["distance", "ttc", "v_rel_long", "gap_lat"].map(place);
    let rows = rows.records().map(|row| {
        let row = row.unwrap();
        let values = wanted.map(|i| row[i].to_string()).to_vec();
        ((row[step].to_string(), row[obstacle].to_string()), values)
    });
    rows.collect()
}

#[test]
fn measures_within_the_time_stay_and_nothing_new_is_doubted() {
    let home = Home::new();
    for (name, _) in BUNDLED {
        convert(
            &home,
            name,
            "part.xml",
            &[&PART[..], &["--around", "ego:60m", "--overwrite"]].concat(),
        )
        .status(0)
        .says(&["kept 36 of", "planning problem 1"]);
        let (whole, part) = (measures(&home, name), measures(&home, "part.xml"));
        assert!(part.len() > 35, "{name}");
        for (key, values) in &part {
            assert_eq!(Some(values), whole.get(key), "{name}: {key:?}");
        }
        let text = std::fs::read(home.files().join("part.xml")).unwrap();
        let warned = |bytes: &[u8]| read(bytes, name).unwrap().diagnostics.len();
        assert_eq!(
            warned(&text),
            warned(bundled_xml(name).as_bytes()),
            "{name}"
        );
        let page = home.run(&["inspect", "part.xml"]).status(0).stdout;
        assert!(page.contains("diagnostics none"), "{name}: {page}");
    }
}

#[test]
fn every_format_has_the_part() {
    let home = Home::new();
    let formats = [
        ("a.xml", "commonroad"),
        ("b.xml", "commonroad-2018b"),
        ("c.csv", "tracks"),
        ("d.csv", "interaction"),
        ("01_tracks.csv", "highd"),
    ];
    for (file, format) in formats {
        let more = ["--format", format, "--around", "ego:30m"];
        convert(&home, CUT_IN, file, &[&PART[..], &more].concat())
            .status(0)
            .says(&["kept 36 of"]);
        let page = home.run(&["inspect", file]).status(0).stdout;
        assert!(page.contains("obstacles"), "{page}");
    }
    convert(&home, CUT_IN, "e.xosc", &PART)
        .status(0)
        .says(&["step 10 became step 0"]);
    let page = home.run(&["inspect", "e.xosc"]).status(0).stdout;
    assert!(page.contains("steps 0 to 35"), "{page}");
    convert(&home, CUT_IN, "f.xml", &[&PART[..], &["--schema"]].concat())
        .status(0)
        .says(&["step 10 became step 0"]);
    let page = home.run(&["inspect", "f.xml"]).status(0).stdout;
    assert!(page.contains("steps 0 to 35"), "{page}");
}

#[test]
fn what_is_no_part_is_refused() {
    let home = Home::new();
    let refused: [(&[&str], &str); 8] = [
        (
            &["--from", "20", "--to", "10"],
            "--from is step 20, after --to",
        ),
        (&["--to", "99s"], "--to 99s: the recording has steps 0 to"),
        (&["--from", "worst"], "expected a time step"),
        (&["--drop", "7"], "no obstacle 7 in the scenario"),
        (&["--around", "0,0:5m"], "no lanelet lies within 0,0:5m"),
        (&["--around", "60m"], "ego:60m or 12.5,-3:60m"),
        (&["--from", "5", "--to", "5"], "at least two steps"),
        (&["--keep", "301", "--drop", "302"], "cannot be used with"),
    ];
    for (options, words) in refused {
        convert(&home, CUT_IN, "a.xml", options)
            .status(2)
            .says(&[words]);
        assert!(!home.files().join("a.xml").exists());
    }
    home.write("bare.xml", bundled_xml(CUT_IN));
    convert(&home, "bare.xml", "a.xml", &["--around", "ego:60m"])
        .status(2)
        .says(&["no ego to be around", "X,Y:60m"]);
}

#[test]
fn what_differs_is_named_with_its_step() {
    let home = Home::new();
    let same = home.run(&["inspect", CUT_IN, CUT_IN, "--diff"]).status(0);
    assert!(
        same.stdout.contains("equal ") && same.stdout.contains("moment "),
        "{}",
        same.stdout
    );
    convert(&home, CUT_IN, "copy.xml", &[]).status(0);
    home.run(&["inspect", CUT_IN, "copy.xml", "--diff"])
        .status(0);

    let mut moved = read(bundled_xml(CUT_IN).as_bytes(), "a").unwrap();
    let id = moved.obstacles[0].id;
    if let nearmiss::scenario::Prediction::Trajectory(states) = &mut moved.obstacles[0].prediction {
        let step = states.iter_mut().find(|s| s.time.from == 17).unwrap();
        if let Some(nearmiss::scenario::Position::Point(at)) = &mut step.position {
            at.x += 0.25;
        }
    }
    home.write(
        "moved.xml",
        nearmiss::formats::commonroad::write(&moved).unwrap(),
    );
    std::fs::copy(
        home.files().join("copy.ego_trajectory.csv"),
        home.files().join("moved.ego_trajectory.csv"),
    )
    .unwrap();
    let text = home
        .run(&["inspect", "copy.xml", "moved.xml", "--diff"])
        .status(1);
    let words = format!("obstacle {id}");
    assert!(text.stdout.contains(&words), "{}", text.stdout);
    assert!(
        text.stdout.contains("position by 0.250 m at step 17"),
        "{}",
        text.stdout
    );
    let found = diff(&home, "copy.xml", "moved.xml");
    assert_eq!(found["equal"], false);
    let changed = &found["elements"][0]["changed"][0];
    assert_eq!(
        (&changed["id"], &changed["fields"][0]["step"]),
        (&id.into(), &17.into())
    );

    convert(
        &home,
        CUT_IN,
        "part.xml",
        &[&PART[..], &["--drop", "301"]].concat(),
    )
    .status(0);
    let found = diff(&home, CUT_IN, "part.xml");
    let kinds = found["elements"].as_array().unwrap();
    let obstacles = kinds
        .iter()
        .find(|kind| kind["kind"] == "obstacle")
        .unwrap();
    assert_eq!(obstacles["only_in_a"], serde_json::json!([301]));
    for changed in obstacles["changed"].as_array().unwrap() {
        let fields = changed["fields"].as_array().unwrap();
        assert!(
            fields.iter().all(|field| field["field"] == "steps"),
            "{changed}"
        );
    }
    assert!(kinds.iter().all(|kind| kind["kind"] != "lanelet"));
    home.run(&["inspect", CUT_IN, BUNDLED[0].0, "--diff"])
        .status(1);
    home.run(&["inspect", CUT_IN, "--diff"])
        .status(2)
        .says(&["compares two scenarios, not 1"]);
    home.run(&["inspect", CUT_IN, "missing.xml", "--diff"])
        .status(2);
}

//! The paper's convention against the tables that its authors published, and against a scenario made by hand.
//!
//! The published tables are not part of this repository; see tests/published.rs for where they are looked for.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use crate::support;

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use nearmiss::formats::{Entry, commonroad, find, read_ego, read_ego_file};
use nearmiss::metrics::paper::{RADIUS, Row, rows};
use nearmiss::scenario::Scene;

use support::recorded::folder;

/// The numbers of a row as the published file writes them, by column.
fn written(row: &Row) -> Vec<(&'static str, String)> {
    let r = &row.relation;
    let time = |t: Option<f64>| t.map_or("inf".to_string(), |t| format!("{t:?}"));
    vec![
        ("relative_direction", r.direction.name().to_string()),
        ("d_long", format!("{:?}", r.d_long)),
        ("d_lat", format!("{:?}", r.d_lat)),
        ("adjusted_d_long", format!("{:?}", r.adjusted_d_long)),
        ("adjusted_d_lat", format!("{:?}", r.adjusted_d_lat)),
        ("v_rel_long", format!("{:?}", r.v_rel_long)),
        ("v_rel_lat", format!("{:?}", r.v_rel_lat)),
        ("a_rel_long", format!("{:?}", r.a_rel_long)),
        ("a_rel_lat", format!("{:?}", r.a_rel_lat)),
        ("ttc_long", time(r.ttc_long)),
        ("ttc_lat", time(r.ttc_lat)),
        ("wdominant", format!("{:?}", row.risk.wdominant)),
        ("long_dsc", row.risk.long_dsc.to_string()),
        ("lat_dsc", row.risk.lat_dsc.to_string()),
        ("dsc", format!("{:?}", row.risk.dsc)),
        ("long_tsc", row.risk.long_tsc.to_string()),
        ("lat_tsc", row.risk.lat_tsc.to_string()),
        ("tsc", format!("{:?}", row.risk.tsc)),
        ("risk_score", row.risk.risk_score.to_string()),
    ]
}

/// The two ids of a published row; some files have them as `1.0`.
fn key(record: &csv::StringRecord) -> (i64, i64) {
    let whole = |text: &str| text.parse::<f64>().unwrap() as i64;
    (whole(&record[0]), whole(&record[1]))
}

/// Holds a published table against our rows and says how many there are; every cell has to be the same text, or, for
/// the grades, the same number. Both have to have the same rows.
fn compare(table: &Path, ours: &[&Row], differences: &mut Vec<String>) -> usize {
    let by_key: HashMap<_, _> = ours
        .iter()
        .map(|row| ((row.timestep, row.obstacle), written(row)))
        .collect();
    let mut reader = csv::Reader::from_path(table).unwrap();
    let header = reader.headers().unwrap().clone();
    let place = |name: &str| header.iter().position(|h| h == name);
    let mut seen = HashSet::new();
    for record in reader.records().map(Result::unwrap) {
        let key = key(&record);
        assert!(
            seen.insert(key),
            "{}: {key:?} is there twice",
            table.display()
        );
        let Some(row) = by_key.get(&key) else {
            differences.push(format!("{}: {key:?} is missing", table.display()));
            continue;
        };
        for (name, ours) in row {
            let Some(theirs) = place(name).map(|p| &record[p]) else {
                continue;
            };
            let grade = name.ends_with("sc") && theirs.parse::<f64>().ok() == ours.parse().ok();
            if theirs != ours && !grade {
                differences.push(format!(
                    "{} {key:?} {name}: {theirs}, not {ours}",
                    table.display()
                ));
            }
        }
    }
    if seen.len() != by_key.len() {
        differences.push(format!(
            "{}: {} rows, not {}",
            table.display(),
            seen.len(),
            by_key.len()
        ));
    }
    seen.len()
}

#[test]
fn every_number_of_the_published_tables_is_reproduced() {
    let Some(folder) = folder() else { return };
    let (mut compared, mut differences) = (0, Vec::new());
    for entry in find(std::slice::from_ref(&folder)).unwrap().entries {
        let scenario = entry.read().unwrap();
        let ego = entry.recorded_ego(&scenario).unwrap().expect("a recording");
        let scene = Scene::new(scenario, ego);
        let all = rows(&scene).unwrap();
        let kind = match entry.group.as_str() {
            "normal_scenarios" => "output_validation_normal",
            _ => "output_validation",
        };
        let tables = folder.join("Results").join(kind).join(&entry.name);
        let every: Vec<_> = all.iter().collect();
        compared += compare(
            &tables.join("relative_metrics.csv"),
            &every,
            &mut differences,
        );
        let close: Vec<_> = all.iter().filter(|r| r.distance <= RADIUS).collect();
        compared += compare(
            &tables.join("close_relative_metrics.csv"),
            &close,
            &mut differences,
        );
        distances(&tables.join("close_dynamic_obstacles.csv"), &close);
    }
    println!("{compared} published rows");
    assert!(compared > 80_000, "only {compared} rows were compared");
    assert!(
        differences.is_empty(),
        "{} differences: {:#?}",
        differences.len(),
        &differences[..differences.len().min(10)]
    );
}

/// The published centre distances, which are not rounded; that table has the initial states too.
fn distances(table: &Path, close: &[&Row]) {
    let by_key: HashMap<_, _> = close
        .iter()
        .map(|r| ((r.timestep, r.obstacle), r.distance))
        .collect();
    let mut reader = csv::Reader::from_path(table).unwrap();
    let header = reader.headers().unwrap().clone();
    let place = |name: &str| header.iter().position(|h| h == name).unwrap();
    let mut found = 0;
    for record in reader.records().map(Result::unwrap) {
        let theirs: f64 = record[place("distance")].parse().unwrap();
        let (obstacle, step) = key(&record);
        if let Some(ours) = by_key.get(&(step, obstacle)) {
            found += 1;
            assert!(
                (theirs - ours).abs() < 1e-9,
                "{}: {record:?}, not {ours}",
                table.display()
            );
        }
    }
    assert_eq!(found, close.len(), "{}", table.display());
}

#[test]
fn the_published_risk_scores_are_reproduced() {
    let Some(folder) = folder() else { return };
    let (mut compared, mut differences) = (0, Vec::new());
    for name in ["BEL_Antwerp-1_14_T-1", "BEL_Antwerp-1_14_T-1n"] {
        let generation = folder.join("Generation");
        let entry = Entry::of_file(&generation.join(name).join(format!("{name}.xml")));
        let scenario = entry.read().unwrap();
        let recording = generation
            .join("Metrices")
            .join(name)
            .join("ego_trajectory.csv");
        let ego = read_ego_file(&recording, &scenario, None).unwrap();
        let all = rows(&Scene::new(scenario, ego)).unwrap();
        let close: Vec<_> = all.iter().filter(|r| r.distance <= RADIUS).collect();
        let scores = folder.join("Data_collection/Riskscore_calculation/results");
        for table in [
            generation
                .join("Metrices")
                .join(name)
                .join("close_relative_metrics.csv"),
            scores
                .join(name)
                .join("risk_scores_close_relative_metrics.csv"),
        ] {
            compared += compare(&table, &close, &mut differences);
        }
    }
    println!("{compared} published rows");
    assert!(compared > 700, "only {compared} rows were compared");
    assert!(
        differences.is_empty(),
        "{} differences: {:#?}",
        differences.len(),
        &differences[..differences.len().min(10)]
    );
}

const RECTANGLE: &str = "<shape><rectangle><length>4</length><width>2</width></rectangle></shape>";

fn state(tag: &str, step: i64, x: f64, rest: &str) -> String {
    format!(
        "<{tag}><time><exact>{step}</exact></time><position><point><x>{x}</x><y>0</y></point></position>{rest}</{tag}>"
    )
}

fn exact(heading: f64, velocity: f64) -> String {
    format!(
        "<orientation><exact>{heading}</exact></orientation><velocity><exact>{velocity}</exact></velocity>\
         <acceleration><exact>0</exact></acceleration>"
    )
}

fn dynamic(id: i64, initial: &str, states: &[String]) -> String {
    let trajectory = match states {
        [] => String::new(),
        states => format!("<trajectory>{}</trajectory>", states.concat()),
    };
    format!(
        "<dynamicObstacle id=\"{id}\"><type>car</type>{RECTANGLE}{initial}{trajectory}</dynamicObstacle>"
    )
}

/// A scene of these obstacles, with an ego that stands at step 2, where the recorder wrote a heading of 0.
fn scene(obstacles: &str) -> Scene {
    let recording = "timestep,x_position,y_position,orientation,velocity,acceleration\n\
        0,0.0,0.0,1.5,9.0,0.0\n1,0.0,1.0,1.5,0.5,-1.0\n2,0.0,1.0,0.0,0.0,0.0\n";
    scene_of(obstacles, recording)
}

fn scene_of(obstacles: &str, recording: &str) -> Scene {
    let xml = format!(
        "<commonRoad commonRoadVersion=\"2020a\" benchmarkID=\"ZAM_Test-1_1_T-1\" timeStepSize=\"0.1\">{obstacles}</commonRoad>"
    );
    let scenario = Arc::new(commonroad::read(xml.as_bytes(), "test.xml").unwrap());
    let ego = read_ego(recording.as_bytes(), "ego_trajectory.csv", &scenario, None).unwrap();
    Scene::new(scenario, ego)
}

#[test]
fn rows_are_the_states_of_trajectories_at_steps_of_the_ego() {
    let at = |tag: &str, step| state(tag, step, 20.0, &exact(0.0, 1.0));
    let states: Vec<_> = (1..9).map(|step| at("state", step)).collect();
    let initial = at("initialState", 0);
    let standing = format!(
        "<staticObstacle id=\"7\"><type>parkedVehicle</type>{RECTANGLE}{initial}</staticObstacle>"
    );
    let obstacles = [
        dynamic(9, &initial, &states),
        dynamic(8, &initial, &states[1..]),
        // Nothing after its first state, and one of whom nothing is known at the ego's steps.
        dynamic(6, &initial, &[]),
        dynamic(5, &at("initialState", 4), &states[4..]),
        standing,
    ];
    let scene = scene(&obstacles.concat());
    let all = rows(&scene).unwrap();
    let keys: Vec<_> = all.iter().map(|r| (r.timestep, r.obstacle)).collect();
    assert_eq!(keys, [(1, 9), (2, 8), (2, 9)]);
}

#[test]
fn the_recording_is_taken_with_its_defects() {
    let states = [
        state("state", 1, 20.0, &exact(0.0, 1.0)),
        state("state", 2, 20.0, &exact(0.0, 1.0)),
    ];
    let initial = state("initialState", 0, 20.0, &exact(0.0, 1.0));
    let scene = scene(&dynamic(9, &initial, &states));
    let held = scene.ego.track.at(2).unwrap().pose.heading;
    assert!(
        (held - 1.5).abs() < 1e-12,
        "the exact convention holds the heading"
    );
    let all = rows(&scene).unwrap();
    // At step 2 the heading that was written is 0, so the obstacle is straight ahead.
    assert_eq!(all[1].relation.direction.name(), "Front");
    assert_eq!(
        (all[1].relation.d_long, all[1].relation.d_lat),
        (20.0, -1.0)
    );
    assert_eq!(all[0].relation.direction.name(), "Right");
    assert_eq!(all[1].relation.ttc_long, None);
    assert_eq!(all[1].relation.v_rel_long, 1.0);
}

#[test]
fn an_obstacle_can_be_the_ego_and_has_no_row_itself() {
    let states = |x: f64| [1, 2].map(|step| state("state", step, x, &exact(0.0, 2.0)));
    let initial = |x| state("initialState", 0, x, &exact(0.0, 2.0));
    let obstacles =
        dynamic(1, &initial(0.0), &states(0.0)) + &dynamic(2, &initial(9.0), &states(9.0));
    let scenario = Arc::clone(&scene(&obstacles).scenario);
    let scene = Scene::with_obstacle_as_ego(scenario, 1).unwrap();
    let all = rows(&scene).unwrap();
    let keys: Vec<_> = all
        .iter()
        .map(|r| (r.timestep, r.obstacle, r.distance))
        .collect();
    assert_eq!(keys, [(1, 2, 9.0), (2, 2, 9.0)]);
}

#[test]
fn what_is_too_large_is_refused_where_it_is_read() {
    let text = "<commonRoad commonRoadVersion=\"2020a\" benchmarkID=\"ZAM_Test-1_1_T-1\" timeStepSize=\"0.1\"/>";
    let scenario = commonroad::read(text.as_bytes(), "test.xml").unwrap();
    let recording = "timestep,x_position,y_position,orientation,velocity,acceleration\n\
        0,0,0,0.8,0,0\n1,-1.7e308,-1.7e308,0.8,0,0\n";
    let error = read_ego(recording.as_bytes(), "ego.csv", &scenario, None).unwrap_err();
    let said = error.to_string();
    for words in ["ego.csv", "line 3", "x_position", "implausible"] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

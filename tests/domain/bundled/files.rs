//! The files, the bundle and the format.

use std::collections::BTreeSet;

use nearmiss::formats::{bundled, commonroad};
use nearmiss::scenario::Quantity;

use crate::bundled::{CASES, folder, make};

#[test]
fn files_are_what_the_program_makes() {
    for made in make::all().unwrap() {
        for (ending, bytes) in [("xml", &made.xml), ("ego_trajectory.csv", &made.csv)] {
            let file = format!("{}.{ending}", made.name);
            let there = std::fs::read(folder().join(&file)).unwrap();
            assert!(
                there == *bytes,
                "{file} is stale: cargo run --example make-scenarios"
            );
        }
    }
}

#[test]
fn the_bundle_is_the_folder() {
    let files: BTreeSet<String> = std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".xml") || name.ends_with(".csv"))
        .collect();
    let both = |name: &str| [format!("{name}.xml"), format!("{name}.ego_trajectory.csv")];
    let entries = bundled();
    let names: Vec<&str> = entries.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(files, names.iter().flat_map(|n| both(n)).collect());
    let made: Vec<&str> = CASES.iter().map(|case| case.made.name).collect();
    assert_eq!(names, made, "the order is the program's");
    for (entry, case) in entries.iter().zip(&*CASES) {
        let scenario = entry.read().unwrap();
        assert_eq!(*scenario, *case.scene.scenario, "{}", entry.name);
        let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
        assert_eq!(ego.track, case.scene.ego.track, "{}", entry.name);
    }
}

#[test]
fn they_read_without_remarks_and_survive_being_written() {
    for case in CASES.iter() {
        let (name, scenario) = (case.made.name, &case.scene.scenario);
        assert_eq!(scenario.diagnostics, [], "{name}");
        assert_eq!(scenario.header.benchmark_id, name);
        assert_eq!(scenario.header.attributes["source"], case.made.title);
        let written = commonroad::write(scenario).unwrap();
        let again = commonroad::read(&written, name).unwrap();
        assert_eq!(again, **scenario, "{name}");
        assert!(
            case.made.xml.len() < 600_000,
            "{name}: {} bytes",
            case.made.xml.len()
        );
    }
}

#[test]
fn references_lead_somewhere() {
    for case in CASES.iter() {
        let network = &case.scene.scenario.network;
        let known = |id: &i64| network.lanelet(*id).is_some();
        for lanelet in &network.lanelets {
            let mut linked = lanelet.successors.iter().chain(&lanelet.predecessors);
            assert!(
                linked.all(known),
                "{}: lanelet {}",
                case.made.name,
                lanelet.id
            );
            assert_eq!(
                lanelet.left.points.len(),
                lanelet.right.points.len(),
                "lanelet {}",
                lanelet.id
            );
        }
        let limits = network
            .signs
            .iter()
            .filter(|s| s.elements.iter().any(|e| e.id == "274"));
        assert!(limits.count() > 0, "{}: no speed limit", case.made.name);
        for goal in &case.scene.scenario.planning_problems[0].goals {
            assert!(!goal.lanelets().is_empty() && goal.lanelets().iter().all(known));
        }
    }
}

#[test]
fn the_planning_problem_begins_where_the_recording_does() {
    for case in CASES.iter() {
        let [problem] = &case.scene.scenario.planning_problems[..] else {
            panic!("{}: one planning problem is expected", case.made.name)
        };
        assert_eq!(problem.id, case.scene.ego.id);
        let first = case.scene.ego.track.at(0).unwrap();
        let initial = &problem.initial;
        assert_eq!(initial.point(), Some(first.pose.position));
        assert_eq!(
            initial.orientation,
            Some(Quantity::Exact(first.pose.heading))
        );
        assert_eq!(initial.velocity, Some(Quantity::Exact(first.velocity)));
        assert_eq!(
            initial.acceleration,
            Some(Quantity::Exact(first.acceleration))
        );
        // Every value is in the recording; only headings at standstill are not taken from it.
        let derived = case.scene.ego.track.derived;
        assert_eq!((derived.velocities, derived.accelerations), (0, 0));
    }
}

//! Tests of variants written to files and read back.

use std::path::Path;

use serde_json::Value;

use super::{CAR, behind_a_car, braking};
use crate::generation::{Avoidability, Reason, Refusal, Variant, VariantError};
use crate::planner::Forecast;
use nearmiss_formats::commonroad::{SaveError, read_file, read_solution};
use nearmiss_formats::{find_recording, read_ego_file};
use nearmiss_scene::scenario::identity::is_valid;
use nearmiss_scene::verdict::{Manoeuvre, ManoeuvreKind, Motion};

fn names(folder: &Path) -> Vec<String> {
    let files = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = files
        .map(|f| f.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn a_variant_is_read_back_as_it_was() {
    let closed = behind_a_car(60.0, Forecast::Lane);
    let change = braking(&closed, 5, 9.0);
    let effect = closed.effect(&change.clone().into()).unwrap();
    let avoidability = Avoidability::search(&closed, &effect);
    let refusal = Refusal {
        reason: Reason::Jerk,
        step: Some(7),
        value: Some(88.0),
        limit: Some(30.0),
        attacker: Some(5),
        manoeuvre: Some("hard-brake"),
    };
    let asked = Motion::Manoeuvre(Manoeuvre {
        kind: ManoeuvreKind::HardBrake,
        start: 0.5,
        duration: 1.0,
        gap: None,
        speed: Some(0.0),
    });
    let variant = Variant {
        file: "a/ZAM_HardBraking-1_1_T-1.xml",
        closed: &closed,
        change: &change.clone().into(),
        asked: &[asked],
        effect: &effect,
        avoidability: &avoidability,
        author: None,
        made: None,
        refusals: &[refusal],
        by: "a test",
    };
    let folder = tempfile::tempdir().unwrap();
    let id = variant.free_id(folder.path());
    assert!(is_valid(&id));
    assert_eq!(id, "ZAM_HardBraking-1_1_T-2");
    let saved = variant.save(folder.path(), &id, false).unwrap();
    assert_eq!(names(folder.path()).len(), 4 + saved.avoiding.len());
    assert_eq!(saved.avoiding.len(), 4);

    let read = read_file(&saved.scenario).unwrap();
    let meant = variant.scenario(&id);
    assert_eq!(read.diagnostics, []);
    assert_eq!(read.header, meant.header);
    assert_eq!(
        (&read.tags, &read.obstacles),
        (&meant.tags, &meant.obstacles)
    );
    assert_eq!(read.network, meant.network);
    assert_eq!(read.planning_problems, meant.planning_problems);
    let track = read.obstacle(CAR).unwrap().track();
    assert!(
        change
            .motions
            .iter()
            .all(|(step, motion)| track.at(*step) == Some(motion))
    );
    let source = &read.header.attributes["source"];
    let original = closed.scenario();
    for said in [
        original.hash.to_string(),
        "obstacle 700 after step 5".into(),
        "does not react".into(),
    ] {
        assert!(source.contains(&said), "{source}");
    }

    // Opened, the scenario has this ego.
    assert_eq!(find_recording(&saved.scenario).as_ref(), Some(&saved.ego));
    let track = effect.drive.track();
    let ego = read_ego_file(&saved.ego, &read, None).unwrap();
    assert_eq!(ego.recorded.len(), track.iter().count());
    for (sample, (step, motion)) in ego.recorded.iter().zip(track.iter()) {
        assert_eq!((sample.step, sample.position), (step, motion.pose.position));
        assert_eq!(sample.heading, Some(motion.pose.heading));
        assert_eq!(sample.velocity, Some(motion.velocity));
    }
    let solution = std::fs::read(&saved.solution).unwrap();
    let solution = read_solution(&solution, "solution").unwrap();
    assert_eq!(solution.scenario_id, id);
    for (delay, path) in &saved.avoiding {
        let drive = &avoidability
            .certificates
            .iter()
            .find(|(d, _)| d == delay)
            .unwrap()
            .1;
        let meant = drive.avoidance().unwrap().drive.states.len();
        assert_eq!(
            read_ego_file(path, &read, None).unwrap().recorded.len(),
            meant
        );
    }
    let document = std::fs::read(&saved.document).unwrap();
    let document: Value = serde_json::from_slice(&document).unwrap();
    assert_eq!(document["attacker"], CAR);
    assert_eq!(document["outcome"], effect.consequence.name());
    assert_eq!(document["avoidable"]["1.5"]["avoided"], true);
    assert_eq!(
        document["avoidable"]["0.5"]["trajectory"],
        format!("{id}.avoid-0.5.csv")
    );
    assert!(document["avoidable"]["0.5"]["rules_broken"].is_array());
    assert_eq!(document["rejected"][0]["reason"], "jerk");
    assert_eq!(document["min_risk_after"], effect.lowest_after().unwrap());

    // Once more: not over it, but beside it.
    let before = names(folder.path());
    let refused = variant.save(folder.path(), &id, false).unwrap_err();
    assert!(matches!(refused, VariantError::Save(SaveError::Exists(_))));
    assert_eq!(names(folder.path()), before);
    assert_eq!(variant.free_id(folder.path()), "ZAM_HardBraking-1_1_T-3");
    assert_eq!(variant.save(folder.path(), &id, true).unwrap(), saved);

    // What is in the way of one file leaves none.
    let other = tempfile::tempdir().unwrap();
    std::fs::write(other.path().join(format!("{id}.json")), "mine").unwrap();
    variant.save(other.path(), &id, false).unwrap_err();
    assert_eq!(names(other.path()), [format!("{id}.json")]);
}

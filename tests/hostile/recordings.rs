//! Recordings of other data sets open like CommonRoad files. All files are written here, from the published descriptions.
#![allow(clippy::unwrap_used)]

mod accounting;
mod argoverse;
mod damaged;
mod levelx;
mod nuplan;
mod nuplan_file;
mod one_entry;
mod parquet_file;
mod real;
mod sumo;
mod sumo_files;
mod tfrecord_file;
mod unread;
mod waymo;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss::formats::commonroad::{conform, read, write};
use nearmiss::formats::{EgoSelection, Entry, EntryLocation};
use nearmiss::scenario::{Ego, Scenario, Scene};
use nearmiss::workflow::find;

/// The scenario at a path.
#[track_caller]
fn open(path: &Path) -> Arc<Scenario> {
    Entry::of_file(path)
        .read()
        .unwrap_or_else(|error| panic!("{error}"))
}

/// Why there is none.
#[track_caller]
fn refused(path: &Path) -> String {
    Entry::of_file(path).read().unwrap_err().to_string()
}

/// A scenario in a file with several.
fn part(path: &Path, part: &str) -> PathBuf {
    PathBuf::from(format!("{}#{part}", path.display()))
}

/// The recording's own ego.
#[track_caller]
fn own_ego(path: &Path) -> (Arc<Scenario>, Ego) {
    let entry = Entry::of_file(path);
    let scenario = entry.read().unwrap();
    let ego = EgoSelection::Beside.resolve(&entry, &scenario).unwrap();
    (scenario, ego.unwrap())
}

/// The scenarios that a search of a folder finds, by what follows the folder's name.
fn found(folder: &Path) -> Vec<String> {
    let entries = find(&[folder.to_path_buf()]).unwrap().entries;
    let below = |entry: &Entry| match &entry.place {
        EntryLocation::File(path) => {
            let path = path.strip_prefix(folder).unwrap();
            path.to_string_lossy().into_owned()
        }
        EntryLocation::Bundled(_) => panic!("bundled"),
    };
    entries.iter().map(below).collect()
}

/// It is written as CommonRoad and read back the same.
#[track_caller]
fn survives_conversion(scenario: &Scenario) {
    let again = read(&write(scenario).unwrap(), "written").unwrap();
    let mut network = scenario.network.clone();
    // CommonRoad has no place for them.
    network.areas.clear();
    assert_eq!(network, again.network);
    assert_eq!(scenario.obstacles, again.obstacles);
    assert_eq!(scenario.planning_problems, again.planning_problems);
    let conformed = conform(scenario);
    assert!(
        conformed.violations.iter().all(|v| !v.contains("id")),
        "{:?}",
        conformed.violations
    );
}

/// Any track can be the ego, and the recording's own is an obstacle then.
#[track_caller]
fn any_track_can_be_the_ego(path: &Path, own: i64, other: i64) {
    let entry = Entry::of_file(path);
    let scenario = entry.read().unwrap();
    assert!(scenario.obstacle(own).is_none() && scenario.obstacle(other).is_some());
    let ego = EgoSelection::Obstacle(other)
        .resolve(&entry, &scenario)
        .unwrap()
        .unwrap();
    let scene = Scene::new(Arc::clone(&scenario), ego);
    let ids: Vec<i64> = scene.participants().map(|p| p.obstacle.id).collect();
    assert!(ids.contains(&own) && !ids.contains(&other), "{ids:?}");
    let ego = EgoSelection::Obstacle(own)
        .resolve(&entry, &scenario)
        .unwrap()
        .unwrap();
    assert_eq!(ego.id, own);
}

fn messages(scenario: &Scenario) -> String {
    let all = scenario.diagnostics.iter().map(ToString::to_string);
    all.collect::<Vec<_>>().join("\n")
}

#[track_caller]
fn near(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-9, "{a} is not {b}");
}

//! Reading CommonRoad protobuf: the same scenario as from XML, the files of 2024 beside each other, and damage.
#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "protobuf/encode.rs"]
pub mod encode;
mod hostile;
mod rich;

use std::path::{Path, PathBuf};

use encode::{single, triple};
use nearmiss::formats::commonroad::{read, read_file};
use nearmiss::formats::{Entry, EntryLocation, find};
use nearmiss::scenario::{ContentHash, Diagnostic, Scenario, Severity};
use tempfile::tempdir;

/// What is compared: everything but the hash of the bytes and what was said about them.
fn essence(scenario: &Scenario) -> Scenario {
    let mut scenario = scenario.clone();
    scenario.hash = ContentHash::digest(b"");
    scenario.diagnostics.clear();
    scenario.obstacles.sort_by_key(|o| o.role);
    scenario
}

/// The scenarios that are encoded: the bundled ones and the rich one, from XML.
fn scenarios() -> Vec<Scenario> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|x| x == "xml"))
        .collect();
    files.sort();
    assert_eq!(files.len(), 8);
    let mut all: Vec<_> = files.iter().map(|f| read_file(f).unwrap()).collect();
    all.push(rich());
    all
}

/// Whether it is said that something cannot be true, which names what it is about; `tests/untrue.rs` is about that. The
/// rich scenario has a value for everything, and few that fit together.
fn is_doubt(said: &Diagnostic) -> bool {
    let about = [
        "lanelet ",
        "sign ",
        "light ",
        "intersection ",
        "obstacle ",
        "planning problem ",
    ];
    about.iter().any(|word| said.message.starts_with(word))
}

/// What was said beside that some positions are regions or have no orientation, which all formats say, and beside what
/// cannot be true.
fn unexpected(scenario: &Scenario) -> Vec<&Diagnostic> {
    let all = scenario.diagnostics.iter();
    let of_states = ["position is a region", "no orientation in"];
    all.filter(|d| !of_states.iter().any(|words| d.message.contains(words)) && !is_doubt(d))
        .collect()
}

fn rich() -> Scenario {
    let rich = read(rich::RICH.as_bytes(), "rich.xml").unwrap();
    assert!(unexpected(&rich).is_empty());
    rich
}

/// The first part in which two scenarios differ.
fn difference(a: &Scenario, b: &Scenario) -> Option<&'static str> {
    let (m, n) = (&a.network, &b.network);
    let parts = [
        ("header", a.header == b.header),
        ("location", a.location == b.location),
        ("tags", a.tags == b.tags),
        ("lanelets", m.lanelets == n.lanelets),
        ("signs", m.signs == n.signs),
        ("lights", m.lights == n.lights),
        ("intersections", m.intersections == n.intersections),
        ("obstacles", a.obstacles == b.obstacles),
        (
            "planning problems",
            a.planning_problems == b.planning_problems,
        ),
        ("all", a == b),
    ];
    parts
        .into_iter()
        .find(|(_, same)| !same)
        .map(|(part, _)| part)
}

#[test]
fn the_single_message_is_the_same_scenario_as_the_xml() {
    for scenario in scenarios() {
        let id = &scenario.header.benchmark_id;
        let bytes = single::encode(&scenario);
        let again = read(&bytes, "scenario.pb").unwrap_or_else(|e| panic!("{id}: {e}"));
        assert!(unexpected(&again).is_empty(), "{id}");
        assert_eq!(
            difference(&essence(&scenario), &essence(&again)),
            None,
            "{id}"
        );
        assert_eq!(again.hash, ContentHash::digest(&bytes));
    }
}

/// What the files of 2024 have no field for.
fn as_of_2024(scenario: &Scenario) -> Scenario {
    let mut scenario = scenario.clone();
    for road in scenario
        .network
        .intersections
        .iter_mut()
        .flat_map(|i| &mut i.incomings)
    {
        road.is_left_of = None;
    }
    for line in scenario
        .network
        .lanelets
        .iter_mut()
        .filter_map(|l| l.stop_line.as_mut())
    {
        line.signs.clear();
        line.lights.clear();
    }
    scenario
}

#[test]
fn the_three_files_are_the_same_scenario_as_the_xml() {
    for scenario in scenarios() {
        let folder = tempdir().unwrap();
        let encoded = triple::encode(&scenario);
        let names = triple::names(&scenario);
        let file = triple::write(folder.path(), &encoded, &names);
        let again = read_file(&file).unwrap_or_else(|e| panic!("{e}"));
        assert!(unexpected(&again).is_empty(), "{}", names.scenario);
        let expected = essence(&as_of_2024(&scenario));
        assert_eq!(
            difference(&expected, &essence(&again)),
            None,
            "{}",
            names.scenario
        );
        let whole = [encoded.map, encoded.dynamic, encoded.scenario].concat();
        assert_eq!(again.hash, ContentHash::digest(&whole));
    }
}

/// The rich scenario in a folder of its own, and the scenario file's path.
fn written() -> (tempfile::TempDir, PathBuf) {
    let folder = tempdir().unwrap();
    let rich = rich();
    let file = triple::write(folder.path(), &triple::encode(&rich), &triple::names(&rich));
    (folder, file)
}

#[test]
fn parts_are_found_by_the_ids_in_them_too() {
    let (folder, file) = written();
    let whole = read_file(&file).unwrap();
    let within = |name: &str| folder.path().join(name);
    std::fs::rename(within("ZAM_Rich-3.pb"), within("road.pb")).unwrap();
    std::fs::rename(within("ZAM_Rich-3_2_T-1.pb"), within("traffic.pb")).unwrap();
    std::fs::write(within("notes.pb"), b"not a message at all").unwrap();
    assert_eq!(read_file(&file).unwrap(), whole);
    std::fs::copy(within("road.pb"), within("road again.pb")).unwrap();
    let error = read_file(&file).unwrap_err().to_string();
    assert!(error.contains("road again.pb, road.pb"), "{error}");
    assert!(
        error.contains("rename the right one to ZAM_Rich-3.pb"),
        "{error}"
    );
}

#[test]
fn a_part_with_another_id_is_taken_for_its_name_and_named() {
    let (folder, file) = written();
    let mut other = rich();
    other.header.benchmark_id = "ZAM_Other-1_1_T-1".into();
    let map = triple::encode(&other).map;
    std::fs::write(folder.path().join("ZAM_Rich-3.pb"), map).unwrap();
    let scenario = read_file(&file).unwrap();
    let said: Vec<_> = unexpected(&scenario)
        .iter()
        .map(ToString::to_string)
        .collect();
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(
        said[0].contains("needs the map `ZAM_Rich-3`"),
        "{}",
        said[0]
    );
    assert!(said[0].contains("is `ZAM_Other-1`"), "{}", said[0]);
}

#[test]
fn a_missing_part_is_named() {
    for (missing, what) in [
        ("ZAM_Rich-3.pb", "needs the map `ZAM_Rich-3`"),
        (
            "ZAM_Rich-3_2_T-1.pb",
            "needs the dynamic file `ZAM_Rich-3_2_T-1`",
        ),
    ] {
        let (folder, file) = written();
        std::fs::remove_file(folder.path().join(missing)).unwrap();
        let error = read_file(&file).unwrap_err();
        assert_eq!(error.file, file.display().to_string());
        let error = error.to_string();
        assert!(error.contains(what) && error.contains(missing), "{error}");
    }
    let (_folder, file) = written();
    let error = read(&std::fs::read(&file).unwrap(), "from memory").unwrap_err();
    assert!(
        error.message.contains("only be read in a folder"),
        "{error}"
    );
}

#[test]
fn a_map_alone_is_a_road_and_a_dynamic_file_finds_its_map() {
    let (folder, _) = written();
    let rich = as_of_2024(&rich());
    let map = read_file(&folder.path().join("ZAM_Rich-3.pb")).unwrap();
    assert_eq!(map.network.lanelets, rich.network.lanelets);
    assert_eq!(map.header.benchmark_id, "ZAM_Rich-3");
    assert!(map.planning_problems.is_empty());
    assert_eq!(
        map.obstacles.len(),
        1,
        "the environment obstacle stands on the map"
    );
    assert!(
        map.diagnostics
            .iter()
            .any(|d| d.message.contains("a map alone"))
    );
    let traffic = read_file(&folder.path().join("ZAM_Rich-3_2_T-1.pb")).unwrap();
    let obstacles = |scenario: &Scenario| essence(scenario).obstacles;
    assert_eq!(obstacles(&traffic), obstacles(&rich));
    assert_eq!(traffic.network.lights, rich.network.lights);
    assert!(traffic.planning_problems.is_empty());
    assert!(
        traffic
            .diagnostics
            .iter()
            .any(|d| d.message.contains("-SC.pb"))
    );
    std::fs::remove_file(folder.path().join("ZAM_Rich-3.pb")).unwrap();
    let error = read_file(&folder.path().join("ZAM_Rich-3_2_T-1.pb")).unwrap_err();
    assert!(error.message.contains("ZAM_Rich-3.pb"), "{error}");
}

#[test]
fn an_id_does_not_lead_out_of_the_folder() {
    let (folder, _) = written();
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    let mut rich = rich();
    rich.header.benchmark_id = "ZAM_Rich-3_2_T-1".into();
    let encoded = triple::encode(&rich);
    let tasks = String::from_utf8_lossy(&encoded.scenario).into_owned();
    assert!(tasks.contains("ZAM_Rich-3_2_T-1"));
    // The same file with an id of the same length that names the map one folder up.
    let mut bytes = encoded.scenario;
    let id: &[u8] = b"\x1a\x0aZAM_Rich-3";
    let at = bytes.windows(id.len()).position(|w| w == id).unwrap();
    bytes[at + 2..at + id.len()].copy_from_slice(b"../x/../ab");
    let file = inner.join("x-SC.pb");
    std::fs::write(&file, bytes).unwrap();
    std::fs::write(inner.join("ZAM_Rich-3_2_T-1.pb"), &encoded.dynamic).unwrap();
    std::fs::write(folder.path().join("ab.pb"), &encoded.map).unwrap();
    let error = read_file(&file).unwrap_err();
    assert!(
        error.message.contains("put it into the same folder"),
        "{error}"
    );
}

#[test]
fn a_folder_lists_each_scenario_once() {
    let (folder, file) = written();
    let within = |name: &str| folder.path().join(name);
    std::fs::write(within("single.pb"), single::encode(&rich())).unwrap();
    std::fs::write(within("graph.pb"), b"\x0a\x07\x0a\x05conv1\x12\x02ab").unwrap();
    std::fs::write(within("rich.xml"), rich::RICH).unwrap();
    let mut lonely = rich();
    lonely.header.benchmark_id = "ZAM_Lonely-1_1_T-1".into();
    std::fs::write(within("ZAM_Lonely-1.pb"), triple::encode(&lonely).map).unwrap();
    let found = find(&[folder.path().to_path_buf()]).unwrap().entries;
    let names: Vec<&str> = found.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(
        names,
        ["ZAM_Lonely-1", "ZAM_Rich-3_2_T-1", "rich", "single"]
    );
    assert_eq!(found[1].place, EntryLocation::File(file.clone()));
    for entry in &found {
        entry.read().unwrap_or_else(|e| panic!("{e}"));
    }
    assert_eq!(Entry::of_file(&file).name, "ZAM_Rich-3_2_T-1");
}

#[test]
fn the_recorded_ego_goes_with_the_name_of_the_scenario() {
    let rows = "timestep,x_position,y_position\n0,1,2\n1,2,2\n";
    for name in ["ZAM_Rich-3_2_T-1.ego_trajectory.csv", "ego_trajectory.csv"] {
        let (folder, file) = written();
        std::fs::write(folder.path().join(name), rows).unwrap();
        let entry = Entry::of_file(&file);
        let scenario = entry.read().unwrap();
        let ego = entry.recorded_ego(&scenario).unwrap();
        assert_eq!(ego.map(|ego| ego.track.steps()), Some(0..2), "{name}");
    }
}

#[test]
fn what_it_is_is_told_by_content_not_by_name() {
    let rich = rich();
    let bytes = single::encode(&rich);
    assert!(read(&bytes, "scenario.xml").is_ok());
    assert!(read(rich::RICH.as_bytes(), "scenario.pb").is_ok());
    let error = read(b"these are words", "words.pb").unwrap_err();
    assert!(
        error.message.contains("not a CommonRoad protobuf message"),
        "{error}"
    );
    assert!(
        read(b"", "nothing.pb")
            .unwrap_err()
            .message
            .contains("empty")
    );
    assert_eq!(read(b"", "nothing.xml").unwrap_err().line, 1);
}

#[test]
fn diagnostics_name_the_field_and_how_much_it_matters() {
    let mut rich = rich();
    rich.network.lanelets[0].successors.push(99);
    rich.network.lanelets[1].id = 1;
    let scenario = read(&single::encode(&rich), "x.pb").unwrap();
    let said: Vec<String> = scenario
        .diagnostics
        .iter()
        .map(ToString::to_string)
        .collect();
    let has = |text: &str| assert!(said.iter().any(|s| s.contains(text)), "{text}: {said:#?}");
    has("warning: lanelets[1]: id 1 is used twice");
    has("warning: lanelets[0]: refers to missing lanelet 99");
    has("warning: planning_problems[0]/goal_states[0]: refers to missing lanelet 2");
    assert!(
        scenario
            .diagnostics
            .iter()
            .filter(|d| !is_doubt(d))
            .all(|d| {
                let is_note = d.message.contains("no orientation in");
                (d.severity == Severity::Note) == is_note
                    && (is_note || d.severity == Severity::Warning)
                    && d.line == 0
            })
    );
}

//! Egos from every kind of file, and back: what is read is what was driven, and what is doubtful is said.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss::formats::commonroad::{ProblemSolution, Solution, read_file, write_solution};
use nearmiss::formats::{
    EgoError, bundled, find_recording, read_ego, write_recording, write_sized_recording,
};
use nearmiss::scenario::{Ego, EgoSource, Scenario, Severity, Track, VehicleModel, VehicleType};

mod log;
mod solutions;

const CUT_IN: &str = "ZAM_CutIn-1_1_T-1";

/// A bundled scenario and its recorded ego.
fn recorded(name: &str) -> (Arc<Scenario>, Ego) {
    let entry = bundled().into_iter().find(|e| e.name == name).unwrap();
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
    (scenario, ego)
}

/// The largest differences of two tracks over the same steps: position, heading, velocity.
fn apart(a: &Track, b: &Track) -> (f64, f64, f64) {
    assert_eq!(a.steps(), b.steps());
    let mut most = (0.0f64, 0.0f64, 0.0f64);
    for ((step, x), (other, y)) in a.iter().zip(b.iter()) {
        assert_eq!(step, other);
        most.0 = most.0.max((x.pose.position - y.pose.position).norm());
        most.1 = most.1.max((x.pose.heading - y.pose.heading).abs());
        most.2 = most.2.max((x.velocity - y.velocity).abs());
    }
    most
}

fn warnings(ego: &Ego) -> Vec<&str> {
    let warned = ego
        .diagnostics
        .iter()
        .filter(|d| d.severity == Severity::Warning);
    warned.map(|d| d.message.as_str()).collect()
}

fn error(text: &str, scenario: &Scenario) -> String {
    let error = read_ego(text.as_bytes(), "f", scenario, None).unwrap_err();
    error.to_string()
}

#[test]
fn the_size_of_the_vehicle_is_written_and_read_back_or_refused() {
    let (scenario, ego) = recorded(CUT_IN);
    let csv = write_sized_recording(ego.id, &ego.track, (9.5, 2.5)).unwrap();
    let again = read_ego(&csv, "again.csv", &scenario, None).unwrap();
    assert_eq!(again.footprint.shape().size(), (9.5, 2.5));
    let assumed = |ego: &Ego| {
        ego.diagnostics
            .iter()
            .any(|d| d.message.contains("no size"))
    };
    assert!(!assumed(&again));
    let text = String::from_utf8(csv).unwrap();
    let row = text.lines().nth(2).unwrap();
    for (size, said) in [
        ("0,2.5", "line 3: column `length` is `0`"),
        ("9.5,101", "line 3: column `width` is `101`"),
        ("9.4,2.5", "line 3: columns `length` and `width` differ"),
    ] {
        let changed = text.replace(row, &row.replace("9.5,2.5", size));
        let error = error(&changed, &scenario);
        assert!(error.contains(said), "{error}");
    }
    let without = text.replace(",9.5,2.5", ",,");
    let usual = read_ego(without.as_bytes(), "f", &scenario, None).unwrap();
    assert!(assumed(&usual));
}

#[test]
fn recordings_are_written_and_read_back() {
    for entry in bundled() {
        let (scenario, ego) = recorded(&entry.name);
        let csv = write_recording(ego.id, &ego.track).unwrap();
        let again = read_ego(&csv, "again.csv", &scenario, None).unwrap();
        assert_eq!(again.id, ego.id);
        assert_eq!(again.source, EgoSource::Recording("again.csv".into()));
        let (position, heading, velocity) = apart(&ego.track, &again.track);
        assert!(position == 0.0 && velocity == 0.0, "{}", entry.name);
        // Headings at standstill are not believed; they are held instead.
        assert!(heading < 1e-3, "{}: {heading}", entry.name);
        let named = read_ego(&csv, "again.csv", &scenario, Some(ego.id + 1));
        assert!(matches!(named, Err(EgoError::NoSuchProblem { .. })));
    }
}

#[test]
fn the_content_decides_and_wrong_files_are_told_apart() {
    let (scenario, ego) = recorded(CUT_IN);
    let csv = String::from_utf8(write_recording(ego.id, &ego.track).unwrap()).unwrap();
    let with_mark = format!("\u{feff}{csv}");
    assert!(read_ego(with_mark.as_bytes(), "a.xml", &scenario, None).is_ok());
    for (text, words) in [
        ("", "unknown header in line 1"),
        ("\0\0\0\0", "unknown header in line 1"),
        ("hello\nworld\n", "unknown header in line 1"),
        ("<commonRoad timeStepSize=\"0.1\"/>", "this is a scenario"),
        ("<html/>", "the root is <html>"),
        (
            "time_step;trajectory_number;unique_id;feasible\n1;2;3;True",
            "logs.csv",
        ),
        ("timestep,x_position\n0,1\n", "`y_position`"),
        ("timestep,x_position,y_position\n", "no rows"),
        (
            "timestep,x_position,y_position\n0.5,1,1\n",
            "line 2: column `timestep` is `0.5`",
        ),
        (
            "timestep,x_position,y_position\n1e300,1,1\n",
            "whole time step",
        ),
        (
            "timestep,x_position,y_position\n0,1,1\n0,1,1\n",
            "line 3: time step 0",
        ),
        (
            "timestep,x_position,y_position\n0,1,inf\n",
            "line 2: column `y_position` is `inf`; expected a finite number",
        ),
        (
            "timestep,x_position,y_position,velocity\n0,1,1,2\n\n1,1\n",
            "line 4 has 2 fields, but the header 4 columns: `y_position` is missing",
        ),
        (
            "timestep,x_position,y_position\n0,1,1,5\n",
            "line 2 has 4 fields, but the header 3 columns: `5` is one too many",
        ),
        (
            "timestep,x_position,y_position\n0,\"1,1\n1,1,1\n",
            "line 2: unclosed quote",
        ),
        ("timestep,x_position,y_position,X Position\n", "no rows"),
        (
            "Timestep,x-position,X Position,y_position\n0,1,1,1\n",
            "`x-position` and `X Position` could both be `x_position`",
        ),
        (
            "timestep,x_position,y_position,ego_id\n0,1,1,7\n1,1,1,x7\n",
            "line 3: column `ego_id` is `x7`; expected a whole number",
        ),
        (
            "timestep,x_position,y_position,ego_id\n0,1,1,7\n0,2,2,8\n1,1,1,7\n",
            "egos for the planning problems 7, 8; choose one",
        ),
        ("\u{1f}\u{8b}", "unknown header in line 1"),
    ] {
        let said = error(text, &scenario);
        assert!(
            said.starts_with("f:") && said.contains(words),
            "{text}: {said}"
        );
    }
}

#[test]
fn columns_may_be_spelled_in_another_way_and_it_is_said() {
    let (scenario, ego) = recorded(CUT_IN);
    let csv = String::from_utf8(write_recording(ego.id, &ego.track).unwrap()).unwrap();
    let (_, rows) = csv.split_once('\n').unwrap();
    let text = format!(
        "EGO ID, Time Step,\"X-Position\",yPosition,Orientation,velocity ,acceleration\n{rows}"
    );
    let again = read_ego(text.as_bytes(), "f", &scenario, None).unwrap();
    assert_eq!(apart(&ego.track, &again.track).0, 0.0);
    assert_eq!(again.id, ego.id);
    let said = again
        .diagnostics
        .iter()
        .filter(|d| d.message.contains("taken as `"));
    assert_eq!(said.count(), 5, "{:?}", again.diagnostics);
}

#[test]
fn what_is_no_text_is_named_with_what_to_do() {
    let (scenario, _) = recorded(CUT_IN);
    let said = |bytes: &[u8]| {
        let error = read_ego(bytes, "f", &scenario, None).unwrap_err();
        error.to_string()
    };
    let text = "timestep,x_position,y_position,street\n0,1,1,a\n1,1,1,caf\u{e9}\n";
    for unit in [u16::to_le_bytes, u16::to_be_bytes] {
        let marked = format!("\u{feff}{text}");
        let wide: Vec<u8> = marked.encode_utf16().flat_map(unit).collect();
        let words = said(&wide);
        assert!(
            words.contains("this is UTF-16; save it as UTF-8"),
            "{words}"
        );
    }
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    assert!(
        said(&latin).starts_with("f: line 3: column `street` is not UTF-8; save"),
        "{}",
        said(&latin)
    );
    assert!(said(&[0x1f, 0x8b, 8]).contains("this is compressed with gzip; unpack it first"));
}

#[test]
fn of_a_recording_of_several_the_ego_of_a_planning_problem_is_chosen() {
    let (scenario, ego) = recorded(CUT_IN);
    let own = String::from_utf8(write_recording(ego.id, &ego.track).unwrap()).unwrap();
    let other = String::from_utf8(write_recording(ego.id + 1, &ego.track).unwrap()).unwrap();
    let (_, other) = other.split_once('\n').unwrap();
    let both = format!("{own}{other}");
    let read = |problem| read_ego(both.as_bytes(), "f", &scenario, problem);
    let chosen = read(Some(ego.id)).unwrap();
    assert_eq!(chosen.id, ego.id);
    assert_eq!(apart(&ego.track, &chosen.track).0, 0.0);
    let left = format!(
        "{} rows of other egos ({}, {})",
        ego.track.iter().count(),
        ego.id,
        ego.id + 1
    );
    let said = chosen.diagnostics.iter();
    assert_eq!(said.filter(|d| d.message.starts_with(&left)).count(), 1);
    let ids = format!("{}, {}", ego.id, ego.id + 1);
    assert!(matches!(read(None), Err(EgoError::Several { known, .. }) if known == ids));
    let none = read(Some(-5));
    assert!(matches!(none, Err(EgoError::NoSuchProblem { known, .. }) if known == ids));
}

#[test]
fn the_ego_among_results_that_were_copied_with_a_scenario_is_found() {
    let home = tempfile::tempdir().unwrap();
    let put = |name: &str| {
        let path = home.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, "").unwrap();
        path
    };
    for (scenario, results) in [
        ("a/in/s.xml", "a/Results/output_validation/s"),
        ("b/in/s.xml", "b/in/Results/s"),
        ("c/in/s.xml", "c/in/output_validation_normal/s"),
        ("d/in/deep/s.xml", "d/Results/output_validation_normal/s"),
        ("e/normal_scenarios/s.xml", "e/output_validation_normal/s"),
        ("f/in/s.xml", "f/Metrices/s"),
    ] {
        let scenario = put(scenario);
        assert_eq!(find_recording(&scenario), None);
        let ego = put(&format!("{results}/ego_trajectory.csv"));
        assert_eq!(find_recording(&scenario), Some(ego), "{results}");
    }
    // Of this name there are two, and the folder does not tell which is meant.
    let [plain, contact, normal] = ["in", "collision_scenarios", "normal_scenarios"]
        .map(|folder| put(&format!("g/{folder}/s.xml")));
    let with_contact = put("g/Results/output_validation/s/ego_trajectory.csv");
    let without = put("g/Results/output_validation_normal/s/ego_trajectory.csv");
    assert_eq!(find_recording(&plain), None);
    assert_eq!(find_recording(&contact), Some(with_contact));
    assert_eq!(find_recording(&normal), Some(without));
}

#[test]
fn the_ego_that_lies_with_a_scenario_is_found() {
    let home = tempfile::tempdir().unwrap();
    let at = |name: &str| home.path().join(name);
    let xml = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenarios/{CUT_IN}.xml"));
    let scenario = at(&format!("{CUT_IN}.xml"));
    std::fs::copy(xml, &scenario).unwrap();
    assert_eq!(find_recording(&scenario), None);
    let put = |name: &str, text: &str| {
        let path = at(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path
    };
    let other = put(
        "solution_KS2_SM1_ZAM_CutIn-1_1_T-10_2020a.xml",
        "<CommonRoadSolution/>",
    );
    assert_eq!(find_recording(&scenario), None);
    let found = put(
        &format!("solution_KS2_SM1_{CUT_IN}_2020a.xml"),
        "<CommonRoadSolution/>",
    );
    assert_eq!(find_recording(&scenario), Some(found));
    put(
        &format!("solution_PM1_JB1_{CUT_IN}_2020a.xml"),
        "<CommonRoadSolution/>",
    );
    assert_eq!(
        find_recording(&scenario),
        None,
        "two of them, and none was chosen"
    );
    // Solutions do not count: the scenario is alone in its folder.
    let log = put("logs.csv", "");
    assert_eq!(find_recording(&scenario), Some(log));
    let log = put(&format!("{CUT_IN}/logs.csv"), "");
    assert_eq!(find_recording(&scenario), Some(log));
    let csv = put("ego_trajectory.csv", "");
    assert_eq!(find_recording(&scenario), Some(csv));
    std::fs::copy(&scenario, at("second.xml")).unwrap();
    assert_eq!(find_recording(&at("second.xml")), None);
    let csv = put(&format!("{CUT_IN}.ego_trajectory.csv"), "");
    assert_eq!(find_recording(&scenario), Some(csv));
    assert!(other.exists());
}

#[test]
fn columns_that_are_not_used_are_counted() {
    let (scenario, ego) = recorded(CUT_IN);
    let csv = String::from_utf8(write_recording(ego.id, &ego.track).unwrap()).unwrap();
    let more = csv.lines().enumerate().map(|(i, line)| match i {
        0 => format!("{line},mood\n"),
        _ => format!("{line},1\n"),
    });
    let more: String = more.collect();
    let again = read_ego(more.as_bytes(), "again.csv", &scenario, None).unwrap();
    let unused = again
        .diagnostics
        .iter()
        .filter(|d| d.severity == Severity::Unused);
    let unused: Vec<String> = unused
        .map(|d| format!("{} {}", d.message, d.element))
        .collect();
    assert_eq!(
        unused,
        [format!("{} × column mood", csv.lines().count() - 1)]
    );
}

//! Planned trajectories checked by commonroad-drivability-checker, if `NEARMISS_DRIVABILITY_PYTHON` names its Python.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use nearmiss::simulation::Rollout;
use serde_json::{Value, json};

use super::driven::{BUNDLED, Named, PUBLISHED};
use crate::support::program::skipped;

const PYTHON: &str = "NEARMISS_DRIVABILITY_PYTHON";

fn python() -> Option<PathBuf> {
    let python = std::env::var_os(PYTHON).map(PathBuf::from);
    if python.is_none() {
        skipped(&format!(
            "{PYTHON} is not set; it can name a Python that has commonroad-drivability-checker"
        ));
    }
    python
}

/// The checker puts the rear axle behind the place itself, and wants the centre.
fn states(drive: &Rollout) -> Value {
    let state = |(step, state): &(i64, nearmiss::planner::VehicleState)| {
        let centre = state.centre(&drive.limits);
        json!({
            "step": step,
            "x": centre.pose.position.x,
            "y": centre.pose.position.y,
            "heading": centre.pose.heading,
            "velocity": state.velocity,
            "yaw_rate": state.velocity * state.curvature,
            "steering": drive.limits.steering_of(state.curvature),
            "rear_to_centre": drive.limits.rear_to_centre,
        })
    };
    drive.states.iter().map(state).collect()
}

/// What the checker says of each trajectory and model: name, and the step at which it fails.
fn ask(python: &Path, trajectories: &[Value]) -> Vec<(String, String, Option<i64>)> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/support/drivability.py");
    let mut child = Command::new(python)
        .arg(script)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap_or_else(|error| panic!("{PYTHON}: {}: {error}", python.display()));
    let input = serde_json::to_vec(trajectories).unwrap();
    child.stdin.take().unwrap().write_all(&input).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "the script failed");
    let said: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap();
    said.iter()
        .map(|v| {
            let text = |key: &str| v[key].as_str().unwrap().to_owned();
            (text("name"), text("model"), v["fails_at"].as_i64())
        })
        .collect()
}

fn agrees(drives: &[Named]) {
    let Some(python) = python() else { return };
    let drives: Vec<&Named> = drives.iter().filter(|(_, d)| d.states.len() > 1).collect();
    let trajectories: Vec<Value> = drives
        .iter()
        .map(|(name, drive)| json!({"name": name, "dt": drive.dt, "states": states(drive)}))
        .collect();
    let said = ask(&python, &trajectories);
    assert_eq!(said.len(), drives.len() * 2);
    for model in ["KS", "PM"] {
        let of: Vec<_> = said.iter().filter(|(_, m, _)| m == model).collect();
        let fine = of.iter().filter(|(.., fails)| fails.is_none()).count();
        println!("{model}: {fine} of {} trajectories are feasible", of.len());
    }
    let failed: Vec<_> = said.iter().filter(|(.., fails)| fails.is_some()).collect();
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn the_checker_agrees_on_bundled_scenarios() {
    agrees(&BUNDLED);
}

#[test]
fn the_checker_agrees_on_published_scenarios() {
    if std::env::var_os(PYTHON).is_none() {
        python();
    } else if let Some(drives) = &*PUBLISHED {
        agrees(drives);
    }
}

/// The checker has to be able to say no, or the tests above say nothing.
#[test]
fn the_checker_refuses_a_jump() {
    let Some(python) = python() else { return };
    let (name, drive) = BUNDLED.iter().find(|(_, d)| d.states.len() > 20).unwrap();
    let mut jumped = drive.clone();
    jumped.states[10].1.rear.position.x += 0.5;
    let trajectory = json!({"name": name, "dt": drive.dt, "states": states(&jumped)});
    for (_, model, fails_at) in ask(&python, &[trajectory]) {
        assert_eq!(fails_at, Some(drive.states[9].0), "{model}");
    }
}

//! Generated files checked by an independent gate in Python. Skipped where there is no `python3`.

use std::path::{Path, PathBuf};
use std::process::Command;

use nearmiss::formats::commonroad;
use nearmiss::generation::{Gate, JointChange};
use nearmiss::scenario::Scenario;
use serde_json::Value;

use super::built::{drifting, driven, scenario, untouched};
use crate::support::program::skipped;

fn has_python() -> bool {
    let found = Command::new("python3")
        .arg("--version")
        .output()
        .is_ok_and(|output| output.status.success());
    if !found {
        skipped("there is no python3 here");
    }
    found
}

fn file(name: &str, scenario: &Scenario) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, commonroad::write(scenario).unwrap()).unwrap();
    path
}

fn ask(name: &str, original: &Scenario, variant: &Scenario) -> Value {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/support/variant_gate.py");
    let output = Command::new("python3")
        .arg(script)
        .arg(file(&format!("gate-{name}-original.xml"), original))
        .arg(file(&format!("gate-{name}-variant.xml"), variant))
        .output()
        .unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{words}");
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn another_gate_agrees() {
    if !has_python() {
        return;
    }
    let merge = scenario("Merge");
    let swerve = [(-2.0, -0.1), (-5.0, 0.1), (-8.0, 0.1), (-8.0, -0.1)];
    let good = driven(&merge, 304, 70, 0.0, &swerve);
    let straight = driven(&merge, 304, 70, 0.0, &[(0.0, 0.0); 4]);
    let mut jump = straight.clone();
    jump.motions[4].1.pose.position.x += 10.0;
    let mut back = untouched(&merge, 304, 70);
    back.motions[20].1.pose.position.y += 1.0;
    let gentle = driven(&merge, 302, 70, 0.0, &[(-1.0, 0.0), (-2.0, 0.0)]);
    let both = JointChange::new(vec![good.clone(), gentle]).unwrap();
    let cases: [(&str, JointChange, &[&str]); 6] = [
        ("good", good.into(), &[]),
        ("both", both, &[]),
        (
            "jump",
            jump.into(),
            &["jump", "displacement is speed times time"],
        ),
        (
            "across",
            drifting(straight, 0.0, -0.15).into(),
            &["heading along motion"],
        ),
        (
            "brakes",
            driven(&merge, 304, 70, 0.0, &[(-9.0, 0.0), (-13.0, 0.0)]).into(),
            &["jerk", "acceleration", "friction circle"],
        ),
        ("back", back.into(), &["heading along motion"]),
    ];
    for (name, change, reasons) in cases {
        let variant = change.apply(&merge).unwrap();
        let said = ask(name, &merge, &variant);
        let ours = Gate::new(&merge).compare(&variant, None);
        assert_eq!(said["passed"], ours.passed(), "{name}: {said} {ours:?}");
        assert_eq!(ours.passed(), reasons.is_empty(), "{name}");
        let violations = said["changed"][0]["violations"].as_array().unwrap();
        let named = |reason: &str| violations.iter().any(|v| v["reason"] == reason);
        for reason in reasons {
            assert!(named(reason), "{name}: no {reason} in {said}");
        }
    }
}

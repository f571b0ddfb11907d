//! Drivers: the models of UN Regulation 157 against a program of others, and all of them on recordings.

use std::fmt::Write as _;
use std::io::Write as _;
use std::process::{Command, Stdio};

use nearmiss_drive::driver::family::Case;
use nearmiss_drive::driver::{DRIVERS, driver};

use crate::support::program::skipped;

/// Every n-th case of the grids is run.
fn every() -> usize {
    let asked = std::env::var("NEARMISS_JRC_EVERY").ok();
    asked.map_or(29, |n| n.parse().expect("a number of cases"))
}

/// The grids of JRC-FSM: cut-in slow and fast, cut-out, braking.
fn grid() -> Vec<Case> {
    let kmh = |speed: f64| speed / 3.6;
    let mut cases = Vec::new();
    let fast =
        [70, 90, 110, 130].map(|speed| (speed, 30, (1..120).step_by(2).collect::<Vec<i32>>()));
    let slow = [10, 20, 30, 40, 50, 60].map(|speed| (speed, 10, (1..60).collect()));
    for (speed, step, gaps) in slow.iter().chain(&fast) {
        for other in (10..*speed).step_by(*step) {
            for gap in gaps {
                for lateral in 0..18 {
                    cases.push(Case::CutIn {
                        speed: kmh(f64::from(*speed)),
                        other: kmh(f64::from(other)),
                        gap: f64::from(*gap),
                        lateral: f64::from(lateral) * 0.1,
                    });
                }
            }
        }
    }
    for speed in (10..132).step_by(10) {
        for front in (2..152).step_by(5) {
            for lateral in 0..15 {
                cases.push(Case::CutOut {
                    speed: kmh(f64::from(speed)),
                    front: f64::from(front),
                    lateral: 0.1 + f64::from(lateral) * 0.2,
                });
            }
        }
    }
    for share in 1..20 {
        for speed in (12..130).step_by(2) {
            let deceleration = 9.81 * (f64::from(share) * 0.05);
            cases.push(Case::Braking {
                speed: kmh(f64::from(speed)),
                deceleration,
            });
        }
    }
    cases
}

fn line(id: &str, case: &Case) -> String {
    match *case {
        Case::CutIn {
            speed,
            other,
            gap,
            lateral,
        } => format!("{id},cut_in,{speed:?},{other:?},{gap:?},{lateral:?}"),
        Case::CutOut {
            speed,
            front,
            lateral,
        } => format!("{id},cut_out,{speed:?},{front:?},{lateral:?},"),
        Case::Braking {
            speed,
            deceleration,
        } => format!("{id},braking,{speed:?},{deceleration:?},,"),
    }
}

#[test]
fn four_drivers_do_what_the_joint_research_centre_s_program_says() {
    let Some(folder) = std::env::var_os("NEARMISS_JRC_FSM") else {
        skipped("NEARMISS_JRC_FSM names no checkout of JRC-FSM");
        return;
    };
    let grid = grid();
    let mut asked = String::new();
    let mut expected = Vec::new();
    for (id, case) in ["cc", "r157", "rss", "fsm"]
        .iter()
        .flat_map(|id| grid.iter().map(move |case| (id, case)))
    {
        let model = driver(id).expect("a driver");
        if let Some(result) = case.with(model) {
            expected.push((line(id, case), result));
        }
    }
    let expected: Vec<_> = expected.into_iter().step_by(every()).collect();
    for (line, _) in &expected {
        writeln!(asked, "{line}").expect("written");
    }
    let python = std::env::var("NEARMISS_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/support/jrc_fsm.py");
    let mut child = Command::new(python)
        .arg(script)
        .env("JRC_FSM", folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("python starts");
    let mut input = child.stdin.take().expect("piped");
    let writer = std::thread::spawn(move || input.write_all(asked.as_bytes()));
    let output = child.wait_with_output().expect("python ends");
    writer.join().expect("no panic").expect("written");
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let (mut differ, mut contacts, mut worst) = (Vec::new(), 0, 0.0_f64);
    for ((line, ours), answer) in expected.iter().zip(text.lines()) {
        let theirs = answer
            .strip_prefix(line.as_str())
            .expect("the same case")
            .trim_start_matches(',');
        let (closing, gap) = theirs.split_once(',').unwrap_or(("", theirs));
        let gap: f64 = gap.parse().expect("a gap");
        assert!((gap - ours.gap).abs() < 1e-9, "{answer}: {ours:?}");
        match (closing.parse::<f64>().ok(), ours.closing_speed) {
            (Some(theirs), Some(ours)) => {
                contacts += 1;
                worst = worst.max((theirs - ours).abs());
                if (theirs - ours).abs() > 1e-6 {
                    differ.push(format!("{answer} / {ours}"));
                }
            }
            (None, None) => {}
            (_, ours) => differ.push(format!("{answer} / {ours:?}")),
        }
    }
    let all = expected.len();
    println!(
        "{all} cases, {contacts} contacts, {} differ, largest difference {worst:e} m/s",
        differ.len()
    );
    for one in differ.iter().take(50) {
        println!("{one}");
    }
    assert_eq!(text.lines().count(), all);
    assert!(
        differ.len() * 1000 <= all,
        "{} of {all} differ",
        differ.len()
    );
}

#[test]
fn every_driver_says_what_it_is() {
    for driver in DRIVERS {
        for text in [
            driver.id,
            driver.name,
            driver.formula,
            driver.source,
            driver.limits,
        ] {
            assert!(
                !text.is_empty() && !text.contains("  "),
                "{}: {text}",
                driver.id
            );
        }
        for parameter in driver.parameters {
            let said = driver.formula.contains(parameter.symbol);
            assert!(
                said,
                "{}: {} is not in the formula",
                driver.id, parameter.symbol
            );
        }
    }
}

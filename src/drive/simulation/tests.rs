//! Drives whose time steps and deadlines are out of all proportion, and drives that are cancelled.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::*;
use crate::planner::{self, Cancel, Forecast, MOST_STEPS};
use nearmiss_formats::{bundled, commonroad};
use nearmiss_scene::scenario::Scenario;

fn usual() -> Settings {
    Settings {
        planner: planner::Settings::default(),
        forecast: Forecast::Lane,
        replan: 1,
        without: None,
        traffic: TrafficMode::Recorded,
        policy: None,
    }
}

/// A bundled scenario after a change of its text.
fn changed(pairs: &[(&str, &str)]) -> Scenario {
    let entries = bundled();
    let mut entries = entries.iter();
    let entry = entries.find(|e| e.name == "ZAM_RightTurn-1_1_T-1").unwrap();
    let mut xml = entry.source().unwrap();
    for (from, to) in pairs {
        assert!(xml.contains(from), "`{from}` is not in the file");
        xml = xml.replace(from, to);
    }
    commonroad::read(xml.as_bytes(), "changed.xml").unwrap()
}

#[test]
fn a_plan_never_has_more_steps_than_memory_has_room_for() {
    let planner = usual().planner;
    for dt in [10.0, 0.1, 0.01, 0.001, 1e-6, 1e-320, 0.0, f64::NAN] {
        let steps = planner.steps(dt);
        assert!((1..=MOST_STEPS).contains(&steps), "{steps} at {dt}");
    }
    assert!(planner.fits(0.01) && planner.fits(10.0));
    assert!(!planner.fits(0.001) && !planner.fits(0.0) && !planner.fits(f64::NAN));
}

#[test]
fn steps_that_are_too_short_to_plan_with_are_named() {
    let scenario = changed(&[("timeStepSize=\"0.1\"", "timeStepSize=\"0.001\"")]);
    let error = Driver::new(&scenario, &scenario.planning_problems[0], &usual());
    let words = error.unwrap_err().to_string();
    assert!(
        words.contains("0.001 s") && words.contains("4000 steps"),
        "{words}"
    );
}

#[test]
fn the_longest_steps_are_driven() {
    let scenario = changed(&[("timeStepSize=\"0.1\"", "timeStepSize=\"10\"")]);
    let driver = Driver::new(&scenario, &scenario.planning_problems[0], &usual()).unwrap();
    let driven = driver.drive(&scenario, &driver.full_span());
    assert!(driven.states.len() > 1);
}

#[test]
fn a_deadline_in_a_hundred_years_is_not_driven_to() {
    let scenario = changed(&[
        (
            "<intervalEnd>100</intervalEnd>",
            "<intervalEnd>90000</intervalEnd>",
        ),
        (
            "<intervalStart>80</intervalStart>",
            "<intervalStart>89999</intervalStart>",
        ),
    ]);
    let driver = Driver::new(&scenario, &scenario.planning_problems[0], &usual());
    let whole = driver.unwrap().full_span();
    assert_eq!(whole.last, whole.step + MOST_DRIVEN);
}

#[test]
fn a_cancelled_drive_ends_inside_a_cycle() {
    let mut settings = usual();
    // One cycle takes minutes.
    settings.planner.horizon = 10.0;
    settings.planner.sampling.durations = 12;
    settings.planner.sampling.speeds = 30;
    settings.planner.sampling.offsets = 31;
    settings.planner.sampling.changes = 6;
    let scenario = changed(&[("timeStepSize=\"0.1\"", "timeStepSize=\"0.01\"")]);
    let flag = Arc::new(AtomicBool::new(false));
    let asked = std::thread::scope(|scope| {
        let asking = scope.spawn(|| {
            std::thread::sleep(Duration::from_millis(400));
            flag.store(true, Ordering::Relaxed);
            Instant::now()
        });
        let problem = &scenario.planning_problems[0];
        let driver = Driver::new(&scenario, problem, &settings)
            .unwrap()
            .cancelled_by(&Cancel::from_flag(&flag));
        let driven = driver.drive(&scenario, &driver.full_span());
        assert_eq!((driven.cycles.len(), driven.states.len()), (0, 1));
        asking.join().unwrap()
    });
    // Without optimisation and on a busy machine.
    assert!(
        asked.elapsed() < Duration::from_secs(2),
        "{:?}",
        asked.elapsed()
    );
}

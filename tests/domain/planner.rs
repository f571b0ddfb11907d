//! The planner on the published scenarios: how many drives end without a collision.
//!
//! They are not part of this repository, see `support::recorded`; without them this test says so and ends. Built
//! without optimisation, every tenth scenario has to do.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use crate::support;

use std::sync::Arc;

use nearmiss::evaluation::default_planning;
use nearmiss::formats::{Entry, bundled, find};
use nearmiss::planner::Forecast;
use nearmiss::scenario::{ObstacleRole, Scene};
use nearmiss::simulation::{ContactSide, Driver, Outcome, Settings, TrafficMode};
use rayon::prelude::*;

/// Every so many scenarios are driven.
const EVERY: usize = if cfg!(debug_assertions) { 10 } else { 1 };

/// How many were driven, how many of them without a collision, and how many of these to the goal.
fn driven(entries: &[Entry], forecast: Forecast) -> (usize, usize, usize) {
    let settings = Settings {
        forecast,
        ..default_planning()
    };
    let some: Vec<&Entry> = entries.iter().step_by(EVERY).collect();
    let ends = some.par_iter().map(|entry| {
        let scenario = entry.read().unwrap();
        let problem = &scenario.planning_problems[0];
        support::drives::drive(&scenario, problem, &settings)
            .unwrap()
            .outcome
    });
    let ends: Vec<Outcome> = ends.collect();
    let hit = |end: &&Outcome| matches!(end, Outcome::Collision(_));
    let arrived = |end: &&Outcome| matches!(end, Outcome::Goal(_));
    (
        some.len(),
        some.len() - ends.iter().filter(hit).count(),
        ends.iter().filter(arrived).count(),
    )
}

#[test]
fn published_scenarios_are_driven_without_a_collision() {
    let Some(folder) = support::recorded::folder() else {
        return;
    };
    let of = |kind: &str| {
        let found = find(&[folder.join("Scenarios").join(kind)]).unwrap();
        assert_eq!(found.entries.len(), 30, "{kind}");
        found.entries
    };
    let (normal, critical) = (of("normal_scenarios"), of("collision_scenarios"));
    let at_least = |entries: &[Entry], forecast: Forecast, of_30: usize, arriving: usize| {
        let (count, free, arrived) = driven(entries, forecast);
        // Of fewer scenarios the same share.
        let least = of_30 * count / 30;
        assert!(free >= least, "{}: {free} of {count}", forecast.name());
        // A planner that only stops touches few, and gets nowhere.
        let least = arriving * count / 30;
        assert!(
            arrived >= least,
            "{}: {arrived} of {count} arrive",
            forecast.name()
        );
    };
    at_least(&normal, Forecast::Recorded, 29, 28);
    at_least(&critical, Forecast::Recorded, 15, 24);
    at_least(&critical, Forecast::Lane, 8, 24);
}

/// A drive in traffic that reacts, and what became of it.
struct Reactive {
    outcome: Outcome,
    /// How the same drive ends in recorded traffic.
    recorded: Outcome,
    /// Moving obstacles that the ego does not touch, and how many of them stay within 0.1 m of their recording.
    untouched: usize,
    kept: usize,
}

fn reactive(entry: &Entry) -> Reactive {
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap();
    let scene = ego.map(|ego| Arc::new(Scene::new(Arc::clone(&scenario), ego)));
    let problem = &scenario.planning_problems[0];
    let driver = Driver::new(&scenario, problem, &default_planning())
        .unwrap()
        .with_recorded(scene);
    let recorded = driver.drive(&scenario, &driver.full_span());
    let driver = driver.in_traffic(TrafficMode::Reactive);
    let drive = driver.drive(&scenario, &driver.full_span());
    let driven = drive.scenario_in(&scenario);
    let pairs = scenario.obstacles.iter().zip(&driven.obstacles);
    let moving = pairs.filter(|(old, _)| old.role == ObstacleRole::Dynamic);
    let untouched: Vec<_> = moving.filter(|(old, _)| !drive.touches(old.id)).collect();
    let kept = untouched.iter().filter(|(old, new)| {
        drive.states.iter().all(|(step, _)| {
            let (old, new) = (old.motion_at(*step), new.motion_at(*step));
            match (old, new) {
                (Some(old), Some(new)) => (old.pose.position - new.pose.position).norm() <= 0.1,
                (old, _) => old.is_none(),
            }
        })
    });
    Reactive {
        kept: kept.count(),
        untouched: untouched.len(),
        outcome: drive.outcome,
        recorded: recorded.outcome,
    }
}

/// Contacts are rarer than in recorded traffic and hardly at the ego's rear, and most obstacles do as recorded.
fn reacts_as_it_should(entries: &[&Entry]) {
    let drives: Vec<Reactive> = entries.par_iter().map(|entry| reactive(entry)).collect();
    let contact = |outcome: &Outcome| match outcome {
        Outcome::Collision(collision) => Some(collision.ego),
        _ => None,
    };
    let contacts: Vec<ContactSide> = drives.iter().filter_map(|d| contact(&d.outcome)).collect();
    let rear = contacts.iter().filter(|side| **side == ContactSide::Rear);
    assert!(rear.count() * 10 <= contacts.len(), "{contacts:?}");
    let new = drives
        .iter()
        .filter(|d| contact(&d.outcome).is_some() && contact(&d.recorded).is_none());
    assert_eq!(
        new.count(),
        0,
        "contacts that recorded traffic does not have"
    );
    let untouched: usize = drives.iter().map(|d| d.untouched).sum();
    let kept: usize = drives.iter().map(|d| d.kept).sum();
    assert!(kept * 100 >= untouched * 85, "{kept} of {untouched}");
}

#[test]
fn bundled_traffic_reacts_where_it_has_to() {
    let entries = bundled();
    reacts_as_it_should(&entries.iter().collect::<Vec<_>>());
}

#[test]
fn published_traffic_reacts_where_it_has_to() {
    let Some(folder) = support::recorded::folder() else {
        return;
    };
    let found = find(&[folder.join("Scenarios")]).unwrap();
    reacts_as_it_should(&found.entries.iter().step_by(EVERY).collect::<Vec<_>>());
}

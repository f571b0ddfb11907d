//! The planner on the published scenarios: how many drives end without a collision.
//!
//! They are not part of this repository, see `support::recorded`; without them this test says so and ends. Built
//! without optimisation, every tenth scenario has to do.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod support;

use nearmiss::evaluation::default_planning;
use nearmiss::formats::{Entry, find};
use nearmiss::planner::Forecast;
use nearmiss::simulation::{Outcome, Settings};
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

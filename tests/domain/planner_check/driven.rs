//! What the planner drives and plans can be driven, at every step.

use std::sync::LazyLock;

use nearmiss::formats::{Entry, bundled, find};
use nearmiss::planner::{Broken, Feasibility, Forecast, Settings};
use nearmiss::simulation::{self, Rollout, TrafficMode};
use rayon::prelude::*;

use crate::support::drives::drive;
use crate::support::recorded;

/// Steps that are driven of a plan before the next one.
const REPLAN: usize = 3;

/// A drive and what to call it.
pub type Named = (String, Rollout);

/// Drives through the bundled scenarios, and through the published ones where they are.
pub static BUNDLED: LazyLock<Vec<Named>> = LazyLock::new(|| drives(&bundled()));
pub static PUBLISHED: LazyLock<Option<Vec<Named>>> = LazyLock::new(|| {
    let folder = recorded::folder()?.join("Scenarios");
    let entries = find(&[folder]).unwrap().entries;
    let some: Vec<Entry> = entries.into_iter().step_by(EVERY).collect();
    Some(drives(&some))
});

/// Every so many of the published scenarios are driven: all of them take minutes where nothing is optimised.
const EVERY: usize = if cfg!(debug_assertions) { 10 } else { 1 };

/// Drives of all planning problems with all forecasts.
fn drives(entries: &[Entry]) -> Vec<Named> {
    let of = |entry: &Entry| {
        let scenario = entry.read().unwrap();
        let mut all = Vec::new();
        for problem in &scenario.planning_problems {
            for forecast in Forecast::ALL {
                let settings = simulation::Settings {
                    planner: Settings::default(),
                    forecast,
                    replan: REPLAN,
                    without: None,
                    traffic: TrafficMode::Recorded,
                    policy: None,
                };
                let name = format!("{} {} {}", entry.name, problem.id, forecast.name());
                let drive = drive(&scenario, problem, &settings);
                all.push((
                    name.clone(),
                    drive.unwrap_or_else(|e| panic!("{name}: {e}")),
                ));
            }
        }
        all
    };
    entries.par_iter().flat_map_iter(of).collect()
}

/// Everything that drives, their plans and their tracks break; says how much was checked.
fn check(drives: &[(String, Rollout)]) {
    let (mut complaints, mut steps, mut planned, mut plans, mut emergencies) =
        (Vec::new(), 0, 0, 0, 0);
    let mut friction = 0.0_f64;
    for (name, drive) in drives {
        let feasibility = Feasibility::new(drive.limits, drive.dt);
        let mut add = |what: String, broken: Vec<Broken>| {
            complaints.extend(broken.iter().map(|b| format!("{name}: {what}: {b}")));
        };
        let first = drive.states[0].0;
        let states: Vec<_> = drive.states.iter().map(|(_, state)| *state).collect();
        match feasibility.states(first, &states) {
            Ok(feasible) => {
                steps += feasible.steps;
                friction = friction.max(feasible.friction);
            }
            Err(error) => add("driven".into(), error.0),
        }
        if let Err(error) = feasibility.track(&drive.track()) {
            add("track".into(), error.0);
        }
        for cycle in &drive.cycles {
            plans += 1;
            emergencies += usize::from(cycle.plan.emergency.is_some());
            match feasibility.states(cycle.step, &cycle.plan.states) {
                Ok(feasible) => planned += feasible.steps,
                Err(error) => add(
                    format!("planned at {}, {:?}", cycle.step, cycle.plan.emergency),
                    error.0,
                ),
            }
        }
    }
    println!(
        "{} drives: {steps} steps, at most {:.1} % of the friction circle; {plans} plans, {emergencies} of them emergencies, with {planned} steps",
        drives.len(),
        friction * 100.0
    );
    assert!(steps > 0 && planned > 0);
    assert!(
        complaints.is_empty(),
        "{} broken:\n{}",
        complaints.len(),
        complaints[..complaints.len().min(60)].join("\n")
    );
}

#[test]
fn bundled_scenarios_are_driven_as_a_vehicle_can() {
    check(&BUNDLED);
}

#[test]
fn published_scenarios_are_driven_as_a_vehicle_can() {
    if let Some(drives) = &*PUBLISHED {
        check(drives);
    }
}

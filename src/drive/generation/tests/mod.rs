//! Tests of the consequences of a change: drives, certificates, files.
#![allow(clippy::unwrap_used)]

mod attackers;
mod certificates;
mod closed_loop;
mod files;
mod joint;
mod waypoints;

use std::sync::Arc;

use super::{Attack, Change, ClosedLoop, OpenLoopScreening};
use crate::planner::{Cancel, Forecast, Settings as Planning};
use crate::simulation::{Driver, Settings, TrafficMode};
use nearmiss_base::geometry::{Footprint, Shape};
use nearmiss_formats::bundled;
use nearmiss_scene::scenario::{
    Motion, Obstacle, ObstacleParts, ObstacleRole, ObstacleType, Position, Prediction, Quantity,
    Scenario, State, Steps,
};

/// The car that is changed.
const CAR: i64 = 700;

fn settings(forecast: Forecast) -> Settings {
    // Few samples: this is about drives, and not about how well they are planned.
    let mut planner = Planning::default();
    let few = &mut planner.sampling;
    (few.durations, few.speeds, few.offsets) = (2, 5, 5);
    (few.changes, few.refinements) = (1, 1);
    Settings {
        planner,
        forecast,
        replan: 1,
        without: None,
        traffic: TrafficMode::Recorded,
        policy: None,
    }
}

/// A bundled road with no obstacle on it but one car, this far (m) ahead of the ego, as fast as the ego starts.
fn behind_a_car(gap: f64, forecast: Forecast) -> ClosedLoop {
    let all = bundled();
    let entry = all.iter().find(|e| e.name.contains("HardBraking")).unwrap();
    let mut scenario = Scenario::clone(&entry.read().unwrap());
    scenario.obstacles.clear();
    let problem = scenario.planning_problems[0].clone();
    let settings = settings(forecast);
    let driver = Driver::new(&scenario, &problem, &settings).unwrap();
    let speed = problem.initial.velocity.unwrap().middle();
    let path = &driver.guide().path;
    let (first, last) = (driver.full_span().step, driver.full_span().last);
    let motion = |step: i64| {
        let s = driver.guide().start + gap + (step - first) as f64 * scenario.dt() * speed;
        (s < path.length()).then(|| Motion {
            pose: path.pose_at(s),
            velocity: speed,
            acceleration: 0.0,
        })
    };
    let states: Vec<State> = (first..=last)
        .map_while(|step| Some(state(step, &motion(step)?)))
        .collect();
    scenario.obstacles.push(car(&states, scenario.dt()));
    ClosedLoop::watched(
        Arc::new(scenario),
        &problem,
        &settings,
        &Cancel::default(),
        &mut |_, _| true,
    )
    .unwrap()
}

/// The car with these states.
fn car(states: &[State], dt: f64) -> Obstacle {
    let parts = ObstacleParts {
        id: CAR,
        role: ObstacleRole::Dynamic,
        kind: ObstacleType::Car,
        footprint: Some(Footprint::new(Shape::rectangle(4.5, 1.8)).unwrap()),
        initial: states.first().cloned(),
        prediction: Prediction::Trajectory(states[1..].to_vec()),
        signals: Vec::new(),
    };
    Obstacle::new(parts, dt)
}

fn state(step: i64, motion: &Motion) -> State {
    State {
        position: Some(Position::Point(motion.pose.position)),
        orientation: Some(Quantity::Exact(motion.pose.heading)),
        velocity: Some(Quantity::Exact(motion.velocity)),
        acceleration: Some(Quantity::Exact(motion.acceleration)),
        ..State::at(Steps::exact(step))
    }
}

/// The car brakes along the path from step `from` on, m/s², and then stands.
fn braking(closed: &ClosedLoop, from: i64, deceleration: f64) -> Change {
    let scenario = closed.scenario();
    let track = scenario.obstacle(CAR).unwrap().track();
    let (path, dt) = (&closed.driver().guide().path, scenario.dt());
    let now = *track.at(from).unwrap();
    let mut s = path.project(&now.pose.position).unwrap().s;
    let mut v = now.velocity;
    let mut motions = vec![(from, now)];
    for step in from + 1..=closed.driver().full_span().last {
        let a = deceleration.min(v / dt);
        s += v * dt - a * dt * dt / 2.0;
        v -= a * dt;
        let motion = Motion {
            pose: path.pose_at(s),
            velocity: v,
            acceleration: -a,
        };
        motions.push((step, motion));
    }
    Change {
        obstacle: CAR,
        motions,
    }
}

/// An attack with its effect, as if it had come from a search.
fn attack(closed: &ClosedLoop, change: Change, survivable: Option<bool>) -> Attack {
    let change = change.into();
    let effect = closed.effect(&change).unwrap();
    Attack {
        asked: Vec::new(),
        change,
        rehearsal: OpenLoopScreening {
            distance: 0.0,
            step: 20,
            lead: 1.0,
            speed: 10.0,
            behind: false,
        },
        implausibility: 0.0,
        effect: Some(effect),
        survivable,
    }
}

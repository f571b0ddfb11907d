//! Other futures of scenes, for tests: alike until now.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{
    Obstacle, ObstacleParts, ObstacleRole, Position, Prediction, Quantity, Sample, Scenario, Scene,
    State, Steps, Track,
};

/// The same scene until `now`; later all are elsewhere, move otherwise and give other signals, and there is an obstacle
/// more, where the ego is.
pub fn otherwise(scene: &Scene, now: i64, shift: f64) -> Scene {
    let elsewhere = |step: i64| Point::new(5e3 + shift * step as f64, -5e3);
    let dt = scene.scenario.dt();
    let obstacle = |o: &Obstacle| {
        let prediction = match &o.prediction {
            Prediction::Trajectory(later) => {
                let mut states: Vec<State> = later.clone();
                for state in states.iter_mut().filter(|s| s.time.from > now) {
                    state.position = Some(Position::Point(elsewhere(state.time.from)));
                    state.orientation = Some(Quantity::Exact(2.0));
                    state.velocity = Some(Quantity::Exact(1.0));
                    state.acceleration = Some(Quantity::Exact(-3.0));
                }
                Prediction::Trajectory(states)
            }
            other => other.clone(),
        };
        let mut signals = o.signals.clone();
        for signal in signals.iter_mut().filter(|s| s.time.from > now) {
            for (_, on) in &mut signal.signals {
                *on = !*on;
            }
        }
        let parts = ObstacleParts {
            id: o.id,
            role: o.role,
            kind: o.kind,
            footprint: o.footprint.clone(),
            initial: o.initial.clone(),
            prediction,
            signals,
        };
        Obstacle::new(parts, dt)
    };
    let beside_ego = scene.ego.track.at(now).unwrap().pose.position;
    let state = |step: i64| State {
        position: Some(Position::Point(beside_ego)),
        orientation: Some(Quantity::Exact(0.5)),
        velocity: Some(Quantity::Exact(2.0)),
        ..State::at(Steps::exact(step))
    };
    let like = { scene.scenario.obstacles.iter() }.find(|o| o.role == ObstacleRole::Dynamic);
    let more = like.map(|like| {
        let parts = ObstacleParts {
            id: 999_999,
            role: like.role,
            kind: like.kind,
            footprint: like.footprint.clone(),
            initial: Some(state(now + 1)),
            prediction: Prediction::Trajectory((now + 2..now + 9).map(state).collect()),
            signals: Vec::new(),
        };
        Obstacle::new(parts, dt)
    });
    let obstacles = scene.scenario.obstacles.iter().map(obstacle);
    let scenario = Scenario {
        obstacles: obstacles.chain(more).collect(),
        planning_problems: Vec::new(),
        ..Scenario::clone(&scene.scenario)
    };
    let mut ego = scene.ego.clone();
    let samples = ego.track.iter().map(|(step, motion)| Sample {
        step,
        position: if step > now {
            elsewhere(step)
        } else {
            motion.pose.position
        },
        heading: Some(if step > now { 2.0 } else { motion.pose.heading }),
        velocity: Some(if step > now { 1.0 } else { motion.velocity }),
        acceleration: Some(if step > now {
            -3.0
        } else {
            motion.acceleration
        }),
    });
    ego.track = Track::new(samples.collect(), dt, None);
    Scene::new(Arc::new(scenario), ego)
}

/// A scene whose ego is recorded without speeds, and drives `metres` farther in each step than it did.
pub fn without_speeds(scene: &Scene, metres: f64) -> Scene {
    let mut ego = scene.ego.clone();
    let first = ego.track.steps().start;
    let samples = ego.track.iter().map(|(step, motion)| Sample {
        step,
        position: motion.pose.position + motion.pose.forward() * (metres * (step - first) as f64),
        heading: Some(motion.pose.heading),
        velocity: None,
        acceleration: None,
    });
    ego.track = Track::new(samples.collect(), scene.scenario.dt(), None);
    Scene::new(Arc::clone(&scene.scenario), ego)
}

/// The same scene until `now`; later the ego drives its way at half the speed.
pub fn slower(scene: &Scene, now: i64) -> Scene {
    let track = &scene.ego.track;
    let mut ego = scene.ego.clone();
    let sample = |step: i64| {
        let (place, half) = if step > now {
            (now + (step - now) / 2, (step - now) % 2 == 1)
        } else {
            (step, false)
        };
        let here = track.at(place)?;
        let next = track.at(place + i64::from(half))?;
        let between = (next.pose.position - here.pose.position) * 0.5;
        let speed = if step > now { 0.5 } else { 1.0 };
        Some(Sample {
            step,
            position: here.pose.position + if half { between } else { between * 0.0 },
            heading: Some(here.pose.heading),
            velocity: Some(here.velocity * speed),
            acceleration: Some(here.acceleration),
        })
    };
    let samples = track.steps().filter_map(sample);
    ego.track = Track::new(samples.collect(), scene.scenario.dt(), None);
    Scene::new(Arc::clone(&scene.scenario), ego)
}

/// The same scene until `now`; later all obstacles stand where they are, and the ego drives as it did.
pub fn stopped(scene: &Scene, now: i64) -> Scene {
    let dt = scene.scenario.dt();
    let obstacle = |o: &Obstacle| {
        let mut prediction = o.prediction.clone();
        if let Prediction::Trajectory(states) = &mut prediction
            && let Some(last) = states.iter().rfind(|s| s.time.from <= now).cloned()
        {
            for state in states.iter_mut().filter(|s| s.time.from > now) {
                state.position.clone_from(&last.position);
                state.orientation.clone_from(&last.orientation);
                state.velocity = Some(Quantity::Exact(0.0));
                state.acceleration = Some(Quantity::Exact(0.0));
            }
        }
        let parts = ObstacleParts {
            id: o.id,
            role: o.role,
            kind: o.kind,
            footprint: o.footprint.clone(),
            initial: o.initial.clone(),
            prediction,
            signals: o.signals.clone(),
        };
        Obstacle::new(parts, dt)
    };
    let scenario = Scenario {
        obstacles: scene.scenario.obstacles.iter().map(obstacle).collect(),
        planning_problems: Vec::new(),
        ..Scenario::clone(&scene.scenario)
    };
    Scene::new(Arc::new(scenario), scene.ego.clone())
}

//! Tools answer from the window alone, with the numbers of the measures, whatever the future; mistakes are told in words.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use nearmiss_base::geometry::Point;
use nearmiss_formats::bundled;
use nearmiss_scene::metrics::{MEASURES, Thresholds};
use nearmiss_scene::scenario::{
    Obstacle, ObstacleParts, ObstacleRole, Position, Prediction, Quantity, Sample, Scenario, Scene,
    State, Steps, Track, Window,
};
use serde_json::{Value, json};

use super::*;

fn scene(at: usize) -> Scene {
    let entry = &bundled()[at];
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
    Scene::new(scenario, ego)
}

fn view(scene: &Scene, last: i64) -> WindowView<'_> {
    WindowView::new(
        scene,
        Thresholds::shipped(),
        Window::ending_at(scene, last, 10),
    )
}

/// Every call of a tool that makes sense about a window.
fn calls(view: &WindowView<'_>) -> Vec<(&'static str, Value)> {
    let mut calls = Vec::new();
    let ids: Vec<i64> = view.there().iter().map(|(_, p)| p.obstacle.id).collect();
    let with = |name: &'static str, mut arguments: Value, id: i64, t: f64| {
        let tool = TOOLS.iter().find(|tool| tool.name == name).unwrap();
        for argument in (tool.arguments)() {
            match argument.key {
                "obstacle" | "participant" => arguments[argument.key] = id.into(),
                "t" => arguments["t"] = t.into(),
                _ => {}
            }
        }
        (name, arguments)
    };
    for t in [-0.3, 0.0]
        .into_iter()
        .skip(usize::from(view.there().len() > 6))
    {
        for tool in TOOLS {
            for id in ids.iter().copied().chain([0]) {
                if tool.name != "measure" {
                    calls.push(with(tool.name, json!({}), id, t));
                }
            }
        }
        for measure in MEASURES {
            for id in &ids {
                calls.push(with("measure", json!({"id": measure.id}), *id, t));
            }
        }
    }
    calls
}

#[test]
fn another_future_changes_no_answer_of_a_tool() {
    let (mut values, mut refused) = (0, 0);
    for at in 0..bundled().len() {
        let recorded = scene(at);
        for now in [12, 28] {
            for shift in [40.0] {
                let other = otherwise(&recorded, now, shift);
                let (here, there) = (view(&recorded, now), view(&other, now));
                for (name, arguments) in calls(&here) {
                    let text = arguments.to_string();
                    let said = call(&here, name, &text);
                    let changed = call(&there, name, &text);
                    assert_eq!(said, changed, "{at} {now} {name} {text}");
                    values += usize::from(said.is_ok());
                    refused += usize::from(said.is_err());
                }
            }
        }
    }
    assert!(values > 1000 && refused > 100, "{values} {refused}");
}

#[test]
fn what_a_window_does_not_tell_yet_is_refused() {
    let recorded = scene(0);
    let scenes = [0.0, 3.0].map(|metres| without_speeds(&recorded, metres));
    let first = scenes[0].ego.track.steps().start;
    let views = [view(&scenes[0], first), view(&scenes[1], first)];
    let mut unknown = 0;
    for (name, arguments) in calls(&views[0]) {
        let text = arguments.to_string();
        let said = views.each_ref().map(|view| call(view, name, &text));
        assert_eq!(said[0], said[1], "{name} {text}");
        let why = said[0].as_ref().err().map(ToString::to_string);
        unknown += usize::from(why.is_some_and(|why| why.contains("not known yet")));
    }
    assert!(unknown > 10, "{unknown}");
    let state = |last: i64, t: f64| {
        let text = json!({"participant": 0, "t": t}).to_string();
        call(&view(&scenes[0], last), "get_state", &text)
    };
    // A step later all is known, also of the moment before.
    let later = state(first + 1, -scenes[0].scenario.dt()).unwrap();
    assert!(later.get("acceleration").is_some(), "{later}");
}

#[test]
fn measures_that_read_ahead_do_tell_the_future() {
    let mut told: std::collections::BTreeSet<&str> = std::collections::BTreeSet::new();
    let mut silent: std::collections::BTreeSet<&str> = MEASURES.iter().map(|m| m.id).collect();
    for at in 0..bundled().len() {
        let recorded = scene(at);
        let futures = [12, 20, 28, 35].into_iter().flat_map(|now| {
            [
                otherwise(&recorded, now, 40.0),
                // What needs a crossing of paths, or a lead in the lane, is not in each future.
                slower(&recorded, now),
                stopped(&recorded, now),
            ]
            .map(|other| (now, other))
        });
        for (now, other) in futures {
            let whole = [&recorded, &other].map(|scene| {
                let full = nearmiss_scene::metrics::Context::new(scene);
                let ahead = full.during(&Window::ending_at(scene, now, 10));
                (full, ahead)
            });
            // One future may have an obstacle more, the last one.
            let both = whole[0].0.participants().len();
            for measure in MEASURES {
                let read = |context: &nearmiss_scene::metrics::Context<'_>| -> Vec<_> {
                    (0..both)
                        .map(|p| context.encounter(p, now).map(|e| measure.compute(&e)))
                        .collect()
                };
                if read(&whole[0].0) != read(&whole[1].0) {
                    told.insert(measure.id);
                }
                if read(&whole[0].1) != read(&whole[1].1) {
                    silent.remove(measure.id);
                }
            }
        }
    }
    assert_eq!(
        silent.len(),
        MEASURES.len(),
        "none looks past a window's end"
    );
    for measure in MEASURES.iter().filter(|m| m.reads_ahead) {
        assert!(
            told.contains(measure.id),
            "{} does not read ahead",
            measure.id
        );
    }
    for id in ["distance", "ttc", "risk", "wttc", "gap_long", "v_rel_long"] {
        assert!(!told.contains(id), "{id} reads ahead");
    }
}

#[test]
fn nothing_after_the_window_can_be_asked() {
    let recorded = scene(0);
    let view = view(&recorded, 20);
    let id = view.there()[0].1.obstacle.id;
    let said = |name: &str, arguments: Value| {
        call(&view, name, &arguments.to_string())
            .unwrap_err()
            .to_string()
    };
    let late = said("distance", json!({"obstacle": id, "t": 0.5}));
    assert!(late.contains("nothing after t = 0 can be asked"), "{late}");
    let early = said("get_state", json!({"participant": 0, "t": -5}));
    assert!(early.contains("begins at t = -0.90 s"), "{early}");
    for measure in MEASURES.iter().filter(|m| m.reads_ahead) {
        let refused = said("measure", json!({"id": measure.id, "obstacle": id}));
        assert!(refused.contains("expected one of distance"), "{refused}");
    }
}

#[test]
fn mistakes_are_told_in_words() {
    let recorded = scene(0);
    let view = view(&recorded, 20);
    let said = |name: &str, text: &str| call(&view, name, text).unwrap_err().to_string();
    assert!(said("distanse", "{}").contains("distance"));
    assert!(said("distance", "{").contains("no JSON"));
    assert!(said("distance", "[1]").contains("no JSON object"));
    assert!(said("distance", "{}").contains("`obstacle` is missing"));
    assert!(said("distance", r#"{"obstacle": 1.5}"#).contains("the id of an obstacle"));
    assert!(said("distance", r#"{"obstacle": 424242}"#).contains("no obstacle 424242"));
    assert!(said("distance", r#"{"obstacle": 1, "tim": 0}"#).contains("unknown argument `tim`"));
    assert!(said("distance", &"9".repeat(20_000)).contains("at most"));
    assert!(said("list_obstacles", r#"{"radius": 1e99}"#).contains("0 to 10000 m"));
    assert!(said("measure", r#"{"id": "nix", "obstacle": 304}"#).contains("expected one of"));
    let text = format!(r#"{{"obstacle": "{}"}}"#, view.there()[0].1.obstacle.id);
    assert!(call(&view, "distance", &text).is_ok());
}

#[test]
fn results_agree_with_the_measures_and_their_schemas() {
    let recorded = scene(0);
    let view = view(&recorded, 20);
    for (place, p) in view.there() {
        let encounter = view.context().encounter(*place, 20).unwrap();
        let arguments = json!({"obstacle": p.obstacle.id}).to_string();
        let said = call(&view, "distance", &arguments).unwrap();
        let apart = said["distance"].as_f64().unwrap();
        assert!((apart - encounter.distance()).abs() < 1e-3);
        let arguments = json!({"obstacle": p.obstacle.id, "id": "ttc"}).to_string();
        let measured = call(&view, "measure", &arguments).unwrap();
        let arguments = json!({"obstacle": p.obstacle.id}).to_string();
        let ttc = call(&view, "time_to_collision", &arguments).unwrap();
        assert_eq!(measured.get("value"), ttc.get("ttc"));
    }
    for (name, arguments) in calls(&view) {
        let Ok(said) = call(&view, name, &arguments.to_string()) else {
            continue;
        };
        let tool = TOOLS.iter().find(|tool| tool.name == name).unwrap();
        let valid = jsonschema::validator_for(&(tool.result_schema)()).unwrap();
        assert!(valid.is_valid(&said), "{name} {arguments}: {said}");
        let valid = jsonschema::validator_for(&(tool.arguments_schema)()).unwrap();
        assert!(
            name == "measure" || valid.is_valid(&arguments),
            "{name} {arguments}"
        );
    }
    assert!(table().contains("### predict_constant_velocity"));
}

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

//! Messages, trajectories and answers of the planner protocol.

use std::sync::Arc;

use serde_json::{Value, json};

use super::messages::{SceneMessageBuilder, hello};
use super::protocol::{Message, PlannedState, Ready, ReferencePoint, Trajectory};
use super::reading::{Reader, answer, joined, ready};
use super::{PlannerFault, *};
use crate::planner::{self, Forecast, Limits, VehicleState};
use crate::simulation::{Driver, Settings};
use nearmiss_base::geometry::Pose;
use nearmiss_formats::bundled;
use nearmiss_scene::scenario::{Obstacle, ObstacleParts, Prediction, Scenario, VehicleType};

fn limits() -> Limits {
    Limits::for_vehicle(VehicleType::Bmw320i)
}

fn at(x: f64, y: f64, heading: f64, velocity: f64) -> PlannedState {
    PlannedState {
        t: None,
        x,
        y,
        heading,
        velocity,
        acceleration: None,
        steering: None,
    }
}

fn read(
    states: Vec<PlannedState>,
    point: ReferencePoint,
) -> Result<Vec<VehicleState>, PlannerFault> {
    let now = VehicleState {
        rear: Pose::new(0.0, 0.0, 0.0),
        velocity: 10.0,
        acceleration: 0.0,
        curvature: 0.0,
    };
    let limits = limits();
    let reader = Reader {
        limits: &limits,
        dt: 0.1,
        point,
    };
    let trajectory = Trajectory {
        step: 0,
        states,
        ms: None,
    };
    reader
        .states(&trajectory, &now)
        .map_err(|fault| fault.fault)
}

#[test]
fn a_trajectory_becomes_states_at_the_steps() {
    let straight = (0..4).map(|k| at(f64::from(k), 0.0, 0.0, 10.0 + f64::from(k)));
    let states = read(straight.collect(), ReferencePoint::RearAxle).unwrap();
    assert_eq!(states.len(), 4);
    assert!((states[1].acceleration - 10.0).abs() < 1e-9 && states[2].curvature == 0.0);
    // Half as many states, with their times: between them on a line.
    let timed = |t: f64, x: f64| PlannedState {
        t: Some(t),
        ..at(x, 0.0, 0.0, 10.0)
    };
    let sparse = vec![timed(0.0, 0.0), timed(0.2, 2.0), timed(0.35, 3.5)];
    let states = read(sparse, ReferencePoint::RearAxle).unwrap();
    let places: Vec<f64> = states.iter().map(|s| s.rear.position.x).collect();
    assert_eq!(places.len(), 4, "{places:?}");
    assert!((places[1] - 1.0).abs() < 1e-9 && (places[3] - 3.0).abs() < 1e-9);
    // On a circle of 20 m to the left.
    let circle = (0..4).map(|k| {
        let turned = f64::from(k) / 20.0;
        at(
            20.0 * turned.sin(),
            20.0 - 20.0 * turned.cos(),
            turned,
            10.0,
        )
    });
    let states = read(circle.collect(), ReferencePoint::RearAxle).unwrap();
    assert!(
        (states[1].curvature - 0.05).abs() < 1e-3,
        "{}",
        states[1].curvature
    );
    // The centre is ahead of the rear axle.
    let ahead = limits().rear_to_centre;
    let centre = (0..3).map(|k| at(ahead + f64::from(k), 0.0, 0.0, 10.0));
    let states = read(centre.collect(), ReferencePoint::Centre).unwrap();
    assert!((states[2].rear.position.x - 2.0).abs() < 1e-9);
}

#[test]
fn trajectories_that_cannot_be_driven_from_here_are_refused() {
    let fault = |states| read(states, ReferencePoint::RearAxle).unwrap_err();
    assert_eq!(fault(vec![]), PlannerFault::Empty);
    let first = at(0.0, 0.0, 0.0, 10.0);
    for (second, expected) in [
        (at(f64::NAN, 0.0, 0.0, 10.0), PlannerFault::NotFinite),
        (at(1.0, 0.0, 0.0, f64::INFINITY), PlannerFault::NotFinite),
        (at(1e300, 0.0, 0.0, 10.0), PlannerFault::NotFinite),
        (
            PlannedState {
                t: Some(0.0),
                ..first
            },
            PlannerFault::WrongTimes,
        ),
        (
            PlannedState {
                t: Some(-1.0),
                ..first
            },
            PlannerFault::WrongTimes,
        ),
        (
            PlannedState {
                t: Some(f64::NAN),
                ..first
            },
            PlannerFault::NotFinite,
        ),
    ] {
        assert_eq!(fault(vec![first, second]), expected, "{second:?}");
    }
    let later = PlannedState {
        t: Some(0.1),
        ..first
    };
    assert_eq!(fault(vec![later]), PlannerFault::WrongTimes);
    for elsewhere in [
        at(0.2, 0.0, 0.0, 10.0),
        at(0.0, 0.0, 0.1, 10.0),
        at(0.0, 0.0, 0.0, 11.0),
    ] {
        assert_eq!(fault(vec![elsewhere, elsewhere]), PlannerFault::WrongStart);
    }
}

#[test]
fn a_late_trajectory_is_met_little_by_little() {
    let state = |x: f64, y: f64| VehicleState {
        rear: Pose::new(x, y, 0.0),
        velocity: 10.0,
        acceleration: 0.0,
        curvature: 0.0,
    };
    let planned: Vec<VehicleState> = (0..15).map(|k| state(f64::from(k), 0.0)).collect();
    let actual: Vec<VehicleState> = (0..3).map(|k| state(f64::from(k), 0.5)).collect();
    let (states, off) = joined(&planned, &actual, 2, 0.1, 1.0);
    assert_eq!(states.len(), 15);
    let aside: Vec<f64> = states.iter().map(|s| s.rear.position.y).collect();
    assert!((off - 0.5).abs() < 1e-9 && (aside[2] - 0.5).abs() < 1e-9);
    assert!(
        (aside[7] - 0.25).abs() < 1e-9 && aside[12] == 0.0,
        "{aside:?}"
    );
}

#[test]
fn answers_are_told_apart() {
    let fault = |line: &str| answer(line).unwrap_err().fault;
    for line in [
        "hello",
        "[1]",
        "{\"type\":\"plan\"}",
        "{\"type\":\"trajectory\"}",
        "",
    ] {
        assert_eq!(fault(line), PlannerFault::Nonsense, "{line}");
    }
    let state = |x: &str| {
        format!(
            "{{\"type\":\"trajectory\",\"step\":1,\"states\":[{{\"x\":{x},\"y\":0,\"heading\":0,\"velocity\":0}}]}}"
        )
    };
    for number in ["NaN", "-Infinity", "1e999"] {
        assert_eq!(fault(&state(number)), PlannerFault::NotFinite, "{number}");
    }
    assert!(answer(&state("1")).is_ok());
    let said = |line: &str| ready(line).map_err(|fault| fault.fault);
    let newer = said("{\"type\":\"ready\",\"protocol\":7,\"form\":\"another\"}");
    assert_eq!(newer, Err(PlannerFault::WrongVersion));
    assert_eq!(said(&state("1")), Err(PlannerFault::Nonsense));
    let refused = said("{\"type\":\"error\",\"message\":\"no map\"}");
    assert_eq!(refused, Err(PlannerFault::Refused));
    let plain = said("{\"type\":\"ready\",\"protocol\":1,\"name\":\"x\",\"more\":1}").unwrap();
    assert_eq!(plain.reference_point, ReferencePoint::RearAxle);
    assert!(!plain.predictions && !plain.reusable && !plain.stateless && plain.history == 0);
}

#[test]
fn a_command_is_split_without_a_shell() {
    let words = |line| ExternalOptions::split_command(line);
    assert_eq!(
        words("a 'b c' \"d $HOME\"").unwrap(),
        ["a", "b c", "d $HOME"]
    );
    assert!(words("").is_err() && words("a 'b").is_err());
}

fn settings(forecast: Forecast) -> Settings {
    Settings {
        planner: planner::Settings::default(),
        forecast,
        replan: 1,
        without: None,
        traffic: crate::simulation::TrafficMode::Recorded,
        policy: None,
    }
}

fn told(scenario: &Scenario, forecast: Forecast, step: i64) -> [Value; 2] {
    let problem = &scenario.planning_problems[0];
    let driver = Driver::new(scenario, problem, &settings(forecast)).unwrap();
    let wants: Ready = serde_json::from_value(serde_json::json!({
        "protocol": 1, "name": "x", "predictions": true, "history": 5
    }))
    .unwrap();
    let whole = driver.full_span();
    let teller = SceneMessageBuilder::new(&driver, scenario, whole.step, &wants);
    let plan = teller.message(&whole.state, step);
    let hello = hello(&driver, scenario, &whole, "simulated");
    let value = |message: Message<'_>| serde_json::to_value(&message).unwrap();
    [value(Message::Hello(&hello)), value(Message::Plan(&plan))]
}

/// The scenario as if its recording ended at a step.
fn cut(scenario: &Scenario, last: i64) -> Scenario {
    let mut known = scenario.clone();
    known.obstacles = { scenario.obstacles.iter() }
        .map(|obstacle| {
            let prediction = match &obstacle.prediction {
                Prediction::Trajectory(states) => Prediction::Trajectory(
                    states
                        .iter()
                        .filter(|s| s.time.from <= last)
                        .cloned()
                        .collect(),
                ),
                other => other.clone(),
            };
            let parts = ObstacleParts {
                id: obstacle.id,
                role: obstacle.role,
                kind: obstacle.kind,
                footprint: obstacle.footprint.clone(),
                initial: obstacle.initial.clone(),
                prediction,
                signals: obstacle.signals.clone(),
            };
            Obstacle::new(parts, scenario.dt())
        })
        .collect();
    known
}

#[test]
fn messages_are_as_their_schemas_say() {
    let schema = |name| jsonschema::validator_for(&planner_message_schema(name).unwrap()).unwrap();
    let schemas = [schema("hello"), schema("plan")];
    for entry in bundled() {
        let scenario = entry.read().unwrap();
        let messages = told(&scenario, Forecast::Lane, 10);
        for (schema, message) in schemas.iter().zip(&messages) {
            let wrong: Vec<String> = schema.iter_errors(message).map(|e| e.to_string()).collect();
            assert!(wrong.is_empty(), "{}: {wrong:?}", entry.name);
        }
        assert_eq!(messages[1]["step"], 10);
    }
    assert_eq!(planner_message_names().count(), 6);
    for (name, _) in planner_message_names() {
        let schema = planner_message_schema(name).unwrap();
        assert_eq!(schema["properties"]["type"]["const"], name);
    }
    assert!(planner_message_schema("hullo").is_none());
}

#[test]
fn nothing_of_the_future_is_told_unless_it_is_asked_for() {
    let (mut others, mut history) = (0, 0);
    for entry in bundled().into_iter().take(2) {
        let scenario = entry.read().unwrap();
        let known = cut(&scenario, 10);
        let count = |value: &Value| value.as_array().map_or(0, Vec::len);
        for forecast in [Forecast::Lane, Forecast::ConstantVelocity] {
            let (whole, cut) = (told(&scenario, forecast, 10), told(&known, forecast, 10));
            assert_eq!(whole, cut, "{} {}", entry.name, forecast.name());
            let obstacles = whole[1]["obstacles"].as_array().unwrap();
            others += obstacles.len();
            history += obstacles
                .iter()
                .map(|o| count(&o["history"]))
                .sum::<usize>();
        }
        let recorded = told(&scenario, Forecast::Recorded, 10);
        assert_eq!(recorded[0]["prediction"], "recorded");
    }
    assert!(others > 0 && history > 0);
}

#[test]
fn a_program_that_is_not_there_is_a_clear_end() {
    let entries = bundled();
    let scenario = entries[0].read().unwrap();
    let problem = &scenario.planning_problems[0];
    let planner = ExternalPlanner::new(
        "none",
        ExternalOptions::new(vec!["/no/such/planner".into()]),
    );
    let driver = Driver::new(&scenario, problem, &settings(Forecast::Lane))
        .unwrap()
        .driven_by(Some(Arc::new(planner)));
    let drive = driver.drive(&scenario, &driver.full_span());
    assert_eq!(drive.outcome.name(), "planner_error");
    let report = drive.external.unwrap();
    assert_eq!(report.fault, Some(PlannerFault::NotStarted));
    assert!(
        report
            .fault_in_words()
            .unwrap()
            .contains("/no/such/planner")
    );
    let names: std::collections::BTreeSet<&str> =
        PlannerFault::ALL.iter().map(|fault| fault.name()).collect();
    assert_eq!(names.len(), PlannerFault::ALL.len());
}

/// Goes straight on; fails at a step.
#[derive(Debug)]
struct StraightOn {
    fails_at: Option<i64>,
}

impl PlannerFunction for StraightOn {
    fn begin(&self) -> Answering {
        let (fails_at, mut dt) = (self.fails_at, None);
        Box::new(move |line| {
            let message: Value = serde_json::from_str(line).unwrap();
            if message["type"] == "hello" {
                dt = message["dt"].as_f64();
                return Ok(json!({"type": "ready", "protocol": 1, "name": "straight"}).to_string());
            }
            if message["step"].as_i64() == fails_at {
                return Err("ValueError: no lane".into());
            }
            let (ego, way) = (&message["ego"], dt.unwrap());
            let number = |key: &str| ego[key].as_f64().unwrap();
            let (sin, cos) = number("heading").sin_cos();
            let states = (0..20).map(|k| {
                let way = f64::from(k) * way * number("velocity");
                json!({
                    "x": number("x") + way * cos, "y": number("y") + way * sin,
                    "heading": number("heading"), "velocity": number("velocity"),
                })
            });
            let states: Vec<Value> = states.collect();
            let answer = json!({"type": "trajectory", "step": message["step"], "states": states});
            Ok(answer.to_string())
        })
    }
}

#[test]
fn a_function_drives_like_a_process_and_its_failure_ends_the_drive() {
    let scenario = bundled()[0].read().unwrap();
    let drive = |fails_at| {
        let (options, function) = (ExternalOptions::new(Vec::new()), StraightOn { fails_at });
        let planner = ExternalPlanner::of_function("mine", options, Arc::new(function));
        let problem = &scenario.planning_problems[0];
        let driver = Driver::new(&scenario, problem, &settings(Forecast::Lane))
            .unwrap()
            .driven_by(Some(Arc::new(planner)));
        driver.drive(&scenario, &driver.full_span())
    };
    let (one, two) = (drive(None), drive(None));
    assert!(one.states.len() > 10, "{:?}", one.external);
    assert_eq!(one.states, two.states);
    let report = one.external.unwrap();
    assert_eq!(
        (report.planner.as_str(), report.name.as_str()),
        ("mine", "straight")
    );
    let first = one.states[0].0;
    let failed = drive(Some(first + 3));
    assert_eq!(failed.outcome.name(), "planner_error");
    let report = failed.external.unwrap();
    assert_eq!(
        (report.fault, report.fault_step),
        (Some(PlannerFault::Died), Some(first + 3))
    );
    assert_eq!(report.message.as_deref(), Some("ValueError: no lane"));
}

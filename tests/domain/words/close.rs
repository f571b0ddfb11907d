//! Bodies that nearly touch, and turned bodies beside each other.

use nearmiss::description::{Form, Frame, Options, describe};
use nearmiss::geometry::{Pose, Vector};
use nearmiss::metrics::Encounter;
use nearmiss::scenario::{Sample, Scene, Track, Window};

use crate::words::{check_spans, recomputed, scene};

const CAR: i64 = 301;
const STEP: i64 = 44;

/// The car, and an ego that sees it at `seen` in its own frame, turned by `turned` to the left, and drives `faster`.
fn met(seen: Vector, turned: f64, faster: f64) -> Scene {
    let mut scene = scene("ZAM_CutIn-1_1_T-1");
    let car = scene.participants().find(|p| p.obstacle.id == CAR).unwrap();
    let car = *car.at(STEP).unwrap();
    let frame = Pose::new(0.0, 0.0, car.pose.heading - turned);
    let position = car.pose.position - frame.forward() * seen.x - frame.left() * seen.y;
    let sample = |step: i64| Sample {
        step,
        position,
        heading: Some(frame.heading),
        velocity: Some(car.velocity + faster),
        acceleration: Some(0.0),
    };
    let samples = (STEP - 2..=STEP).map(sample).collect();
    scene.ego.track = Track::new(samples, scene.scenario.dt(), None);
    scene
}

/// What is told of the car at the last step.
fn told(scene: &Scene, frame: Frame) -> String {
    let options = Options {
        form: Form::Prose,
        obstacle: Some(CAR),
        ..Options::default()
    };
    let window = Window::ending_at(scene, STEP, 1);
    let described = describe(scene, frame, &window, &options).unwrap();
    check_spans(&described);
    recomputed::check(scene, STEP);
    let line = described.text.lines().find(|l| l.starts_with("  car 301"));
    line.unwrap().to_string()
}

/// Half of both lengths.
fn half_lengths(scene: &Scene) -> f64 {
    let car = scene.participants().find(|p| p.obstacle.id == CAR).unwrap();
    (scene.ego.footprint.shape().size().0 + car.footprint.shape().size().0) / 2.0
}

#[test]
fn a_gap_that_is_left_is_told_and_said_to_close() {
    let halves = half_lengths(&scene("ZAM_CutIn-1_1_T-1"));
    for (gap, written) in [(0.04, "0.04"), (0.004, "0.004"), (0.000_21, "0.0002")] {
        let scene = met(Vector::new(-halves - gap, 0.0), 0.0, -6.0);
        for frame in [Frame::Ego, Frame::Metrics] {
            let line = told(&scene, frame);
            for part in [
                &format!("distance {written} m"),
                &format!("gap longitudinal -{written} m, lateral 0.00 m"),
                "Behind the ego, the gap is closing; it is in line with the ego and stays so.",
            ] {
                assert!(line.contains(part), "{part}: {line}");
            }
        }
    }
}

#[test]
fn turned_bodies_between_which_there_is_space_are_told_from_those_that_touch() {
    let apart = met(Vector::new(3.6, 2.3), -45.0_f64.to_radians(), 0.0);
    let line = told(&apart, Frame::Ego);
    let car = apart.participants().find(|p| p.obstacle.id == CAR).unwrap();
    let distance = Encounter::at(&apart, &car, STEP).unwrap().distance();
    assert!(distance > 0.5, "{line}");
    for part in [
        &format!("distance {distance:.2} m; gap longitudinal 0.00 m, lateral 0.00 m;"),
        "heading 45.0° to the right;",
        "It overlaps the ego's extent in both directions without touching; seen from the ego it moves",
    ] {
        assert!(line.contains(part), "{part}: {line}");
    }
    let touching = told(
        &met(Vector::new(3.6, 2.3), 45.0_f64.to_radians(), 0.0),
        Frame::Ego,
    );
    assert!(touching.contains("distance 0.00 m;"), "{touching}");
    assert!(
        touching.contains("heading 45.0° to the left;"),
        "{touching}"
    );
    assert!(!touching.contains("overlap"), "{touching}");
}

//! Changed motions, built from inputs of a single-track vehicle.

use std::collections::BTreeSet;
use std::sync::Arc;

use nearmiss::formats::bundled;
use nearmiss::generation::{AttackStyle, Capability, Change, Refusal};
use nearmiss::geometry::{Pose, Vector};
use nearmiss::scenario::{Motion, Scenario};

pub fn scenario(name: &str) -> Arc<Scenario> {
    let entries = bundled();
    let entry = entries.iter().find(|entry| entry.name.contains(name));
    entry.expect("bundled").read().unwrap()
}

/// The scenario with this obstacle alone.
pub fn alone(name: &str, id: i64) -> Scenario {
    let mut scenario = (*scenario(name)).clone();
    scenario.obstacles.retain(|o| o.id == id);
    scenario
}

/// What one step does: m/s² along, and the rate of the steering angle, rad/s.
pub type Input = (f64, f64);

/// The motion of an obstacle from `step` under `inputs`, its wheels first at `angle` radians; integrated in small
/// parts.
pub fn driven(scenario: &Scenario, id: i64, step: i64, angle: f64, inputs: &[Input]) -> Change {
    const PARTS: usize = 400;
    let obstacle = scenario.obstacle(id).expect("there");
    let limits = Capability::for_obstacle(obstacle, AttackStyle::Limit)
        .expect("moves")
        .limits;
    let first = *obstacle.track().at(step).expect("recorded");
    let part = scenario.dt() / PARTS as f64;
    let (mut at, mut heading) = (
        first.pose.position - first.pose.forward() * limits.rear_to_centre,
        first.pose.heading,
    );
    let (mut speed, mut angle) = (first.velocity, angle);
    let mut motions = vec![(step, first)];
    for (&(acceleration, rate), step) in inputs.iter().zip(step + 1..) {
        for _ in 0..PARTS {
            let middle = speed + acceleration * part / 2.0;
            let turn = middle * (angle + rate * part / 2.0).tan() / limits.wheelbase * part;
            let (sin, cos) = (heading + turn / 2.0).sin_cos();
            at += Vector::new(cos, sin) * middle * part;
            heading += turn;
            speed += acceleration * part;
            angle += rate * part;
        }
        let rear = Pose::new(at.x, at.y, heading);
        let motion = Motion {
            pose: Pose {
                position: rear.position + rear.forward() * limits.rear_to_centre,
                heading,
            },
            velocity: speed,
            acceleration,
        };
        motions.push((step, motion));
    }
    Change {
        obstacle: id,
        motions,
    }
}

/// The recorded motion from `step` on.
pub fn untouched(scenario: &Scenario, id: i64, step: i64) -> Change {
    let track = scenario.obstacle(id).expect("there").track();
    let later = track.iter().filter(|(s, _)| *s >= step);
    Change {
        obstacle: id,
        motions: later.map(|(s, m)| (s, *m)).collect(),
    }
}

/// Every state after the first one moved forward and left, metres, so much for each step after it.
pub fn drifting(mut change: Change, forward: f64, left: f64) -> Change {
    for (k, (_, motion)) in change.motions.iter_mut().enumerate() {
        let by = motion.pose.forward() * forward + motion.pose.left() * left;
        motion.pose.position += by * k as f64;
    }
    change
}

/// The names of the reasons.
pub fn names(refusals: &[Refusal]) -> BTreeSet<&'static str> {
    refusals.iter().map(|r| r.reason.name()).collect()
}

/// The first refusal of this name, with step, value and limit.
pub fn first(refusals: &[Refusal], name: &str) -> (i64, f64, f64) {
    let found = refusals
        .iter()
        .find(|r| r.reason.name() == name)
        .unwrap_or_else(|| panic!("no {name} in {refusals:?}"));
    (
        found.step.expect("a step"),
        found.value.expect("a value"),
        found.limit.expect("a limit"),
    )
}

#[track_caller]
pub fn assert_near(a: f64, b: f64, within: f64) {
    assert!((a - b).abs() <= within, "{a} is not {b}");
}

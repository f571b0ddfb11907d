//! A description tells nothing of what happens after its window, not even through the ego's later route.

use std::sync::Arc;

use nearmiss::description::{Form, Frame, Options, describe};
use nearmiss::formats::bundled;
use nearmiss::geometry::Point;
use nearmiss::scenario::{
    Motion, Obstacle, ObstacleParts, Position, Prediction, Sample, Scenario, Scene, State, Track,
    Window,
};

use crate::words::scene;

/// The same scene until `now`; afterwards all obstacles are elsewhere.
fn otherwise(scene: &Scene, now: i64) -> Scene {
    let elsewhere = |step: i64| Point::new(5e3 + 40.0 * step as f64, -5e3);
    let obstacle = |o: &Obstacle| {
        let states = |states: &[State]| {
            let mut states = states.to_vec();
            for state in states.iter_mut().filter(|s| s.time.from > now) {
                state.position = Some(Position::Point(elsewhere(state.time.from)));
            }
            states
        };
        let prediction = match &o.prediction {
            Prediction::Trajectory(later) => Prediction::Trajectory(states(later)),
            other => other.clone(),
        };
        let parts = ObstacleParts {
            id: o.id,
            role: o.role,
            kind: o.kind,
            footprint: o.footprint.clone(),
            initial: o.initial.clone(),
            prediction,
            signals: o.signals.clone(),
        };
        Obstacle::new(parts, scene.scenario.dt())
    };
    let scenario = Scenario {
        obstacles: scene.scenario.obstacles.iter().map(obstacle).collect(),
        ..Scenario::clone(&scene.scenario)
    };
    let mut ego = scene.ego.clone();
    let samples = ego
        .track
        .iter()
        .map(|(step, motion): (i64, &Motion)| Sample {
            step,
            position: if step > now {
                elsewhere(step)
            } else {
                motion.pose.position
            },
            heading: Some(motion.pose.heading),
            velocity: Some(motion.velocity),
            acceleration: Some(motion.acceleration),
        });
    ego.track = Track::new(samples.collect(), scene.scenario.dt(), None);
    Scene::new(Arc::new(scenario), ego)
}

#[test]
fn another_future_changes_no_description() {
    let mut gaps = 0;
    for entry in bundled() {
        let recorded = scene(&entry.name);
        for now in [20, 35] {
            let other = otherwise(&recorded, now);
            for frame in Frame::ALL {
                let obstacle = recorded.participants().next().map(|p| p.obstacle.id);
                let options = Options {
                    form: Form::Compact,
                    radius: 60.0,
                    obstacle: obstacle.filter(|_| frame.is_of_one_obstacle()),
                    ..Options::default()
                };
                let told = |scene: &Scene| {
                    describe(scene, frame, &Window::ending_at(scene, now, 8), &options)
                };
                let (as_recorded, changed) = (told(&recorded), told(&other));
                assert_eq!(as_recorded, changed, "{} {frame:?} {now}", entry.name);
                let spans = as_recorded.map(|d| d.spans).unwrap_or_default();
                gaps += spans.iter().filter(|s| s.quantity == "time_gap").count();
            }
        }
    }
    assert!(gaps > 20, "measures along the lane are told: {gaps}");
}

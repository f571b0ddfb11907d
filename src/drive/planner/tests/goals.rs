//! Tests of goals, and of the desired speed on the way.

use super::guide;
use crate::planner::{Arrival, ReferenceTrack, VehicleState};
use nearmiss_formats::bundled;

#[test]
fn arrivals_of_bundled_scenarios_lie_in_their_goals() {
    let mut found = 0;
    for entry in bundled() {
        let scenario = entry.read().unwrap();
        let graph = scenario.network.lane_graph(None);
        for problem in &scenario.planning_problems {
            let guide = ReferenceTrack::for_problem(&scenario, &graph, problem).unwrap();
            let Some(arrival) = guide.arrival else {
                continue;
            };
            found += 1;
            assert!(arrival.from <= arrival.to, "{}: {arrival:?}", entry.name);
            assert!(arrival.from > 0.0 && arrival.to < guide.path.length());
            for s in [arrival.from, arrival.to] {
                let motion = nearmiss_scene::scenario::Motion {
                    pose: guide.path.pose_at(s),
                    velocity: 0.0,
                    acceleration: 0.0,
                };
                let mut anyhow = problem.clone();
                for goal in &mut anyhow.goals {
                    (goal.velocity, goal.orientation) = (None, None);
                }
                let reached = anyhow.reached(arrival.step, &motion, &scenario.network);
                assert!(reached.is_some(), "{}: {s}", entry.name);
            }
        }
    }
    assert!(found >= 5, "{found}");
}

/// The wanted speed with a goal between 150 m and 170 m until step 100.
fn wanted(cruise: f64, s: f64, now: f64, step: i64) -> f64 {
    let (mut guide, _) = guide("HardBraking");
    guide.cruise = cruise;
    guide.arrival = Some(Arrival {
        from: 150.0,
        to: 170.0,
        step: 100,
    });
    guide.wanted(s, now, step, 0.1)
}

#[test]
fn the_wanted_speed_is_the_cruising_speed_that_arrives_in_time() {
    // 10 s for 100 m to 120 m: cruising at 11 m/s does.
    assert_eq!(wanted(11.0, 50.0, 11.0, 0), 11.0);
    // Too slow: the beginning of the goal at the last moment.
    assert!((wanted(8.0, 50.0, 8.0, 0) - 10.0).abs() < 1e-9);
    // Too fast: its end at the last moment, but slowed down to gently.
    assert!((wanted(20.0, 50.0, 12.5, 0) - 12.0).abs() < 1e-9);
    assert!((wanted(20.0, 50.0, 18.0, 0) - 16.0).abs() < 1e-9);
    // Just before its end the ego does not drive on.
    assert!(wanted(20.0, 169.0, 3.0, 50) <= 2.0);
    assert_eq!(wanted(20.0, 175.0, 1.0, 50), 0.0);
    // Late, but not later than a little haste makes good; beyond that the ego does not race.
    assert!((wanted(8.0, 130.0, 8.0, 80) - 10.0).abs() < 1e-9);
    let (guide, _) = guide("HardBraking");
    assert!((wanted(8.0, 0.0, 8.0, 90) - guide.fastest).abs() < 1e-9);
}

#[test]
fn without_a_goal_it_is_the_cruising_speed() {
    let (mut guide, _) = guide("HardBraking");
    guide.arrival = None;
    assert_eq!(guide.wanted(50.0, 3.0, 0, 0.1), guide.cruise);
}

#[test]
fn wheels_stand_as_the_path_bends() {
    let (guide, _) = guide("HardBraking");
    let on = guide.path.at(guide.start);
    let state = VehicleState {
        rear: guide.path.pose_at(guide.start),
        velocity: 10.0,
        acceleration: 0.0,
        curvature: 0.0,
    };
    let curvature = guide.curvature_at(&state).unwrap();
    assert!(
        (curvature - on.curvature).abs() < 1e-6,
        "{curvature} {}",
        on.curvature
    );
}

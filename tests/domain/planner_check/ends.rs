//! How drives end, which faces touch, and when a goal counts as reached.

use std::f64::consts::FRAC_PI_2;

use nearmiss::geometry::{Footprint, Point, Pose, Shape};
use nearmiss::planner::{Forecast, ReferenceTrackError, Settings};
use nearmiss::scenario::{
    ContentHash, Goal, Header, Motion, Obstacle, ObstacleParts, ObstacleRole, ObstacleType,
    PlanningProblem, Position, Prediction, Quantity, Scenario, State, Steps,
};
use nearmiss::simulation::{self, Collision, ContactSide, DriveError, Outcome, Rollout};

use super::built::{goal, problem, to_lanelet, to_region, two_lanes};
use super::support::drives::drive;

fn scenario(obstacles: Vec<Obstacle>) -> Scenario {
    Scenario {
        header: Header {
            other_format: None,
            time_step_size: 0.1,
            ..Header::default()
        },
        location: None,
        tags: Vec::new(),
        network: two_lanes(),
        obstacles,
        planning_problems: Vec::new(),
        diagnostics: Vec::new(),
        recorded_ego: None,
        hash: ContentHash::digest(b"built"),
    }
}

fn parked(id: i64, pose: Pose) -> Obstacle {
    let mut initial = State::at(Steps::exact(0));
    initial.position = Some(Position::Point(pose.position));
    initial.orientation = Some(Quantity::Exact(pose.heading));
    let parts = ObstacleParts {
        id,
        role: ObstacleRole::Static,
        kind: ObstacleType::Car,
        footprint: Some(Footprint::new(Shape::rectangle(4.0, 2.0)).unwrap()),
        initial: Some(initial),
        prediction: Prediction::None,
        signals: Vec::new(),
    };
    Obstacle::new(parts, 0.1)
}

fn from(x: f64, velocity: f64, goals: Vec<Goal>) -> PlanningProblem {
    let mut problem = problem(Pose::new(x, 0.0, 0.0), goals);
    problem.initial.velocity = Some(Quantity::Exact(velocity));
    problem
}

fn driven(
    scenario: &Scenario,
    problem: &PlanningProblem,
    without: Option<i64>,
) -> Result<Rollout, DriveError> {
    let settings = simulation::Settings {
        planner: Settings::default(),
        forecast: Forecast::Recorded,
        replan: 3,
        without,
        traffic: simulation::TrafficMode::Recorded,
        policy: None,
    };
    drive(scenario, problem, &settings)
}

#[test]
fn a_goal_is_driven_to_or_there_at_once() {
    let empty = scenario(vec![]);
    let drive = driven(&empty, &from(20.0, 12.0, vec![to_lanelet(21)]), None).unwrap();
    assert_eq!(drive.outcome, Outcome::Goal(0));
    let (last, state) = drive.states.last().unwrap();
    assert!((60..75).contains(last), "{last}");
    assert!(state.centre(&drive.limits).pose.position.x >= 100.0);
    let track = drive.track();
    assert_eq!(track.steps(), 0..last + 1);
    let there = driven(&empty, &from(20.0, 12.0, vec![to_lanelet(11)]), None).unwrap();
    assert_eq!(
        (there.outcome, there.states.len(), there.cycles.len()),
        (Outcome::Goal(0), 1, 0)
    );
}

#[test]
fn whoever_comes_too_late_is_out_of_time() {
    let mut soon = to_lanelet(21);
    soon.time.to = 12;
    let drive = driven(&scenario(vec![]), &from(5.0, 5.0, vec![soon]), None).unwrap();
    assert_eq!((drive.outcome, drive.states.len()), (Outcome::Timeout, 13));
    assert_eq!(drive.cycles.len(), 4);
}

#[test]
fn a_collision_at_the_start_ends_it_there() {
    let standing = scenario(vec![parked(9, Pose::new(23.0, 0.0, 0.0))]);
    let start = from(20.0, 12.0, vec![to_lanelet(21)]);
    let drive = driven(&standing, &start, None).unwrap();
    let Outcome::Collision(collision) = drive.outcome else {
        panic!("{:?}", drive.outcome)
    };
    assert_eq!(
        (collision.with, collision.step, drive.states.len()),
        (9, 0, 1)
    );
    assert_eq!(
        (collision.ego, collision.other),
        (ContactSide::Front, ContactSide::Rear)
    );
    // The one whose place the ego takes is not there.
    let without = driven(&standing, &start, Some(9)).unwrap();
    assert_eq!(without.outcome, Outcome::Goal(0));
}

#[test]
fn what_cannot_be_avoided_is_hit_braking() {
    let walled = scenario(vec![
        parked(1, Pose::new(34.0, 0.0, FRAC_PI_2)),
        parked(2, Pose::new(34.0, 4.0, FRAC_PI_2)),
        parked(3, Pose::new(34.0, 8.0, FRAC_PI_2)),
    ]);
    let drive = driven(&walled, &from(20.0, 25.0, vec![to_lanelet(21)]), None).unwrap();
    let Outcome::Collision(collision) = drive.outcome else {
        panic!("{:?}", drive.outcome)
    };
    assert_eq!(collision.ego, ContactSide::Front);
    assert!(drive.states.last().unwrap().1.velocity < 25.0);
    assert!(drive.cycles.iter().any(|c| c.plan.emergency.is_some()));
}

#[test]
fn whoever_points_off_the_road_at_speed_leaves_it() {
    let mut start = problem(Pose::new(20.0, 3.5, -0.9), vec![to_lanelet(21)]);
    start.initial.velocity = Some(Quantity::Exact(25.0));
    let drive = driven(&scenario(vec![]), &start, None).unwrap();
    assert_eq!(drive.outcome, Outcome::OffRoad);
}

#[test]
fn what_is_missing_is_said() {
    let empty = scenario(vec![]);
    let away = driven(&empty, &from(150.0, 10.0, vec![to_lanelet(11)]), None);
    assert!(
        matches!(
            away,
            Err(DriveError::ReferenceTrack(ReferenceTrackError::NoRoute {
                problem: 1,
                ..
            }))
        ),
        "{away:?}"
    );
    let aimless = driven(&empty, &from(20.0, 10.0, vec![]), None);
    assert!(
        matches!(aimless, Err(DriveError::NoGoal { problem: 1 })),
        "{aimless:?}"
    );
    let mut start = from(20.0, 10.0, vec![to_lanelet(21)]);
    start.initial.velocity = None;
    let speedless = driven(&empty, &start, None);
    assert!(
        matches!(speedless, Err(DriveError::NoStart { problem: 1, .. })),
        "{speedless:?}"
    );
    start.initial.position = None;
    let nowhere = driven(&empty, &start, None);
    assert!(
        matches!(
            nowhere,
            Err(DriveError::ReferenceTrack(ReferenceTrackError::NoStart {
                problem: 1
            }))
        ),
        "{nowhere:?}"
    );
}

#[test]
fn faces_are_those_that_touch() {
    let body = Footprint::new(Shape::rectangle(4.0, 2.0)).unwrap();
    let ego = body.at(Pose::new(0.0, 0.0, 0.0));
    for (pose, own, other) in [
        (
            Pose::new(3.9, 0.0, 0.0),
            ContactSide::Front,
            ContactSide::Rear,
        ),
        (
            Pose::new(-3.9, 0.3, 0.0),
            ContactSide::Rear,
            ContactSide::Front,
        ),
        (
            Pose::new(3.9, 0.2, std::f64::consts::PI),
            ContactSide::Front,
            ContactSide::Front,
        ),
        (
            Pose::new(0.5, 1.95, 0.0),
            ContactSide::Left,
            ContactSide::Right,
        ),
        (
            Pose::new(-0.5, -1.95, 0.0),
            ContactSide::Right,
            ContactSide::Left,
        ),
        (
            Pose::new(0.0, 2.95, -FRAC_PI_2),
            ContactSide::Left,
            ContactSide::Front,
        ),
        (
            Pose::new(2.95, 0.0, FRAC_PI_2),
            ContactSide::Front,
            ContactSide::Left,
        ),
    ] {
        let others = scenario(vec![parked(5, pose)]);
        let found = Collision::at(&others, &ego, 0, None).unwrap();
        assert_eq!((found.ego, found.other), (own, other), "{pose:?}");
        assert_eq!(Collision::at(&others, &ego, 0, Some(5)), None);
    }
    let beside = scenario(vec![parked(5, Pose::new(0.0, 2.1, 0.0))]);
    assert_eq!(Collision::at(&beside, &ego, 0, None), None);
}

#[test]
fn a_goal_is_reached_where_all_it_says_holds() {
    let network = two_lanes();
    let motion = |x: f64, heading: f64, velocity: f64| Motion {
        pose: Pose::new(x, 0.0, heading),
        velocity,
        acceleration: 0.0,
    };
    let reached = |goals: &[Goal], step: i64, motion: Motion| {
        from(0.0, 10.0, goals.to_vec()).reached(step, &motion, &network)
    };
    let at = motion(150.0, 0.1, 10.0);
    // Time, ends included.
    let mut timed = goal(vec![]);
    timed.time = Steps { from: 5, to: 8 };
    for (step, there) in [(4, None), (5, Some(0)), (8, Some(0)), (9, None)] {
        assert_eq!(reached(std::slice::from_ref(&timed), step, at), there);
    }
    // Lanelets, regions and points; several are alternatives.
    assert_eq!(reached(&[to_lanelet(21)], 5, at), Some(0));
    assert_eq!(reached(&[to_lanelet(11)], 5, at), None);
    assert_eq!(reached(&[to_region(151.9, 0.5)], 5, at), Some(0));
    assert_eq!(reached(&[to_region(152.1, 0.5)], 5, at), None);
    let point = |x: f64| goal(vec![Position::Point(Point::new(x, 0.0))]);
    assert_eq!(reached(&[point(150.0)], 5, at), Some(0));
    assert_eq!(reached(&[point(150.01)], 5, at), None);
    let either = goal([to_lanelet(11).positions, to_lanelet(21).positions].concat());
    assert_eq!(reached(&[either], 5, at), Some(0));
    // Speed and heading.
    let with = |velocity, orientation| Goal {
        velocity,
        orientation,
        ..to_lanelet(21)
    };
    let between = |a, b| Some(Quantity::Interval(a, b));
    assert_eq!(reached(&[with(between(9.0, 11.0), None)], 5, at), Some(0));
    assert_eq!(reached(&[with(between(10.5, 11.0), None)], 5, at), None);
    assert_eq!(
        reached(&[with(Some(Quantity::Exact(10.0)), None)], 5, at),
        Some(0)
    );
    assert_eq!(
        reached(&[with(Some(Quantity::Exact(10.1)), None)], 5, at),
        None
    );
    assert_eq!(reached(&[with(None, between(0.0, 0.2))], 5, at), Some(0));
    assert_eq!(reached(&[with(None, between(0.2, 0.4))], 5, at), None);
    // Headings are the same a whole turn on.
    assert_eq!(reached(&[with(None, between(6.2, 6.5))], 5, at), Some(0));
    assert_eq!(
        reached(&[with(None, Some(Quantity::Exact(0.1)))], 5, at),
        Some(0)
    );
    assert_eq!(
        reached(&[with(None, Some(Quantity::Exact(0.2)))], 5, at),
        None
    );
    // The first of several that holds.
    assert_eq!(reached(&[to_lanelet(11), to_lanelet(21)], 5, at), Some(1));
    assert_eq!(from(0.0, 1.0, vec![]).deadline(), None);
    assert_eq!(
        from(0.0, 1.0, vec![timed, to_lanelet(21)]).deadline(),
        Some(100)
    );
}

//! Traffic that reacts, worked out by hand: where it stops, who waits, what triggers it, and that it is recorded else.

use super::course::{Ahead, Course, ExpectedPath, Neighbour};
use super::reacting::{Follower, Idm, Reacting};
use super::{HitFromBehind, TrafficMode};
use crate::planner::{Forecast, Settings as Planning};
use crate::simulation::{Driver, Outcome, Rollout, Settings};
use nearmiss_base::geometry::{Footprint, Point, Pose, Shape};
use nearmiss_formats::bundled;
use nearmiss_scene::scenario::{
    Motion, Obstacle, ObstacleParts, ObstacleRole, ObstacleType, Position, Prediction, Quantity,
    Scenario, State, Steps,
};

const DT: f64 = 0.1;

fn body() -> Footprint {
    Footprint::new(Shape::rectangle(4.0, 2.0)).unwrap()
}

fn state(step: i64, pose: Pose, velocity: f64) -> State {
    State {
        position: Some(Position::Point(pose.position)),
        orientation: Some(Quantity::Exact(pose.heading)),
        velocity: Some(Quantity::Exact(velocity)),
        acceleration: Some(Quantity::Exact(0.0)),
        ..State::at(Steps::exact(step))
    }
}

/// A car that was recorded along the x axis with these speeds (m/s), a step each, from (0, 0) on.
fn recorded(kind: ObstacleType, speeds: &[f64]) -> Obstacle {
    let mut x = 0.0;
    let mut states = Vec::new();
    for (step, v) in speeds.iter().enumerate() {
        states.push(state(step as i64, Pose::new(x, 0.0, 0.0), *v));
        x += v * DT;
    }
    let parts = ObstacleParts {
        id: 7,
        role: ObstacleRole::Dynamic,
        kind,
        footprint: Some(body()),
        initial: states.first().cloned(),
        prediction: Prediction::Trajectory(states[1..].to_vec()),
        signals: Vec::new(),
    };
    Obstacle::new(parts, DT)
}

/// A body of the ego, or of the obstacle with a place.
fn neighbour(body: &Footprint, place: Option<usize>, pose: Pose, speed: f64) -> Neighbour<'_> {
    Neighbour {
        place,
        body: body.at(pose),
        speed,
        acceleration: 0.0,
        way: ExpectedPath::Straight,
    }
}

fn ahead(body: &Footprint, place: usize, speed: f64) -> Ahead<'_, impl Fn(f64) -> Pose> {
    let idm = Idm::for_kind(ObstacleType::Car);
    Ahead::new(place, body, |s| Pose::new(s, 0.0, 0.0), speed, idm, 7.59)
}

#[test]
fn it_stops_behind_a_standing_body_within_the_limits_of_people() {
    let (car, body) = (recorded(ObstacleType::Car, &[15.0; 200]), body());
    // The bodies are 60 m apart.
    let ego = neighbour(&body, None, Pose::new(64.0, 0.0, 0.0), 0.0);
    let course = Course::recorded(car.track()).unwrap();
    let mut reacting = Reacting::new(&car, course, 0, DT).unwrap();
    let (mut hardest, mut before) = (0.0_f64, 0.0);
    for _ in 0..300 {
        let a = reacting.decide(0, &body, std::slice::from_ref(&ego), DT);
        assert!((a - reacting.a).abs() <= 12.65 * DT + 1e-9, "jerk");
        assert!((-7.59..=3.5).contains(&a), "{a}");
        reacting.go_on(a, DT);
        assert!(reacting.s >= before && reacting.v >= 0.0);
        (hardest, before) = (hardest.min(a), reacting.s);
    }
    // At standstill the gap is that of the model, 2 m; gaps are measured to 1/16 m, and jerk is bounded.
    let gap = 60.0 - reacting.s;
    assert!((1.7..2.3).contains(&gap), "{gap}");
    assert!(reacting.v < 0.05, "{}", reacting.v);
    // 15²/(2·58) = 1.9 m/s² would have been enough.
    assert!((-4.0..-1.9).contains(&hardest), "{hardest}");
}

#[test]
fn on_a_free_way_it_drives_as_it_was_recorded() {
    let car = recorded(ObstacleType::Car, &[10.0; 100]);
    let course = Course::recorded(car.track()).unwrap();
    let mut reacting = Reacting::new(&car, course, 10, DT).unwrap();
    for _ in 10..90 {
        let a = reacting.decide(0, &body(), &[], DT);
        reacting.go_on(a, DT);
    }
    let (step, motion) = reacting.motions[80];
    assert_eq!(step, 90);
    let apart = (motion.pose.position - car.track().at(90).unwrap().pose.position).norm();
    assert!(apart < 1e-6, "{apart}");
}

#[test]
fn it_waits_where_it_was_recorded_to_wait() {
    // 10 m/s for 2 s, 2 m/s² to standstill, 3 s there, then off again.
    let mut speeds = vec![10.0; 20];
    speeds.extend((0..50).map(|k| 10.0 - 0.2 * f64::from(k)));
    speeds.extend([0.0; 30]);
    speeds.extend((0..50).map(|k| 0.2 * f64::from(k)));
    let car = recorded(ObstacleType::Car, &speeds);
    let stands = car.track().at(80).unwrap().pose.position.x;
    let course = Course::recorded(car.track()).unwrap();
    let mut reacting = Reacting::new(&car, course, 5, DT).unwrap();
    while reacting.motions.len() < 95 {
        let a = reacting.decide(0, &body(), &[], DT);
        reacting.go_on(a, DT);
        let (step, motion) = reacting.motions[reacting.motions.len() - 1];
        let over = motion.pose.position.x - stands;
        assert!(over < 0.5, "{over} m too far at step {step}");
    }
    for _ in 0..60 {
        let a = reacting.decide(0, &body(), &[], DT);
        reacting.go_on(a, DT);
    }
    assert!(reacting.v > 2.0, "it drives off: {}", reacting.v);
}

#[test]
fn who_reaches_a_crossing_first_goes_first() {
    let body = body();
    let own = ahead(&body, 3, 10.0);
    let from_the_right = |metres: f64, speed: f64, place: Option<usize>| {
        // The way crosses at x = 30 m.
        let pose = Pose::new(30.0, -metres, std::f64::consts::FRAC_PI_2);
        own.leader(&neighbour(&body, place, pose, speed))
    };
    // It is there after 1 s and gone before 3 s, when the car arrives: 26 m with 10 m/s and 1 m/s² take 2.3 s.
    let waits = from_the_right(18.0, 10.0, None).unwrap();
    assert_eq!(waits.speed, 0.0);
    // The bodies would touch where the front is at x = 29 m: 2 m to the middle, half a width of 1 m.
    assert!((26.0..27.5).contains(&waits.gap), "{}", waits.gap);
    // It arrives long after the car has passed.
    assert_eq!(from_the_right(60.0, 10.0, None), None);
    // It is gone long before.
    assert_eq!(from_the_right(9.0, 30.0, None), None);
    // A standing one blocks nothing.
    assert_eq!(from_the_right(18.0, 0.0, None), None);
    // In a tie, the ego and who comes first in the file go first.
    let tie = |place| from_the_right(26.3, 10.0, place).is_some();
    assert!(tie(None) && tie(Some(1)) && !tie(Some(9)));
}

#[test]
fn who_cannot_stop_any_more_goes_on() {
    let body = body();
    // 20²/(2·7.59) = 26.4 m are needed, 16 m are there.
    let own = ahead(&body, 0, 20.0);
    let pose = Pose::new(20.0, -6.0, std::f64::consts::FRAC_PI_2);
    assert_eq!(own.leader(&neighbour(&body, None, pose, 8.0)), None);
}

#[test]
fn what_is_ahead_on_the_way_is_followed_and_what_is_behind_is_not() {
    let body = body();
    let own = ahead(&body, 0, 10.0);
    let at = |x: f64| own.leader(&neighbour(&body, None, Pose::new(x, 0.3, 0.0), 8.0));
    let leader = at(20.0).unwrap();
    assert!((leader.gap - 16.0).abs() < 0.1 && (leader.speed - 8.0).abs() < 1e-9);
    assert_eq!(at(-20.0), None);
    // In the next lane.
    let beside = neighbour(&body, None, Pose::new(20.0, 3.5, 0.0), 8.0);
    assert_eq!(own.leader(&beside), None);
}

/// Whether a car with these speeds has to react at its first step to a standing ego whose body is so far ahead.
fn reacts(speeds: &[f64], gap: f64) -> bool {
    let (car, body) = (recorded(ObstacleType::Car, speeds), body());
    let course = Course::recorded(car.track()).unwrap();
    let follower = Follower {
        obstacle: &car,
        course: &course,
        step: 0,
        dt: DT,
        idm: Idm::for_kind(ObstacleType::Car),
    };
    follower.is_concerned(&neighbour(&body, None, Pose::new(gap + 4.0, 0.0, 0.0), 0.0))
}

#[test]
fn it_reacts_when_comfortable_braking_is_only_just_enough() {
    // From 6 m/s: one more step, 0.6 m; 6²/(2·1.5) = 12 m; and half of the standstill gap, 1 m.
    let steady = [6.0; 100];
    assert!(!reacts(&steady, 13.8) && reacts(&steady, 13.4));
    // It was recorded to stop in time: after 0.6 m/s² for 10 s it stands 30 m farther.
    let stops: Vec<f64> = (0..100).map(|k| 6.0 - 0.06 * f64::from(k)).collect();
    assert!(!reacts(&stops, 31.0));
    // It was recorded to stop just behind, however hard.
    let hard: Vec<f64> = (0..100)
        .map(|k| (6.0 - 0.6 * f64::from(k)).max(0.0))
        .collect();
    assert!(!reacts(&hard, 3.5), "it stands after 3.3 m");
}

#[test]
fn an_obstacle_that_is_run_into_does_not_react() {
    let (car, body) = (recorded(ObstacleType::Car, &[5.0; 100]), body());
    let course = Course::recorded(car.track()).unwrap();
    let follower = Follower {
        obstacle: &car,
        course: &course,
        step: 0,
        dt: DT,
        idm: Idm::for_kind(ObstacleType::Car),
    };
    let from_behind = neighbour(&body, None, Pose::new(-8.0, 0.0, 0.0), 15.0);
    assert!(!follower.is_concerned(&from_behind));
    // It hits the car's side, after the car was there first.
    let into_the_side = Pose::new(10.0, -12.0, std::f64::consts::FRAC_PI_2);
    let into_the_side = neighbour(&body, None, into_the_side, 5.0);
    assert!(!follower.is_concerned(&into_the_side));
}

fn settings(traffic: TrafficMode) -> Settings {
    // Few samples: this is about the others.
    let mut planner = Planning::default();
    let few = &mut planner.sampling;
    (few.durations, few.speeds, few.offsets) = (2, 5, 5);
    (few.changes, few.refinements) = (1, 1);
    Settings {
        planner,
        forecast: Forecast::Lane,
        replan: 1,
        without: None,
        traffic,
        policy: None,
    }
}

fn drive(scenario: &Scenario, traffic: TrafficMode) -> Rollout {
    let problem = &scenario.planning_problems[0];
    let driver = Driver::new(scenario, problem, &settings(traffic)).unwrap();
    driver.drive(scenario, &driver.full_span())
}

/// A bundled road whose only obstacle drives 25 m behind the ego on its path, so many times as fast as the ego starts.
fn chased(times: f64) -> Scenario {
    let all = bundled();
    let entry = all.iter().find(|e| e.name.contains("HardBraking")).unwrap();
    let mut scenario = Scenario::clone(&entry.read().unwrap());
    scenario.obstacles.clear();
    let problem = scenario.planning_problems[0].clone();
    let driver = Driver::new(&scenario, &problem, &settings(TrafficMode::Recorded)).unwrap();
    let speed = problem.initial.velocity.unwrap().middle() * times;
    let (first, dt) = (driver.full_span().step, scenario.dt());
    let path = &driver.guide().path;
    let states: Vec<State> = (first..driver.full_span().last)
        .map(|step| {
            let s = driver.guide().start - 25.0 + (step - first) as f64 * dt * speed;
            state(step, path.pose_at(s), speed)
        })
        .collect();
    let parts = ObstacleParts {
        id: 700,
        role: ObstacleRole::Dynamic,
        kind: ObstacleType::Car,
        footprint: Some(body()),
        initial: states.first().cloned(),
        prediction: Prediction::Trajectory(states[1..].to_vec()),
        signals: Vec::new(),
    };
    scenario.obstacles.push(Obstacle::new(parts, dt));
    scenario
}

#[test]
fn a_car_that_was_recorded_faster_than_the_ego_keeps_its_distance() {
    let scenario = chased(1.4);
    let recorded = drive(&scenario, TrafficMode::Recorded);
    assert!(recorded.traffic.scenario.is_none() && recorded.traffic.reactions.is_empty());
    if let Outcome::Collision(_) = recorded.outcome {
        assert_ne!(recorded.hit_from_behind(), Some(HitFromBehind::Reacting));
    }
    let reactive = drive(&scenario, TrafficMode::Reactive);
    assert!(
        !matches!(reactive.outcome, Outcome::Collision(_)),
        "{}",
        reactive.outcome
    );
    let [reaction] = reactive.traffic.reactions[..] else {
        panic!("{:?}", reactive.traffic.reactions);
    };
    assert_eq!(reaction.obstacle, 700);
    let driven = reactive.scenario_in(&scenario);
    let (old, new) = (&scenario.obstacles[0], &driven.obstacles[0]);
    for step in old.track().steps().start..=reaction.from {
        assert_eq!(old.motion_at(step), new.motion_at(step), "step {step}");
    }
    let last = reactive.states[reactive.states.len() - 1].0;
    assert!(new.motion_at(last).is_some() && new.motion_at(last + 1).is_none());
    let slower: &Motion = new.motion_at(last).unwrap();
    assert!(slower.velocity < old.motion_at(last).map_or(f64::MAX, |m| m.velocity));
    // The same drive again.
    assert_eq!(
        drive(&scenario, TrafficMode::Reactive).states,
        reactive.states
    );
}

#[test]
fn traffic_that_is_not_concerned_is_the_recorded_one() {
    let scenario = chased(0.3);
    let recorded = drive(&scenario, TrafficMode::Recorded);
    let reactive = drive(&scenario, TrafficMode::Reactive);
    assert!(reactive.traffic.scenario.is_none() && reactive.traffic.reactions.is_empty());
    assert_eq!(recorded.states, reactive.states);
    assert!(std::ptr::eq(
        reactive.scenario_in(&scenario),
        &raw const scenario
    ));
}

#[test]
fn a_course_is_the_recorded_way_and_goes_on_straight() {
    let car = recorded(ObstacleType::Car, &[10.0; 11]);
    let course = Course::recorded(car.track()).unwrap();
    assert!((course.recorded_length() - 10.0).abs() < 1e-9);
    assert!((course.at_step(4).unwrap() - 4.0).abs() < 1e-9);
    let beyond = course.pose_at(12.5).position;
    assert!((beyond - Point::new(12.5, 0.0)).norm() < 1e-9);
    let back = recorded(ObstacleType::Car, &[-2.0; 11]);
    assert!(Course::recorded(back.track()).is_none());
}

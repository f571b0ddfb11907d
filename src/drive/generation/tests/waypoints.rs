//! Tests of waypoints: taken as given, repaired, or refused.

use super::{CAR, behind_a_car, braking, car, state};
use crate::generation::manoeuvre::Plan;
use crate::generation::motion::{self, through_waypoints};
use crate::generation::{
    AdmittedAttack, AttackContext, AttackSetup, Change, ClosedLoop, Gate, Reason, Refusal, admit,
};
use crate::planner::{Bound, Forecast};
use nearmiss_base::geometry::{Pose, Vector};
use nearmiss_scene::scenario::{Motion, Scenario, State};
use nearmiss_scene::verdict::{Manoeuvre, ManoeuvreKind, Moment, Motion as Asked, Waypoint};

/// Does something on the ground of a baseline.
fn on_ground<T>(closed: &ClosedLoop, with: impl FnOnce(&AttackSetup<'_>) -> T) -> T {
    let driver = closed.driver();
    let ego = { closed.baseline().drive() }.ego(driver.problem(), driver.settings());
    let stage = AttackContext::new(closed.scenario(), &ego.footprint, &ego.track).unwrap();
    let gate = Gate::new(closed.scenario()).with_ego(&ego);
    with(&AttackSetup {
        stage: &stage,
        gate: &gate,
        closed_loop: closed,
    })
}

fn waypoint(at: Moment, motion: &Motion) -> Waypoint {
    let position = motion.pose.position;
    Waypoint {
        at,
        x: position.x,
        y: position.y,
        heading: Some(motion.pose.heading),
        velocity: Some(motion.velocity),
    }
}

/// Every fifth state of a change, until 4 s after it begins.
fn points(change: &Change) -> Vec<Waypoint> {
    let some = change.motions.iter().step_by(5).take(9);
    some.map(|(step, motion)| waypoint(Moment::Step(*step), motion))
        .collect()
}

fn asked(closed: &ClosedLoop, points: &[Waypoint]) -> Result<AdmittedAttack, Vec<Refusal>> {
    let motion = Asked::Waypoints(points.to_vec());
    on_ground(closed, |ground| {
        let made = admit(ground, CAR, &motion)?;
        let change = &made.attack.change.changes()[0];
        assert!(ground.gate.check(change, None).is_ok());
        Ok(made)
    })
}

#[test]
fn a_braking_that_can_be_driven_is_taken_as_it_is() {
    let closed = behind_a_car(12.0, Forecast::Lane);
    let braking = braking(&closed, 10, 2.0);
    let points = points(&braking);
    let made = asked(&closed, &points).unwrap();
    assert!(made.repair.is_none(), "{:?}", made.repair);
    let change = &made.attack.change.changes()[0];
    assert_eq!((change.from(), change.until()), (Some(10), Some(50)));
    assert_eq!(change.motions.len(), 41);
    assert_eq!(change.motions[0], braking.motions[0]);
    for (a, b) in change.motions.iter().zip(&braking.motions) {
        let off = (a.1.pose.position - b.1.pose.position).norm();
        assert!(off < 0.1, "step {}: {off}", a.0);
    }
    // By times that are no steps, the same way is driven.
    let late = |p: &Waypoint| {
        let Moment::Step(step) = p.at else { panic!() };
        let shift = 0.04;
        let heading = p.heading.unwrap();
        let along = Vector::new(heading.cos(), heading.sin()) * p.velocity.unwrap() * shift;
        Waypoint {
            at: Moment::Seconds(step as f64 * 0.1 + shift),
            x: p.x + along.x,
            y: p.y + along.y,
            ..*p
        }
    };
    let late: Vec<Waypoint> = points.iter().map(late).collect();
    let made = asked(&closed, &late).unwrap();
    let change = &made.attack.change.changes()[0];
    assert_eq!((change.from(), change.until()), (Some(11), Some(50)));
    assert!(made.repair.is_some_and(|repair| repair.moved < 0.3));
}

/// The motion that the shipped prompt gives as its example: a car on a straight road at 10 m/s cuts in.
#[test]
fn the_example_of_the_prompt_is_near_enough_to_be_repaired() {
    let closed = behind_a_car(12.0, Forecast::Lane);
    let mut scenario = Scenario::clone(closed.scenario());
    let straight = |step: i64| Motion {
        pose: Pose::new(10.0 + step as f64, 3.5, 0.0),
        velocity: 10.0,
        acceleration: 0.0,
    };
    let states: Vec<State> = (0..40).map(|step| state(step, &straight(step))).collect();
    scenario.obstacles = vec![car(&states, scenario.dt())];
    let example = [
        (0.0, 10.00, 3.50, 0.000, 10.0),
        (0.5, 14.73, 3.50 - 0.36, -0.207, 9.0),
        (1.0, 18.73, 1.75, -0.423, 8.0),
        (1.5, 22.21, 0.36, -0.267, 7.0),
        (2.0, 25.43, 0.00, 0.000, 6.0),
    ];
    let points = example.map(|(time, x, y, heading, velocity)| Waypoint {
        at: Moment::Seconds(time),
        x,
        y,
        heading: Some(heading),
        velocity: Some(velocity),
    });
    let driver = closed.driver();
    let ego = { closed.baseline().drive() }.ego(driver.problem(), driver.settings());
    let stage = AttackContext::new(&scenario, &ego.footprint, &ego.track).unwrap();
    let obstacle = scenario.obstacle(CAR).unwrap();
    let given = through_waypoints(&stage, obstacle, &points).unwrap();
    assert_eq!((given.from(), given.until()), (Some(0), Some(20)));
    let plan = Plan {
        from: 0,
        wanted: motion::targets_of(&given.motions),
    };
    let driven = motion::follow(&stage, obstacle, 0, &plan).unwrap();
    let off = { given.motions.iter().zip(&driven.motions) }
        .map(|((_, a), (_, b))| (a.pose.position - b.pose.position).norm())
        .fold(0.0, f64::max);
    assert!(off < 0.6, "{off}");
    assert!(
        Gate::new(&scenario)
            .check(&driven, None)
            .unwrap_err()
            .iter()
            .all(|r| r.reason == Reason::OffRoad)
    );
}

#[test]
fn a_near_miss_is_repaired_and_anything_else_refused() {
    let closed = behind_a_car(12.0, Forecast::Lane);
    let right = points(&braking(&closed, 10, 4.0));
    let moved = |by: f64| {
        let mut points = right.clone();
        points[0].x += by;
        asked(&closed, &points)
    };
    let repair = moved(0.4).unwrap().repair.unwrap();
    assert!(
        repair.moved >= 0.4 - 1e-6 && repair.moved < 1.0,
        "{repair:?}"
    );
    let start = &repair.refused[0];
    assert_eq!(start.reason, Reason::Start("position"));
    let refused = moved(10.7).unwrap_err();
    assert_eq!(refused[0].reason, Reason::Start("position"));
    assert!((refused[0].value.unwrap() - 10.7).abs() < 1e-6);

    // A speed that no obstacle reaches in half a second, and a heading across the road.
    let mut fast = right.clone();
    fast[3].velocity = Some(40.0);
    let reasons = |points: &[Waypoint]| -> Vec<Reason> {
        let refused = asked(&closed, points).unwrap_err().into_iter();
        refused.map(|r| r.reason).collect()
    };
    assert!(reasons(&fast).contains(&Reason::Jerk));
    let mut across = right.clone();
    across[3].heading = across[3].heading.map(|h| h + 1.5);
    assert!(reasons(&across).contains(&Reason::Kinematics(Bound::Friction)));
    // All that is wrong with the way to a place that cannot be reached, at once.
    let mut aside = right;
    aside[1].y += 100.0;
    aside[4].velocity = Some(-1.0);
    assert_eq!(
        reasons(&aside),
        [
            Reason::Jump,
            Reason::Jump,
            Reason::Kinematics(Bound::Backwards)
        ]
    );
}

#[test]
fn whatever_is_asked_nothing_panics_and_nothing_invalid_passes() {
    let closed = behind_a_car(12.0, Forecast::Lane);
    let right = points(&braking(&closed, 10, 4.0));
    let mut random = fastrand::Rng::with_seed(9);
    let odd = [
        0.0,
        -1.0,
        1e-300,
        1e9,
        1e300,
        -1e300,
        f64::MAX,
        f64::NAN,
        f64::INFINITY,
    ];
    let (mut passed, mut refused) = (0, 0);
    for round in 0..150 {
        let mut points = right.clone();
        for _ in 0..random.usize(1..4) {
            let place = random.usize(0..points.len());
            let point = &mut points[place];
            let value = match round % 3 {
                0 => odd[random.usize(..odd.len())],
                _ => (random.f64() - 0.5) * 0.5,
            };
            let by = if round % 3 == 0 { 0.0 } else { 1.0 };
            match random.usize(..5) {
                0 => point.x = by * point.x + value,
                1 => point.y = by * point.y + value,
                2 => point.heading = Some(value),
                3 => point.velocity = random.bool().then_some(20.0 * value),
                _ => point.at = Moment::Step(value as i64),
            }
        }
        match asked(&closed, &points) {
            Ok(_) => passed += 1,
            Err(why) => {
                assert!(!why.is_empty());
                refused += 1;
            }
        }
    }
    assert!(passed > 5 && refused > 50, "{passed} and {refused}");
}

#[test]
fn numbers_of_manoeuvres_stay_within_the_scenario() {
    let closed = behind_a_car(12.0, Forecast::Lane);
    let manoeuvre = Manoeuvre {
        kind: ManoeuvreKind::HardBrake,
        start: 1.0,
        duration: 5.0,
        gap: None,
        speed: Some(0.0),
    };
    let ask = |manoeuvre: &Manoeuvre| {
        let motion = Asked::Manoeuvre(manoeuvre.clone());
        on_ground(&closed, |ground| admit(ground, CAR, &motion))
    };
    assert!(ask(&manoeuvre).unwrap().repair.is_none());
    for (kind, start, duration, speed) in [
        (ManoeuvreKind::HardBrake, f64::MAX, 1.0, 1.0),
        (ManoeuvreKind::Drift, 1.0, 1e300, 1.0),
        (ManoeuvreKind::CutIn, 1.0, f64::NAN, 1.0),
        (ManoeuvreKind::DoorToDoor, 1.0, 1.0, 1e300),
        (ManoeuvreKind::LateTurn, -1.0, 1.0, 1.0),
        (ManoeuvreKind::PullOut, 1.0, 1.0, f64::INFINITY),
    ] {
        let wild = Manoeuvre {
            kind,
            start,
            duration,
            gap: Some(1e300),
            speed: Some(speed),
        };
        assert_eq!(ask(&wild).unwrap_err().len(), 1, "{kind:?}");
    }
}

//! One limit after the other, broken by construction on a straight motorway at 28 m/s, and in a jam.

use nearmiss::generation::{AttackStyle, Change, Gate, Reason, Refusal};
use nearmiss::planner::Bound;
use nearmiss::scenario::Scenario;

use super::built::{Input, alone, assert_near, drifting, driven, first, names};

/// A car on a straight at 28 m/s without acceleration; its wheels stand straight.
const CAR: i64 = 304;
const STEP: i64 = 70;

fn motorway() -> Scenario {
    alone("Merge", CAR)
}

fn refused(scenario: &Scenario, change: &Change) -> Vec<Refusal> {
    let gate = Gate::new(scenario);
    let refusals = gate.check(change, None).expect_err("refused");
    let one = gate.passes(change, None).expect_err("refused");
    assert!(refusals.contains(&one), "{one} is none of all");
    refusals
}

fn refused_inputs(inputs: &[Input]) -> Vec<Refusal> {
    let scenario = motorway();
    refused(&scenario, &driven(&scenario, CAR, STEP, 0.0, inputs))
}

#[test]
fn what_a_car_can_drive_passes() {
    let scenario = motorway();
    let mut inputs = vec![(-2.0, 0.1), (-5.0, -0.1), (-8.0, -0.1), (-8.0, 0.1)];
    inputs.extend([(-6.0, 0.0), (-3.0, 0.0), (0.0, 0.0), (1.0, 0.0)]);
    let change = driven(&scenario, CAR, STEP, 0.0, &inputs);
    let passed = Gate::new(&scenario)
        .check(&change, None)
        .unwrap_or_else(|refusals| panic!("{refusals:?}"));
    assert_eq!((passed.steps, passed.exempt), (inputs.len(), 0));
    assert!((0.69..1.0).contains(&passed.friction), "{passed:?}");
    assert!(passed.recording.is_empty());
    let last = scenario.obstacle(CAR).unwrap().track().steps().end - 1;
    assert_eq!(passed.early, last - STEP - 8);
    assert_eq!(Gate::new(&scenario).passes(&change, None), Ok(passed));
}

/// What the gate says of inputs where people drive; vehicles can do all of them.
fn refused_to_people(inputs: &[Input], steering: f64) -> Vec<Refusal> {
    let scenario = motorway();
    let change = driven(&scenario, CAR, STEP, steering, inputs);
    let limit = Gate::new(&scenario).check(&change, None);
    assert!(limit.is_ok(), "{limit:?}");
    let gate = Gate::new(&scenario).of_style(AttackStyle::Human);
    gate.check(&change, None).err().unwrap_or_default()
}

#[test]
fn people_do_less_than_their_vehicles() {
    let calm = [0.0, -1.0, -2.0, -3.0, -4.0, -5.0, -6.0, -7.0, -7.5];
    assert_eq!(refused_to_people(&calm.map(|a| (a, 0.0)), 0.0), []);
    // Braking beyond 7.59 m/s² is beyond their friction circle.
    let hard = refused_to_people(
        &[-1.0, -2.0, -3.0, -4.0, -5.0, -6.0, -7.0, -8.0].map(|a| (a, 0.0)),
        0.0,
    );
    assert!(names(&hard).contains("friction circle"), "{hard:?}");
    let (step, value, limit) = first(&hard, "friction circle");
    assert_eq!(step, STEP + 7);
    assert_near(value, 8.0, 1e-3);
    // Estimates may exceed it by two hundredths.
    assert!((7.59..7.75).contains(&limit), "{limit}");
    // Kicking the brakes within a tenth of a second.
    let sudden = refused_to_people(&[(-2.5, 0.0), (-2.5, 0.0)], 0.0);
    assert_eq!(names(&sudden), ["jerk"].into());
    // 28 m/s, and the wheels turned by 0.018 rad: 5.5 m/s² across.
    let bend = refused_to_people(&[(0.0, 0.06), (0.0, 0.06), (0.0, 0.06), (0.0, 0.0)], 0.0);
    assert_eq!(names(&bend), ["lateral acceleration"].into());
    let (_, value, limit) = first(&bend, "lateral acceleration");
    assert!(
        value > limit && (limit - 4.0).abs() < 0.01,
        "{value}, {limit}"
    );
}

#[test]
fn acceleration_by_brakes() {
    let found = refused_inputs(&[-2.5, -5.0, -7.5, -10.0, -12.0, -12.0].map(|a| (a, 0.0)));
    // What brakes too much is beyond the friction circle as well.
    assert_eq!(names(&found), ["acceleration", "friction circle"].into());
    let (step, value, limit) = first(&found, "acceleration");
    assert_eq!(step, STEP + 4);
    assert_near(value, 12.0, 1e-6);
    assert_near(limit, 11.5, 0.01);
    assert_eq!(found.len(), 4);
}

#[test]
fn acceleration_by_the_engine() {
    let found = refused_inputs(&[(2.0, 0.0), (4.5, 0.0)]);
    assert_eq!(names(&found), ["acceleration"].into());
    let (step, value, limit) = first(&found, "acceleration");
    assert_eq!(step, STEP + 1);
    assert_near(value, 4.5, 1e-6);
    // By the engine's power: 11.5 · 7.319 / 28.65.
    assert_near(limit, 11.5 * 7.319 / 28.65, 0.01);
}

#[test]
fn jerk_at_the_joint_and_later() {
    let found = refused_inputs(&[(-8.0, 0.0), (-8.0, 0.0), (0.0, 0.0), (0.0, 0.0)]);
    assert_eq!(names(&found), ["jerk"].into());
    let steps: Vec<_> = found.iter().map(|r| r.step).collect();
    assert_eq!(steps, [Some(STEP), Some(STEP + 2)]);
    let (_, value, limit) = first(&found, "jerk");
    assert_near(value, 80.0, 0.1);
    assert_near(limit, 30.0, 0.02);
}

#[test]
fn friction_circle() {
    let found = refused_inputs(&[(0.0, -0.2), (0.0, -0.2), (0.0, -0.2), (0.0, 0.0)]);
    assert_eq!(names(&found), ["friction circle"].into());
    let (_, value, limit) = first(&found, "friction circle");
    assert_near(limit, 11.5, 0.3);
    assert!(value > limit && value < 20.0, "{value}");
}

#[test]
fn steering_rate_later_and_at_the_joint() {
    let found = refused_inputs(&[(0.0, 0.0), (0.0, 1.0), (0.0, -1.0), (0.0, 0.0)]);
    assert!(names(&found).contains("steering rate"), "{found:?}");
    // In a bend so wide that the wheels stand nearly straight.
    let scenario = alone("JamTail", 303);
    let jump = driven(&scenario, 303, 10, 0.02, &[(0.0, 0.2), (0.0, -0.3)]);
    let passed = Gate::new(&scenario).passes(&jump, None);
    assert!(passed.is_ok(), "{passed:?}");
    let jump = driven(&scenario, 303, 10, 0.1, &[(0.0, 0.0), (0.0, -0.3)]);
    let found = refused(&scenario, &jump);
    assert_eq!(names(&found), ["steering rate"].into());
    let (step, value, limit) = first(&found, "steering rate");
    assert_eq!((step, found.len()), (10, 1));
    assert!((0.9..1.1).contains(&value), "{value}");
    assert_near(limit, 0.4, 0.02);
}

#[test]
fn steering_angle_and_yaw_rate() {
    // A lorry at 4 m/s, which can turn its wheels by 0.55 rad at most.
    let scenario = alone("JamTail", 302);
    let change = driven(&scenario, 302, 10, 0.0, &[(0.0, 0.7); 9]);
    let found = refused(&scenario, &change);
    assert!(names(&found).contains("steering angle"), "{found:?}");
    assert!(names(&found).contains("yaw rate"), "{found:?}");
    let (step, value, limit) = first(&found, "steering angle");
    assert_eq!(step, 18);
    assert_near(value, 0.595, 0.01);
    assert_near(limit, 0.55, 0.001);
}

#[test]
fn driving_backwards() {
    let scenario = alone("JamTail", 303);
    let change = driven(
        &scenario,
        303,
        10,
        0.0,
        &[-2.5, -5.0, -7.5, -9.0, -9.0, -9.0, -9.0].map(|a| (a, 0.0)),
    );
    let found = refused(&scenario, &change);
    assert_eq!(names(&found), ["speed backwards"].into());
    assert_eq!(first(&found, "speed backwards").0, 16);
}

#[test]
fn the_largest_speed() {
    // Recorded at 55 m/s: that is the recording's own fault, a change to it is not.
    let scenario = motorway();
    let mut fast = driven(&scenario, CAR, 0, 0.0, &[(0.0, 0.0); 20]);
    let forward = fast.motions[0].1.pose.forward();
    for (k, (_, motion)) in fast.motions.iter_mut().enumerate() {
        motion.velocity = 55.0;
        motion.pose.position += forward * ((55.0 - 28.0) * 0.1 * k as f64);
    }
    let scenario = fast.apply(&scenario).unwrap();
    let change = driven(&scenario, CAR, 5, 0.0, &[(-1.0, 0.0); 4]);
    let found = refused(&scenario, &change);
    assert_eq!(names(&found), ["speed"].into());
    let (step, value, limit) = first(&found, "speed");
    assert_eq!((step, found.len()), (6, 4));
    assert_near(value, 54.9, 1e-6);
    assert_near(limit, 50.8, 0.01);
}

#[test]
fn a_jump() {
    let scenario = motorway();
    let mut change = driven(&scenario, CAR, STEP, 0.0, &[(0.0, 0.0); 6]);
    for (_, motion) in &mut change.motions[3..] {
        motion.pose.position += motion.pose.forward() * 10.0;
    }
    let found = refused(&scenario, &change);
    let all = ["displacement", "jump", "velocity of the displacement"].into();
    assert_eq!(names(&found), all);
    let (step, value, limit) = first(&found, "jump");
    assert_eq!(step, STEP + 2);
    assert_near(value, 12.8, 0.001);
    assert_near(limit, 2.8 + 0.0575 + 0.01, 0.001);
    let (step, value, limit) = first(&found, "velocity of the displacement");
    assert_eq!(step, STEP + 2);
    assert_near(value, 100.0, 0.1);
    assert_near(limit, 0.125, 0.01);
    assert_eq!(first(&found, "displacement").0, STEP + 2);
}

#[test]
fn speeds_that_are_not_those_of_the_way() {
    let scenario = motorway();
    let change = driven(&scenario, CAR, STEP, 0.0, &[(0.0, 0.0); 6]);
    let found = refused(&scenario, &drifting(change, 0.03, 0.0));
    let both = ["displacement", "velocity of the displacement"].into();
    assert_eq!(names(&found), both);
    assert_near(first(&found, "velocity of the displacement").1, 0.3, 0.01);
}

#[test]
fn moving_across_the_heading() {
    let scenario = motorway();
    let change = driven(&scenario, CAR, STEP, 0.0, &[(0.0, 0.0); 6]);
    let found = refused(&scenario, &drifting(change, 0.0, -0.15));
    assert_eq!(names(&found), ["heading along motion", "slip"].into());
    let (step, value, limit) = first(&found, "heading along motion");
    assert_eq!(step, STEP);
    assert_near(value, (0.15f64 / 2.8).atan(), 0.002);
    assert!(limit < 0.025);
}

#[test]
fn turning_about_the_middle_is_no_vehicle() {
    // The heading turns, the way does not.
    let scenario = motorway();
    let mut change = driven(&scenario, CAR, STEP, 0.0, &[(0.0, 0.0); 6]);
    for (k, (_, motion)) in change.motions.iter_mut().enumerate() {
        motion.pose.heading += 0.03 * k as f64;
    }
    assert!(names(&refused(&scenario, &change)).contains("heading along motion"));
}

#[test]
fn accelerations_that_are_only_said() {
    let scenario = motorway();
    let mut change = driven(&scenario, CAR, STEP, 0.0, &[(0.0, 0.0); 6]);
    change.motions[3].1.acceleration = -7.0;
    let found = refused(&scenario, &change);
    assert_eq!(names(&found), ["said acceleration"].into());
    let (step, value, limit) = first(&found, "said acceleration");
    assert_eq!(step, STEP + 3);
    assert_near(value, 7.0, 1e-6);
    assert_near(limit, 3.0, 0.01);
}

#[test]
fn the_bounds_of_the_model_keep_their_names() {
    let refusals = refused_inputs(&[(2.0, 0.0), (4.5, 0.0)]);
    assert_eq!(refusals[0].reason, Reason::Kinematics(Bound::Acceleration));
    let said = refusals[0].to_string();
    assert!(
        said.starts_with("step 71: acceleration 4.5000 m/s²"),
        "{said}"
    );
}

//! The check alone: what it passes, and each bound broken at a known step.

use nearmiss::geometry::Vector;
use nearmiss::planner::{Bound, Broken, Feasibility, Tolerance, VehicleState};
use proptest::prelude::*;

use super::inputs::{DT, Input, after, begin, friction, limits, states, track};

fn check() -> Feasibility {
    Feasibility::new(limits(), DT)
}

fn steady(rate: f64, acceleration: f64) -> Input {
    Input { rate, acceleration }
}

/// What the states break, the first one at step 100.
fn broken(states: &[VehicleState]) -> Vec<Broken> {
    check()
        .states(100, states)
        .err()
        .map_or(Vec::new(), |e| e.0)
}

fn tracked(states: &[VehicleState]) -> Vec<Broken> {
    check()
        .track(&track(100, states))
        .err()
        .map_or(Vec::new(), |e| e.0)
}

fn places(broken: &[Broken]) -> Vec<(i64, Bound)> {
    broken.iter().map(|b| (b.step, b.bound)).collect()
}

#[test]
fn straight_curved_braked_and_parked_can_be_driven() {
    let still = steady(0.0, 0.0);
    for (first, inputs) in [
        (begin(30.0, 0.0), vec![still; 40]),
        (begin(8.0, 0.15), vec![still; 40]),
        (
            begin(20.0, 0.0),
            [vec![steady(0.0, -10.0); 20], vec![still; 10]].concat(),
        ),
        (begin(0.0, 0.5), vec![still; 20]),
        (begin(0.0, 0.3), vec![steady(-0.2, 2.0); 20]),
        (begin(2.0, -0.7), vec![steady(0.3, 0.0); 40]),
    ] {
        let states = states(first, &inputs);
        assert_eq!(broken(&states), []);
        assert_eq!(tracked(&states), []);
        let feasible = check().states(100, &states).unwrap();
        assert_eq!(feasible.steps, inputs.len());
        let most = states
            .iter()
            .map(|s| friction(s, s.acceleration) / 11.5)
            .fold(0.0, f64::max);
        assert!(
            (feasible.friction - most).abs() < 0.02,
            "{feasible:?} {most}"
        );
    }
}

#[test]
fn nothing_and_one_state_can_be_driven() {
    assert_eq!(check().states(0, &[]).unwrap().steps, 0);
    assert_eq!(check().states(0, &[begin(10.0, 0.1)]).unwrap().steps, 0);
    assert_eq!(check().track(&track(0, &[])).unwrap().steps, 0);
}

/// Twenty steps from `first`, the sixth with another input.
fn with_one(first: VehicleState, usual: Input, one: Input) -> Vec<VehicleState> {
    let mut inputs = vec![usual; 20];
    inputs[5] = one;
    states(first, &inputs)
}

#[test]
fn inputs_beyond_a_limit_are_found_at_their_step() {
    let l = limits();
    let usual = steady(0.0, 0.0);
    let forward = 11.5 * l.switch_speed / 20.0;
    for (speed, angle, one, bounds, value) in [
        (
            20.0,
            0.0,
            steady(0.0, forward * 1.1),
            vec![Bound::Acceleration],
            forward * 1.1,
        ),
        (
            3.0,
            0.0,
            steady(0.0, 12.0),
            vec![Bound::Acceleration, Bound::Friction],
            12.0,
        ),
        (
            20.0,
            0.0,
            steady(0.0, -12.0),
            vec![Bound::Acceleration, Bound::Friction],
            12.0,
        ),
        (5.0, 0.1, steady(0.44, 0.0), vec![Bound::SteeringRate], 0.44),
        (
            5.0,
            0.1,
            steady(-0.44, 0.0),
            vec![Bound::SteeringRate],
            0.44,
        ),
        (15.0, 0.1, steady(0.0, -8.0), vec![Bound::Friction], 11.8),
    ] {
        let found = broken(&with_one(begin(speed, angle), usual, one));
        let expected: Vec<_> = bounds.iter().map(|b| (105, *b)).collect();
        assert_eq!(places(&found), expected, "{found:?}");
        assert!((found[0].value - value).abs() < 0.1 * value, "{found:?}");
        assert!(found[0].most < found[0].value && found[0].most > 0.0);
    }
}

#[test]
fn states_beyond_a_limit_are_found_at_their_step() {
    let l = limits();
    // Rolls back from step 104 on.
    let back = states(
        begin(1.0, 0.0),
        &[vec![steady(0.0, -3.0); 4], vec![steady(0.0, 0.0); 1]].concat(),
    );
    assert_eq!(
        places(&broken(&back)),
        [(104, Bound::Backwards), (105, Bound::Backwards)]
    );
    assert_eq!(
        places(&tracked(&back)),
        [(104, Bound::Backwards), (105, Bound::Backwards)]
    );
    // 51 m/s from the fifth state on.
    let fast = states(begin(50.6, 0.0), &[steady(0.0, 0.5); 5]);
    assert_eq!(places(&broken(&fast)), [(105, Bound::Speed)]);
    assert_eq!(places(&tracked(&fast)), [(105, Bound::Speed)]);
    let turned = states(begin(1.0, l.steering - 0.11), &[steady(0.3, 0.0); 4]);
    assert_eq!(places(&broken(&turned)), [(104, Bound::SteeringAngle)]);
}

#[test]
fn states_that_do_not_follow_from_each_other_are_found() {
    let usual = |speed| states(begin(speed, 0.0), &[steady(0.0, 0.0); 6]);
    let last = |speed, change: &dyn Fn(&mut VehicleState)| {
        let mut states = usual(speed);
        change(states.last_mut().unwrap());
        places(&broken(&states))
    };
    let jumped = |by: f64, side: f64| {
        move |s: &mut VehicleState| {
            let forward = s.rear.forward();
            let left = Vector::new(-forward.y, forward.x);
            s.rear.position += forward * by + left * side;
        }
    };
    assert_eq!(last(12.0, &jumped(0.05, 0.0)), [(105, Bound::Displacement)]);
    assert_eq!(
        last(12.0, &jumped(-0.05, 0.0)),
        [(105, Bound::Displacement)]
    );
    assert_eq!(last(12.0, &jumped(0.0, 0.05)), [(105, Bound::Slip)]);
    assert_eq!(last(12.0, &jumped(0.015, 0.01)), []);
    assert_eq!(
        last(12.0, &|s| s.rear.heading += 0.04),
        [(105, Bound::Heading)]
    );
    assert_eq!(last(12.0, &|s| s.rear.heading -= 0.02), []);
    assert_eq!(
        last(0.0, &|s| s.rear.heading += 0.02),
        [(105, Bound::YawRate)]
    );
    assert_eq!(last(12.0, &|s| s.rear.position.x = f64::NAN).len(), 1);
    // A body that moves sideways all the time, as one that slides.
    let mut sliding = usual(12.0);
    for state in &mut sliding {
        state.rear.heading += 0.1;
    }
    let expected: Vec<_> = (100..106).map(|step| (step, Bound::Slip)).collect();
    assert_eq!(places(&broken(&sliding)), expected);
    assert_eq!(places(&tracked(&sliding)), expected);
}

#[test]
fn a_track_shows_what_its_states_do() {
    // Half a metre is missing at one step: the state there is off from both sides.
    let mut jump = states(begin(12.0, 0.0), &[steady(0.0, 0.0); 10]);
    let forward = jump[4].rear.forward();
    jump[4].rear.position += forward * 0.5;
    assert_eq!(
        places(&tracked(&jump)),
        [(103, Bound::Displacement), (104, Bound::Displacement)]
    );
    // The wheels turn too fast for three steps.
    let mut inputs = vec![steady(0.0, 0.0); 20];
    inputs[8..11].fill(steady(0.5, 0.0));
    let found = tracked(&states(begin(5.0, 0.0), &inputs));
    assert!(
        found.iter().all(|b| b.bound == Bound::SteeringRate),
        "{found:?}"
    );
    assert_eq!(
        places(&found),
        [(109, Bound::SteeringRate), (110, Bound::SteeringRate)]
    );
    // Too much of the friction circle from step 105 on.
    let tight = states(begin(15.0, 0.14), &[steady(0.0, 0.0); 6]);
    assert_eq!(tracked(&tight).len(), 6);
    assert!(tracked(&tight).iter().all(|b| b.bound == Bound::Friction));
    // A standing vehicle does not turn.
    let mut parked = states(begin(0.0, 0.0), &[steady(0.0, 0.0); 6]);
    for state in &mut parked[3..] {
        state.rear.heading += 0.02;
    }
    let mut found = tracked(&parked);
    // The centre moves when a body turns about its rear axle; the rear axle does not.
    assert_eq!(places(&found), [(102, Bound::YawRate)]);
    assert!((found.remove(0).value - 0.2).abs() < 1e-9);
}

#[test]
fn steps_that_are_missing_are_found() {
    let states = states(begin(12.0, 0.0), &[steady(0.0, 0.0); 10]);
    let mut samples: Vec<nearmiss::scenario::Sample> = track(100, &states)
        .iter()
        .map(|(step, m)| nearmiss::scenario::Sample {
            step,
            position: m.pose.position,
            heading: Some(m.pose.heading),
            velocity: Some(m.velocity),
            acceleration: None,
        })
        .collect();
    samples.drain(4..6);
    let holed = nearmiss::scenario::Track::new(samples, DT, None);
    let error = check().track(&holed).unwrap_err();
    assert_eq!(places(&error.0), [(103, Bound::Gap)]);
    assert_eq!(
        error.to_string(),
        "step 103: gap 3.0000 steps, at most 1.0000 (1 in all)"
    );
}

#[test]
fn one_step_may_break_several_bounds() {
    let states = with_one(begin(5.0, 0.1), steady(0.0, 0.0), steady(0.6, -14.0));
    let found = broken(&states);
    assert!(
        found.len() > 2 && found.iter().all(|b| b.step == 105),
        "{found:?}"
    );
}

#[test]
fn tolerances_and_vehicles_are_data() {
    let mut states = states(begin(12.0, 0.0), &[steady(0.0, 0.0); 6]);
    let forward = states[6].rear.forward();
    states[6].rear.position += forward * 0.05;
    let wide = Tolerance {
        position: 0.06,
        ..Tolerance::default()
    };
    assert!(check().within(wide).states(0, &states).is_ok());
    // A truck does not reach what a car drives.
    let fast = super::inputs::states(begin(30.0, 0.0), &[steady(0.0, 0.0); 3]);
    let truck = nearmiss::planner::Limits::for_vehicle(nearmiss::scenario::VehicleType::Truck);
    let error = Feasibility::new(truck, DT).states(0, &fast).unwrap_err();
    assert_eq!(error.0.len(), 4);
    assert!(error.0.iter().all(|b| b.bound == Bound::Speed));
}

/// Inputs in −1 to 1 made to fit the limits at each state they meet.
fn fitted(first: VehicleState, wanted: &[(f64, f64)]) -> Vec<VehicleState> {
    let l = limits();
    let mut all = vec![first];
    for (turn, push) in wanted {
        let now = *all.last().unwrap();
        let angle = (now.curvature * l.wheelbase).atan();
        let mut input = steady(l.steering_rate * turn, l.acceleration * push);
        // Less of everything until all of it is kept on the way; wheels go back where that is not enough.
        for shrink in 0.. {
            assert!(shrink < 200, "{now:?} cannot go on");
            let next = after(&now, input);
            let end = (next.curvature * l.wheelbase).atan();
            let fits = next.velocity >= -1e-9
                && next.velocity <= l.speed
                && end.abs() <= l.steering
                && input.acceleration <= l.forward(next.velocity.max(now.velocity))
                && (0..=20).all(|i| {
                    let t = DT * f64::from(i) / 20.0;
                    let v = now.velocity + input.acceleration * t;
                    let k = (angle + input.rate * t).tan() / l.wheelbase;
                    input.acceleration.hypot(v * v * k) <= l.acceleration
                });
            if fits {
                all.push(next);
                break;
            }
            input.acceleration *= 0.8;
            input.rate = if shrink < 40 {
                input.rate * 0.8
            } else {
                -angle.signum() * 0.02
            };
        }
    }
    all
}

fn start() -> impl Strategy<Value = VehicleState> {
    (0.0..45.0_f64, -1.0..1.0_f64).prop_map(|(v, share)| {
        let l = limits();
        let most = (0.9 * l.acceleration / (v * v).max(1.0) * l.wheelbase).atan();
        begin(v, share * most.min(0.95 * l.steering))
    })
}

fn pushes() -> impl Strategy<Value = Vec<(f64, f64)>> {
    proptest::collection::vec((-1.0..=1.0_f64, -1.0..=1.0_f64), 2..30)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn whatever_keeps_the_limits_passes(first in start(), wanted in pushes()) {
        let states = fitted(first, &wanted);
        prop_assert_eq!(broken(&states), []);
        prop_assert_eq!(tracked(&states), []);
    }

    #[test]
    fn a_tenth_too_much_at_one_step_is_found_there(
        first in start(),
        wanted in pushes(),
        place in 0.0..1.0_f64,
        steers in any::<bool>(),
        side in any::<bool>(),
    ) {
        let l = limits();
        let mut states = fitted(first, &wanted);
        let place = (place * (states.len() - 1) as f64) as usize;
        states.truncate(place + 1);
        let now = states[place];
        let sign = if side { 1.0 } else { -1.0 };
        let mut input = steady(0.0, 0.0);
        let bound = if steers {
            input.rate = 1.1 * l.steering_rate * sign;
            Bound::SteeringRate
        } else if side {
            // What is allowed at the speed that it leads to.
            input.acceleration = 1.1 * l.forward(now.velocity + 1.2 * l.forward(now.velocity) * DT);
            input.acceleration = input.acceleration.max(1.1 * l.forward(now.velocity + input.acceleration * DT));
            Bound::Acceleration
        } else {
            input.acceleration = -1.1 * l.acceleration;
            Bound::Acceleration
        };
        states.push(after(&now, input));
        let found = broken(&states);
        prop_assert!(found.iter().any(|b| b.bound == bound && b.step == 100 + place as i64), "{:?}", found);
        prop_assert!(found.iter().all(|b| b.step >= 100 + place as i64), "{:?}", found);
    }
}

//! Tests of who attacks, and of where is looked between attacks.

use super::{CAR, attack, behind_a_car, braking, car, state};
use crate::generation::attacker::{self, Candidate};
use crate::generation::manoeuvre::{ManoeuvreSpace, Numbers};
use crate::generation::screening::{Trial, between};
use crate::generation::{AttackContext, AttackPlace, ClosedLoop, Wish};
use crate::planner::Forecast;
use nearmiss_base::geometry::Vector;
use nearmiss_scene::scenario::{Ego, Motion, ObstacleType, Scenario, State};
use std::f64::consts::{FRAC_PI_2, PI};

fn ego(closed: &ClosedLoop) -> Ego {
    closed.baseline().staged().ego(closed.driver())
}

fn the_car(scenario: &Scenario, ego: &Ego) -> Candidate {
    let stage = AttackContext::new(scenario, &ego.footprint, &ego.track).unwrap();
    let mut ranked = attacker::rank(&stage).into_iter();
    ranked.find(|c| c.obstacle == CAR).unwrap()
}

#[test]
fn a_car_in_front_reaches_the_ego_by_braking_only_where_it_drives() {
    let closed = behind_a_car(25.0, Forecast::Lane);
    let (scenario, ego) = (closed.scenario(), ego(&closed));
    let drives = the_car(scenario, &ego);
    assert!(drives.reaches && !drives.behind);

    let track = scenario.obstacle(CAR).unwrap().track();
    let mut end = *track.iter().last().unwrap().1;
    // Where the ego does not get to.
    end.pose.position += end.pose.forward() * 50.0;
    end.velocity = 0.0;
    let states: Vec<State> = track.steps().map(|step| state(step, &end)).collect();
    let mut standing = Scenario::clone(scenario);
    standing.obstacles = vec![car(&states, scenario.dt())];
    let stands = the_car(&standing, &ego);
    assert!(!stands.reaches && !stands.behind);

    let why = |scenario: &Scenario, among: &[i64]| {
        let stage = AttackContext::new(scenario, &ego.footprint, &ego.track).unwrap();
        attacker::why_none(&stage, among)
    };
    assert_eq!(why(scenario, &[]), None);
    assert_eq!(why(scenario, &[CAR]), None);
    assert_eq!(
        why(&standing, &[]),
        Some("the ego is reached only in reverse")
    );
    assert_eq!(why(scenario, &[CAR + 1]), Some("none moves by itself"));
    let mut short = Scenario::clone(scenario);
    short.obstacles = vec![car(&states[..2], scenario.dt())];
    assert_eq!(
        why(&short, &[]),
        Some("none has been there for 0.5 s when the ego drives 2 m/s or faster")
    );
    let slow = ego.track.iter().map(|(step, motion)| {
        let motion = Motion {
            velocity: 1.9,
            ..*motion
        };
        state(step, &motion)
    });
    let slow = car(&slow.collect::<Vec<_>>(), scenario.dt());
    let stage = AttackContext::new(scenario, &ego.footprint, slow.track()).unwrap();
    assert_eq!(
        attacker::why_none(&stage, &[]),
        Some("the ego drives slower than 2 m/s at every step")
    );
}

#[test]
fn a_wish_allows_who_is_where_it_says() {
    let closed = behind_a_car(25.0, Forecast::Lane);
    let (scenario, ego) = (closed.scenario(), ego(&closed));
    let wish = |places: &[AttackPlace]| Wish {
        places: places.to_vec(),
        ..Wish::default()
    };
    let allowed = |scenario: &Scenario, wish: &Wish| {
        let stage = AttackContext::new(scenario, &ego.footprint, &ego.track).unwrap();
        wish.allows(&stage, &the_car(scenario, &ego))
    };
    let of_place = |scenario: &Scenario| -> Vec<AttackPlace> {
        let all = AttackPlace::ALL.into_iter();
        all.filter(|place| allowed(scenario, &wish(&[*place])))
            .collect()
    };
    assert_eq!(of_place(scenario), [AttackPlace::Ahead]);
    // Moved and turned about the middle of its body: 6 m to a side, where the ego passes it.
    let track = scenario.obstacle(CAR).unwrap().track();
    let changed = |left: f64, turn: f64| {
        let states = track.iter().map(|(step, motion)| {
            let mut motion = *motion;
            let aside = motion
                .pose
                .forward()
                .yx()
                .component_mul(&Vector::new(-left, left));
            motion.pose.position += aside;
            motion.pose.heading += turn;
            state(step, &motion)
        });
        let mut scenario = Scenario::clone(scenario);
        scenario.obstacles = vec![car(&states.collect::<Vec<_>>(), scenario.dt())];
        scenario
    };
    assert_eq!(
        of_place(&changed(4.0, 0.0)),
        [AttackPlace::Ahead, AttackPlace::LeftLane]
    );
    assert_eq!(
        of_place(&changed(-4.0, 0.0)),
        [AttackPlace::Ahead, AttackPlace::RightLane]
    );
    // A car that changes from the right to the left while nothing is changed attacks from where it is then.
    let (right, left) = (changed(-4.0, 0.0), changed(4.0, 0.0));
    let (early, late) = (track.steps().start, track.steps().end - 1);
    let motions = (early..=late).map(|step| {
        let on = if step < 20 { &right } else { &left };
        state(step, on.obstacle(CAR).unwrap().track().at(step).unwrap())
    });
    let mut crossing = Scenario::clone(scenario);
    crossing.obstacles = vec![car(&motions.collect::<Vec<_>>(), scenario.dt())];
    let stage = AttackContext::new(&crossing, &ego.footprint, &ego.track).unwrap();
    let from_left = wish(&[AttackPlace::LeftLane]);
    assert!(!from_left.allows_begin(&stage, CAR, 10) && from_left.allows_begin(&stage, CAR, 25));
    assert_eq!(of_place(&changed(0.0, FRAC_PI_2)), [AttackPlace::FromRight]);
    assert_eq!(of_place(&changed(0.0, -FRAC_PI_2)), [AttackPlace::FromLeft]);
    assert_eq!(of_place(&changed(0.0, PI)), [AttackPlace::Oncoming]);

    // A van that stands between the ego and the car hides it.
    let mut hidden = Scenario::clone(scenario);
    let mut stands = *ego.track.at(the_car(scenario, &ego).step).unwrap();
    stands.velocity = 0.0;
    stands.pose.position += stands.pose.forward() * 12.0;
    let states: Vec<State> = track.steps().map(|step| state(step, &stands)).collect();
    let mut van = car(&states, scenario.dt());
    van.id = CAR + 1;
    hidden.obstacles.push(van);
    assert!(allowed(
        &hidden,
        &wish(&[AttackPlace::Ahead, AttackPlace::Hidden])
    ));
    assert!(!allowed(
        &hidden,
        &wish(&[AttackPlace::Behind, AttackPlace::Hidden])
    ));
    let cyclist = Wish {
        actors: vec![ObstacleType::Bicycle],
        ..Wish::default()
    };
    assert!(!allowed(scenario, &cyclist) && allowed(scenario, &Wish::default()));
}

#[test]
fn halfway_between_a_hopeless_attack_and_the_nearest_harmless_one_is_tried() {
    let closed = behind_a_car(25.0, Forecast::Lane);
    let (scenario, ego) = (closed.scenario(), ego(&closed));
    let stage = AttackContext::new(scenario, &ego.footprint, &ego.track).unwrap();
    let arms = ManoeuvreSpace::all(&stage, &the_car(scenario, &ego));
    let trial = |arm: usize, numbers: Numbers, deceleration, survivable| Trial {
        arm,
        numbers,
        attack: attack(&closed, braking(&closed, 12, deceleration), survivable),
        is_between: false,
    };
    let hard = trial(0, [4.0, 2.0, 0.0, 0.0], 500.0, Some(false));
    assert!(hard.attack.has_effect());
    let soft = trial(0, [2.0, 2.0, 0.0, 4.0], 0.5, None);
    assert!(!soft.attack.has_effect());
    let farther = trial(0, [0.0, 2.0, 0.0, 4.0], 0.5, None);
    let another = trial(1, [4.0, 2.0, 0.0, 0.0], 0.5, None);
    let tried = [hard, farther, soft, another];
    let halfway = (0, [3.0, 2.0, 0.0, 2.0]);
    assert_eq!(between(&arms, &tried, 2), [halfway]);
    assert_eq!(between(&arms, &tried, 0), []);
    assert_eq!(between(&arms, &tried[1..], 2), []);
}

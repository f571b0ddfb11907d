//! Tests of who attacks, and of where is looked between attacks.

use super::{CAR, attack, behind_a_car, braking, car, state};
use crate::generation::attacker::{self, Candidate};
use crate::generation::manoeuvre_space::{ManoeuvreSpace, Numbers};
use crate::generation::surrogate::{Trial, between};
use crate::generation::{AttackContext, ClosedLoop};
use crate::planner::Forecast;
use crate::scenario::{Ego, Scenario, State};

fn ego(closed: &ClosedLoop) -> Ego {
    closed.baseline().staged().ego(closed.driver())
}

fn the_car(scenario: &Scenario, ego: &Ego) -> Candidate {
    let stage = AttackContext::new(scenario, &ego.footprint, &ego.track).unwrap();
    attacker::rank(&stage)[0]
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

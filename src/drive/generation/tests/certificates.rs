//! Tests of what an ideal driver avoids, and of the certificates.

use std::sync::Arc;

use super::{CAR, attack, behind_a_car, braking};
use crate::generation::{
    Attack, Avoidability, Certificate, DELAYS, Effect, EvasiveTrajectory, Finder, SearchEffort,
    Unavoidable, choose,
};
use crate::planner::{Feasibility, Forecast, VehicleState};
use crate::simulation::{Collision, MotionFault};
use nearmiss_scene::scenario::{RoadUser, Sample, Scenario, Track};

/// Asks everything of a certificate again, by other ways than the search.
fn proves(avoidance: &EvasiveTrajectory, effect: &Effect, reaction: i64) {
    let drive = &avoidance.drive;
    let body = crate::planner::Road::body_of(&drive.limits);
    for (step, state) in &drive.states {
        let placed = body.at(state.centre(&drive.limits).pose);
        assert_eq!(Collision::at(&effect.scenario, &placed, *step, None), None);
    }
    let first = drive.states[0].0;
    let later = &drive.states[(reaction - first) as usize..];
    let states: Vec<_> = later.iter().map(|(_, state)| *state).collect();
    Feasibility::new(drive.limits, drive.dt)
        .states(reaction, &states)
        .unwrap();
}

#[test]
fn a_stop_far_ahead_is_avoided_also_by_who_reacts_late() {
    let closed = behind_a_car(60.0, Forecast::Lane);
    let effect = closed.effect(&braking(&closed, 5, 9.0).into()).unwrap();
    let found = Avoidability::search(&closed, &effect);
    let unchanged = &closed.baseline().drive().states;
    let longest = found.certificates[3].1.avoidance().unwrap();
    for (delay, certificate) in &found.certificates {
        assert_eq!(found.at(*delay), Some(true), "{delay} s");
        let avoidance = certificate.avoidance().unwrap();
        let reaction = 5 + (delay / 0.1).round() as i64;
        proves(avoidance, &effect, reaction);
        // Until then the driver does not react, and afterwards it does.
        let mut until = avoidance
            .drive
            .states
            .iter()
            .zip(unchanged)
            .take_while(|((step, _), _)| *step <= avoidance.reaction);
        assert!(avoidance.reaction >= reaction && until.all(|(a, b)| a == b));
        assert_ne!(&avoidance.drive.states, unchanged);
        // What is avoided late is avoided early by the same trajectory.
        assert!(Arc::ptr_eq(avoidance, longest));
    }
    assert_eq!(found.at(0.7), None);
}

#[test]
fn a_review_says_how_hard_a_way_out_is_and_where_it_leaves_the_lanelets_of_cars() {
    let closed = behind_a_car(60.0, Forecast::Lane);
    let mut effect = closed.effect(&braking(&closed, 5, 9.0).into()).unwrap();
    let found = Avoidability::search(&closed, &effect);
    let (delay, longest) = found.latest().unwrap();
    assert_eq!(delay, 1.5);
    let review = longest.review(&closed, &effect);
    let limit = longest.drive.limits.acceleration;
    assert!(
        (1.0..limit * 1.001).contains(&review.acceleration),
        "{review:?}"
    );
    assert_eq!(review.leaves_roadway, None);
    // It goes on where cars may use only what the ego is on while it does not react.
    let goes_on = EvasiveTrajectory {
        drive: closed.baseline().drive().clone(),
        reaction: longest.reaction,
        found: Finder::Unchanged,
        searched: SearchEffort::default(),
    };
    let mut scenario = Scenario::clone(&effect.scenario);
    let states = &goes_on.drive.states;
    let reacted = states.partition_point(|(step, _)| *step <= goes_on.reaction);
    let (before, after) = states.split_at(reacted);
    let centre = |state: &VehicleState| state.centre(&goes_on.drive.limits).pose;
    let here = centre(&before.last().unwrap().1);
    let there = scenario.network.lanelets_at(&here.position);
    for lanelet in &mut scenario.network.lanelets {
        let on = there.contains(&lanelet.id);
        lanelet.users_one_way = vec![if on {
            RoadUser::Car
        } else {
            RoadUser::Pedestrian
        }];
        lanelet.users_bidirectional.clear();
    }
    let roadway = scenario.network.drivable_area(Some(RoadUser::Car));
    let body = closed.driver().road().body();
    let left = { after.iter() }.find(|(_, state)| !roadway.covers(&body.at(centre(state))));
    effect.scenario = Arc::new(scenario);
    let review = goes_on.review(&closed, &effect);
    assert_eq!(review.leaves_roadway, left.map(|(step, _)| *step));
    assert!(review.leaves_roadway.is_some());
}

#[test]
fn a_motion_that_touches_or_leaves_the_road_is_a_fault() {
    let closed = behind_a_car(25.0, Forecast::Lane);
    let (driver, scenario) = (closed.driver(), closed.scenario());
    let drive = closed.baseline().drive();
    let track = drive.track();
    assert_eq!(driver.fault_of(scenario, &track), None);
    let moved = |left: f64, ahead: f64, from: i64| {
        let motions = track.iter().map(|(step, motion)| {
            let mut motion = *motion;
            if step >= from {
                let (forward, aside) = (motion.pose.forward(), motion.pose.left());
                motion.pose.position += forward * ahead + aside * left;
            }
            Sample {
                step,
                position: motion.pose.position,
                heading: Some(motion.pose.heading),
                velocity: Some(motion.velocity),
                acceleration: Some(motion.acceleration),
            }
        });
        Track::new(motions.collect(), driver.dt(), None)
    };
    let fault = |left, ahead, from| driver.fault_of(scenario, &moved(left, ahead, from));
    assert!(
        matches!(fault(0.0, 25.0, 7), Some(MotionFault::Contact(c)) if c.with == CAR && c.step == 7)
    );
    // Through the car and out of it before the next step.
    assert!(
        matches!(fault(0.0, 60.0, 7), Some(MotionFault::Contact(c)) if c.with == CAR && c.step == 7 && c.between)
    );
    assert_eq!(fault(-40.0, 0.0, 7), Some(MotionFault::OffRoad(7)));
}

#[test]
fn a_wall_right_in_front_is_not_avoided() {
    let closed = behind_a_car(8.0, Forecast::Lane);
    let effect = closed.effect(&braking(&closed, 1, 500.0).into()).unwrap();
    let found = Avoidability::search(&closed, &effect);
    for (delay, certificate) in &found.certificates {
        assert_eq!(found.at(*delay), Some(false));
        let Certificate::NotFound(nothing) = certificate else {
            panic!("{delay} s: {certificate:?}");
        };
        let searched = nothing.searched;
        if *delay == 0.0 {
            assert_eq!(nothing.why, Unavoidable::NothingFound);
            assert!(searched.manoeuvres > 100 && searched.drives == 4);
            assert!(searched.cycles >= 4 && searched.candidates > searched.cycles);
        } else {
            // The unchanged drive is in the wall by then.
            assert!(
                matches!(nothing.why, Unavoidable::TooEarly(c) if c.with == effect.main().obstacle)
            );
            assert_eq!(searched.manoeuvres, 0);
        }
    }
}

#[test]
fn who_reacts_late_avoids_less() {
    // Full braking behind full braking, close: without a delay there is room, with a long one there is not.
    let closed = behind_a_car(16.0, Forecast::Lane);
    let effect = closed.effect(&braking(&closed, 10, 11.0).into()).unwrap();
    let found = Avoidability::search(&closed, &effect);
    assert_eq!(found.at(0.0), Some(true));
    let avoided: Vec<bool> = DELAYS.iter().map(|d| found.at(*d).unwrap()).collect();
    assert!(avoided.is_sorted_by(|a, b| a >= b), "{avoided:?}");
    let avoidance = found.certificates[0].1.avoidance().unwrap();
    proves(avoidance, &effect, 10);
}

#[test]
fn what_is_known_to_be_survived_is_chosen_behind_any_number_of_walls() {
    let closed = behind_a_car(8.0, Forecast::Lane);
    let mut attacks: Vec<Attack> = (0..6)
        .map(|n| attack(&closed, braking(&closed, 1, 500.0 + f64::from(n)), None))
        .collect();
    let walls = choose(&closed, &attacks, 0.0, false).unwrap();
    assert_eq!(walls.avoidability.at(0.0), Some(false));
    let mut gentle = (1..12).map(|n| {
        let change = braking(&closed, 10, f64::from(n));
        attack(&closed, change, Some(true))
    });
    let survived = gentle
        .find(|attack| {
            let effect = attack.effect.as_ref().unwrap();
            let certificate = Avoidability::with(&closed, effect, 0.0);
            attack.has_effect() && certificate.avoidance().is_some()
        })
        .unwrap();
    attacks.push(survived.clone());
    let chosen = choose(&closed, &attacks, 0.0, false).unwrap();
    assert_eq!(chosen.attack.change, survived.change);
    assert_eq!(chosen.avoidability.at(0.0), Some(true));
}

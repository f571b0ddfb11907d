//! Tests of the ego against a change.

use super::{CAR, ClosedLoop, behind_a_car, braking, car, settings, state};
use crate::generation::effect::comes_near;
use crate::generation::{Change, ChangeError, Consequence, Effect};
use crate::planner::Forecast;
use crate::simulation::{Collision, ContactSide, DriveSpan, Driver, Outcome};
use nearmiss_base::geometry::{Footprint, Pose, Shape};
use nearmiss_formats::bundled;
use nearmiss_scene::scenario::{Motion, Scenario};

/// The lowest risk score of the car in the baseline.
fn lowest_before(closed: &ClosedLoop) -> Option<u8> {
    let risk = closed.baseline().risk_of(CAR);
    risk.iter().map(|(_, score)| *score).min()
}

#[test]
fn what_is_taken_over_from_the_baseline_is_what_would_be_planned_anew() {
    for (forecast, from, most) in [(Forecast::Lane, 12, 13), (Forecast::Recorded, 48, 9)] {
        let closed = behind_a_car(25.0, forecast);
        let change = braking(&closed, from, 7.0);
        let effect = closed.effect(&change.clone().into()).unwrap();
        let last = closed.driver().full_span().last;
        // A planner that follows all candidates plans the same as one that gives them up early.
        let driver = closed.driver();
        let anew = driver.drive_noted_watched(&effect.scenario, last, &mut |_, _| true);
        // The oracle knows of the change a horizon of 40 steps earlier.
        assert_eq!(effect.taken_over, most, "{}", forecast.name());
        assert_eq!(anew.taken_over, 0);
        assert_eq!(effect.drive.states, anew.drive.states);
        assert_eq!(effect.drive.outcome, anew.drive.outcome);
        let (some, all) = (&effect.drive.cycles, &anew.drive.cycles);
        assert_eq!(some.len(), all.len());
        for (a, b) in some.iter().zip(all) {
            assert_eq!(a.plan.states, b.plan.states);
            assert_eq!(a.plan.cost, b.plan.cost);
            assert_eq!(a.plan.emergency, b.plan.emergency);
        }
        // And the change has an effect at all.
        assert_ne!(effect.drive.states, closed.baseline().drive().states);
    }
}

#[test]
fn a_coarse_drive_takes_over_each_cycle_and_then_plans_every_second_step() {
    let closed = behind_a_car(25.0, Forecast::Lane);
    let change = braking(&closed, 12, 7.0);
    let before = closed.baseline().staged();
    let effect = closed
        .coarse_effect_until(&change.into(), before, i64::MAX)
        .unwrap();
    let steps: Vec<i64> = effect.drive.cycles.iter().map(|c| c.step).collect();
    assert_eq!(effect.taken_over, 13);
    assert!(steps.len() > 20, "{steps:?}");
    // The last cycle that is taken over is followed as it was in the drive that planned it.
    for (i, pair) in steps.windows(2).enumerate() {
        assert_eq!(pair[1] - pair[0], if i < 13 { 1 } else { 2 }, "{i}");
    }
    let recorded = &closed.baseline().drive().states;
    assert_eq!(effect.drive.states[..14], recorded[..14]);
}

#[test]
fn the_recorded_motion_is_no_change() {
    let closed = behind_a_car(25.0, Forecast::Lane);
    let track = closed.scenario().obstacle(CAR).unwrap().track();
    let motions = track.iter().filter(|(step, _)| *step >= 5);
    let change = Change {
        obstacle: CAR,
        motions: motions.map(|(step, motion)| (step, *motion)).collect(),
    };
    let effect = closed.effect(&change.clone().into()).unwrap();
    assert_eq!(effect.drive.states, closed.baseline().drive().states);
    assert_eq!(effect.consequence, Consequence::NoEffect);
    assert_eq!(effect.main().before, effect.main().after);
    assert_eq!(effect.lowest_after(), lowest_before(&closed));
    assert_eq!(effect.anyone_after, closed.baseline().lowest());
    // 25 m between the middles of two cars of 4.5 m that go on as fast as each other.
    assert!(effect.distance().is_some_and(|d| d > 15.0 && d < 22.0));
}

#[test]
fn of_two_who_touch_the_ego_at_a_step_the_first_one_counts() {
    let closed = behind_a_car(25.0, Forecast::Lane);
    let mut scenario = Scenario::clone(closed.scenario());
    let along = |x: f64| Motion {
        pose: Pose::new(x, 0.0, 0.0),
        velocity: 0.0,
        acceleration: 0.0,
    };
    let from_to = |id: i64, from: f64, to: f64| {
        let mut obstacle = car(&[state(0, &along(from)), state(1, &along(to))], 0.1);
        obstacle.id = id;
        obstacle
    };
    // One comes from the front and touches the body of 4.5 m just before step 1; the other one, which comes later in
    // the file, is in its rear long before that.
    scenario.obstacles = vec![from_to(1, 10.0, 4.4), from_to(2, -5.0, -3.5)];
    let body = Footprint::new(Shape::rectangle(4.5, 1.8)).unwrap();
    let ego = body.at(Pose::new(0.0, 0.0, 0.0));
    let at = Collision::at(&scenario, &ego, 1, None).unwrap();
    assert_eq!(at.with, 1);
    let first = |before| Collision::first(&scenario, &ego, before, 1, None).unwrap();
    assert_eq!((first(None).with, first(Some(ego.pose)).with), (1, 2));
    assert_eq!(first(Some(ego.pose)).ego, ContactSide::Rear);
}

#[test]
fn the_sides_of_a_contact_are_those_of_the_first_touch() {
    let closed = behind_a_car(25.0, Forecast::Lane);
    let mut scenario = Scenario::clone(closed.scenario());
    let at = |x: f64, y: f64| Motion {
        pose: Pose::new(x, y, 0.0),
        velocity: 28.0,
        acceleration: 0.0,
    };
    // From 1 m behind, 0.3 m over the ego's edge, 2.8 m on: 1.8 m deep at the step, by its length a touch of the sides.
    let mut behind = car(&[state(0, &at(-5.5, 1.5)), state(1, &at(-2.7, 1.5))], 0.1);
    behind.id = 1;
    scenario.obstacles = vec![behind];
    let body = Footprint::new(Shape::rectangle(4.5, 1.8)).unwrap();
    let ego = body.at(Pose::new(0.0, 0.0, 0.0));
    let sides = |one: Collision| (one.ego, one.other);
    let at_the_step = Collision::at(&scenario, &ego, 1, None).unwrap();
    assert_eq!(sides(at_the_step), (ContactSide::Left, ContactSide::Right));
    let swept = Collision::first(&scenario, &ego, Some(ego.pose), 1, None).unwrap();
    assert_eq!(sides(swept), (ContactSide::Rear, ContactSide::Front));
}

#[test]
fn who_goes_through_the_ego_between_two_steps_collides() {
    let closed = behind_a_car(25.0, Forecast::Lane);
    let ego = &closed.baseline().drive().states;
    let recorded = *closed
        .scenario()
        .obstacle(CAR)
        .unwrap()
        .track()
        .at(20)
        .unwrap();
    // From one side of the road to the other at 6 m a step, as no car could: at the steps it is beside the ego.
    let (step, own) = ego[20];
    let aside = |metres: f64| Motion {
        pose: Pose {
            position: own.rear.position + own.rear.left() * metres,
            ..recorded.pose
        },
        ..recorded
    };
    let motions = vec![
        (step - 2, recorded),
        (step - 1, aside(9.0)),
        (step, aside(3.0)),
        (step + 1, aside(-3.0)),
        (step + 2, aside(-9.0)),
    ];
    let change = Change {
        obstacle: CAR,
        motions,
    };
    let effect = closed.effect(&change.into()).unwrap();
    let contact = effect.contact.unwrap();
    assert_eq!((contact.with, contact.step), (CAR, step + 1));
    assert!(contact.between && contact.ego == ContactSide::Left);
    assert_eq!(effect.touched_after_step(), Some(step));
    assert_eq!(effect.consequence, Consequence::Collision(contact));
    assert_eq!(
        (effect.distance(), effect.lowest_after()),
        (Some(0.0), Some(0))
    );
}

#[test]
fn a_wall_in_front_is_a_collision_with_the_attacker() {
    let closed = behind_a_car(9.0, Forecast::Lane);
    let before = lowest_before(&closed).unwrap();
    // As if it drove into something: what is asked here is not whether a car could.
    let effect = closed.effect(&braking(&closed, 1, 500.0).into()).unwrap();
    let collision = effect.contact.unwrap();
    assert_eq!(effect.drive.outcome, Outcome::Collision(collision));
    assert!(effect.hits_attacker() && !effect.is_hit_from_behind());
    assert_eq!(
        (collision.ego, collision.other),
        (ContactSide::Front, ContactSide::Rear)
    );
    assert_eq!(effect.distance(), Some(0.0));
    assert_eq!(effect.lowest_after(), Some(0));
    assert_eq!(effect.main().after.last(), Some(&(collision.step, 0)));
    assert!(before > 0 && effect.lowest_before() == Some(before));
    assert_eq!(effect.consequence.name(), "collision");
}

/// From step 5 on the car comes up from behind the ego, for so many steps: its middle is 15 m behind that of the ego's
/// baseline at first and 1 m less at each step.
fn from_behind(closed: &ClosedLoop, steps: usize) -> Change {
    let drive = closed.baseline().drive();
    let states = drive.states.iter().filter(|(step, _)| *step >= 5);
    let motions = states.take(steps).enumerate().map(|(k, (step, state))| {
        let own = state.centre(&drive.limits);
        let behind = (15.0 - k as f64).max(0.0);
        let motion = Motion {
            pose: Pose {
                position: own.pose.position - own.pose.forward() * behind,
                ..own.pose
            },
            velocity: own.velocity + 10.0,
            acceleration: 0.0,
        };
        (*step, motion)
    });
    Change {
        obstacle: CAR,
        motions: motions.collect(),
    }
}

#[test]
fn being_hit_from_behind_or_nearly_so_is_no_effect() {
    let closed = behind_a_car(25.0, Forecast::Lane);
    let hit = closed.effect(&from_behind(&closed, 60).into()).unwrap();
    assert!(hit.is_hit_from_behind() && hit.hits_attacker());
    assert_eq!(hit.contact.map(|c| c.with), Some(CAR));
    assert_eq!(hit.consequence, Consequence::NoEffect, "{:?}", hit.contact);
    // The last one that does not touch.
    let nearer = (9..14).map(|steps| closed.effect(&from_behind(&closed, steps).into()).unwrap());
    let near = nearer
        .take_while(|effect| effect.contact.is_none())
        .last()
        .unwrap();
    assert_eq!(near.contact, None);
    assert_eq!(near.consequence, Consequence::NoEffect);
    // Whatever its score: from in front it would be a near miss.
    let baseline = closed.baseline().drive();
    let scored_after = |effect: &Effect, before: u8| {
        let mut attackers = effect.attackers.clone();
        let recorded = attackers.iter_mut().flat_map(|a| a.before.iter_mut());
        recorded.for_each(|(_, score)| *score = before);
        let scores = attackers.iter_mut().flat_map(|a| a.after.iter_mut());
        let later = scores.filter(|(step, _)| *step > 5);
        later.for_each(|(_, score)| *score = 1);
        let without = (&**closed.scenario(), baseline);
        comes_near(&attackers, without, (&effect.scenario, &effect.drive))
    };
    let scored_1 = |effect: &Effect| scored_after(effect, 5);
    let ahead = closed.effect(&braking(&closed, 5, 1.0).into()).unwrap();
    assert!(!scored_1(&near) && scored_1(&ahead));
    // What is as near without the attack is no effect of it.
    assert!(scored_after(&ahead, 2) && !scored_after(&ahead, 1));
}

#[test]
fn the_ego_that_drives_into_another_one_is_an_effect() {
    let closed = behind_a_car(25.0, Forecast::Lane);
    let effect = closed.effect(&braking(&closed, 1, 500.0).into()).unwrap();
    let contact = effect.contact.unwrap();
    let with = |with: i64, ego: ContactSide| Collision {
        with,
        ego,
        ..contact
    };
    let tells =
        |contact: Collision| crate::generation::effect::is_telling(&contact, &effect.attackers);
    assert!(tells(contact) && tells(with(CAR, ContactSide::Left)));
    assert!(tells(with(CAR + 1, ContactSide::Front)));
    assert!(!tells(with(CAR + 1, ContactSide::Left)));
    let rear = Collision {
        ego: ContactSide::Rear,
        other: ContactSide::Front,
        ..contact
    };
    assert!(!tells(rear), "its rear, by the attacker's front");
}

#[test]
fn a_collision_that_was_there_before_is_no_effect() {
    // The ego begins within the car.
    let closed = behind_a_car(3.0, Forecast::Lane);
    let outcome = closed.baseline().drive().outcome;
    assert!(matches!(outcome, Outcome::Collision(_)), "{outcome}");
    let effect = closed.effect(&braking(&closed, 5, 7.0).into()).unwrap();
    assert_eq!(effect.drive.outcome, outcome);
    assert_eq!(effect.consequence, Consequence::NoEffect);
}

#[test]
fn who_is_not_there_has_no_effect() {
    let closed = behind_a_car(25.0, Forecast::Lane);
    let mut change = braking(&closed, 5, 7.0);
    change.obstacle = 999;
    let refused = closed.effect(&change.into()).unwrap_err();
    assert_eq!(refused, ChangeError::NoSuchObstacle(999));
}

#[test]
fn a_drive_begins_anywhere_and_a_goal_may_have_to_wait() {
    let all = bundled();
    let entry = all.iter().find(|e| e.name.contains("RightTurn")).unwrap();
    let mut scenario = Scenario::clone(&entry.read().unwrap());
    scenario.obstacles.clear();
    let problem = &scenario.planning_problems[0];
    let driver = Driver::new(&scenario, problem, &settings(Forecast::Lane)).unwrap();
    let whole = driver.full_span();
    let usual = driver.drive(&scenario, &whole);
    let end = usual.states.last().unwrap().0;
    assert!(matches!(usual.outcome, Outcome::Goal(_)) && end + 4 < whole.last);

    let waiting = DriveSpan {
        goal_from: end + 4,
        ..whole
    };
    let longer = driver.drive(&scenario, &waiting);
    assert_eq!(longer.outcome, usual.outcome);
    assert_eq!(longer.states.len(), usual.states.len() + 4);
    assert_eq!(longer.states[..usual.states.len()], usual.states);

    let (step, state) = usual.states[20];
    let later = DriveSpan {
        step,
        state,
        ..whole
    };
    let later = driver.drive(&scenario, &later);
    assert_eq!(later.states[0], (step, state));
    assert_eq!(later.cycles[0].step, step);
    assert_eq!(later.outcome, usual.outcome);
}

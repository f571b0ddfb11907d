//! Tests of the ego against several changes at once.

use std::sync::Arc;

use super::{CAR, ClosedLoop, behind_a_car, braking, car, settings, state};
use crate::generation::{Avoidability, Change, ChangeError, Consequence, JointChange, Variant};
use crate::planner::{Cancel, Forecast};
use nearmiss_scene::scenario::{Motion, Obstacle, Scenario, State};
use nearmiss_scene::verdict::{Manoeuvre, ManoeuvreKind, Motion as Asked};

/// The car that drives on the left of [`CAR`], far from the road.
const OTHER: i64 = 701;

/// The other one drives so far aside, metres.
const ASIDE: f64 = 30.0;

fn with_another_car() -> ClosedLoop {
    let closed = behind_a_car(9.0, Forecast::Lane);
    let mut scenario = Scenario::clone(closed.scenario());
    let states: Vec<State> = { scenario.obstacles[0].track().iter() }
        .map(|(step, motion)| state(step, &aside(motion, ASIDE)))
        .collect();
    let mut other: Obstacle = car(&states, scenario.dt());
    other.id = OTHER;
    scenario.obstacles.push(other);
    let problem = scenario.planning_problems[0].clone();
    let settings = settings(Forecast::Lane);
    let (scenario, cancel) = (Arc::new(scenario), Cancel::default());
    ClosedLoop::watched(scenario, &problem, &settings, &cancel, &mut |_, _| true).unwrap()
}

fn aside(motion: &Motion, metres: f64) -> Motion {
    let mut moved = *motion;
    moved.pose.position += moved.pose.left() * metres;
    moved
}

/// The other car is from step `from` on so far (m) to the left of where [`CAR`] is in its change.
fn follows(closed: &ClosedLoop, change: &Change, from: i64, metres: f64) -> Change {
    let now = *closed
        .scenario()
        .obstacle(OTHER)
        .unwrap()
        .track()
        .at(from)
        .unwrap();
    let later = change
        .motions
        .iter()
        .filter(|(step, _)| *step > from)
        .map(|(step, motion)| (*step, aside(motion, metres)));
    Change {
        obstacle: OTHER,
        motions: std::iter::once((from, now)).chain(later).collect(),
    }
}

#[test]
fn a_drive_against_more_motions_continues_from_one_against_fewer() {
    let closed = with_another_car();
    let brakes = braking(&closed, 12, 3.0);
    let one = JointChange::from(brakes.clone());
    let staged = closed.staged(&one).unwrap();
    let both = one.with(follows(&closed, &brakes, 20, ASIDE)).unwrap();
    let anew = closed.effect(&both).unwrap();
    let continued = closed.effect_until(&both, &staged, i64::MAX).unwrap();
    assert_eq!(anew.drive.states, continued.drive.states);
    assert_eq!(anew.drive.outcome, continued.drive.outcome);
    assert_eq!(anew.consequence, continued.consequence);
    // The first drive knows of a change from step 12 on, the second one from step 20 on.
    assert_eq!((anew.taken_over, continued.taken_over), (13, 21));
    // What does not change is continued to its end.
    let same = closed.effect_until(&one, &staged, i64::MAX).unwrap();
    assert_eq!(same.drive.states, closed.effect(&one).unwrap().drive.states);
    assert_eq!(same.taken_over, same.drive.cycles.len());
    // And a change that is taken back is one, too.
    let other = JointChange::from(both.changes()[1].clone());
    let back = closed.effect_until(&other, &staged, i64::MAX).unwrap();
    let straight = closed.effect(&other).unwrap();
    assert_eq!(back.drive.states, straight.drive.states);
}

#[test]
fn of_several_the_one_that_is_touched_counts_and_each_has_to_be_needed() {
    let closed = with_another_car();
    let wall = braking(&closed, 3, 500.0);
    let far = follows(&closed, &wall, 1, ASIDE);
    let both = JointChange::new(vec![far.clone(), wall.clone()]).unwrap();
    let mut effect = closed.effect(&both).unwrap();
    assert_eq!(effect.ids().collect::<Vec<_>>(), [OTHER, CAR]);
    assert_eq!((effect.from, effect.main().from), (1, 3));
    assert_eq!(effect.main().obstacle, CAR);
    assert!(effect.hits_attacker() && effect.is_attacker(OTHER));
    assert_eq!(effect.distance(), Some(0.0));
    assert!(effect.on_attacker(OTHER).unwrap().distance.unwrap() > 20.0);
    assert_eq!(effect.lowest_after(), Some(0));
    // The car alone is a wall, too.
    assert_eq!(effect.needs_all(), None);
    closed.leave_each_out(&mut effect, &both).unwrap();
    assert_eq!(effect.needs_all(), Some(false));
    let without = |id: i64| effect.on_attacker(id).unwrap().without.unwrap();
    assert!(matches!(without(OTHER), Consequence::Collision(c) if c.with == CAR));
    assert_eq!(without(CAR), Consequence::NoEffect);
    assert!(without(OTHER).is_worse_than(&without(CAR)));
    // One alone has no others.
    let alone = JointChange::from(wall.clone());
    let mut one = closed.effect(&alone).unwrap();
    closed.leave_each_out(&mut one, &alone).unwrap();
    assert_eq!((one.main().without, one.needs_all()), (None, None));
    assert_eq!(
        JointChange::new(vec![wall.clone(), wall]),
        Err(ChangeError::Twice(CAR))
    );
}

#[test]
fn the_reaction_time_counts_from_the_first_who_moves_otherwise() {
    let closed = with_another_car();
    let brakes = braking(&closed, 10, 4.0);
    let far = follows(&closed, &brakes, 4, ASIDE);
    let both = JointChange::new(vec![brakes, far]).unwrap();
    let effect = closed.effect(&both).unwrap();
    let found = Avoidability::search(&closed, &effect);
    for (delay, certificate) in &found.certificates {
        let Some(way) = certificate.avoidance() else {
            continue;
        };
        assert!(way.reaction >= 4 + (delay / 0.1).round() as i64);
    }
    assert!(found.at(0.0).is_some());
}

#[test]
fn all_attackers_are_in_the_files() {
    let closed = with_another_car();
    let brakes = braking(&closed, 10, 4.0);
    let far = follows(&closed, &brakes, 4, ASIDE);
    let both = JointChange::new(vec![brakes, far]).unwrap();
    let mut effect = closed.effect(&both).unwrap();
    closed.leave_each_out(&mut effect, &both).unwrap();
    let asked = |kind| {
        Asked::Manoeuvre(Manoeuvre {
            kind,
            start: 0.5,
            duration: 1.0,
            gap: None,
            speed: None,
        })
    };
    let variant = Variant {
        file: "a/ZAM_HardBraking-1_1_T-1.xml",
        closed: &closed,
        change: &both,
        asked: &[asked(ManoeuvreKind::HardBrake), asked(ManoeuvreKind::Drift)],
        effect: &effect,
        avoidability: &Avoidability::search(&closed, &effect),
        author: None,
        made: None,
        refusals: &[],
        by: "a test",
    };
    let folder = tempfile::tempdir().unwrap();
    let saved = variant.save(folder.path(), "A-1_1_T-1", false).unwrap();
    let text = std::fs::read_to_string(&saved.document).unwrap();
    let document: serde_json::Value = serde_json::from_str(&text).unwrap();
    let all = document["attackers"].as_array().unwrap();
    let ids: Vec<i64> = all.iter().map(|a| a["id"].as_i64().unwrap()).collect();
    assert_eq!(ids, [CAR, OTHER]);
    assert_eq!(document["attacker"], effect.main().obstacle);
    assert_eq!(document["change"]["from_step"], 4);
    assert_eq!(
        (&all[0]["from_step"], &all[1]["from_step"]),
        (&10.into(), &4.into())
    );
    assert_eq!(all[1]["manoeuvre"], "drift");
    assert!(all.iter().all(|a| a["outcome_without"].is_string()));
    let source = &variant.scenario("A-1_1_T-1").header.attributes["source"];
    let said = "with another motion of obstacle 700 after step 10 and another motion of obstacle 701 after step 4, by";
    assert!(source.contains(said), "{source}");
    let read = nearmiss_formats::commonroad::read_file(&saved.scenario).unwrap();
    for change in both.changes() {
        let track = read.obstacle(change.obstacle).unwrap().track();
        let mut motions = change.motions.iter();
        assert!(motions.all(|(step, motion)| track.at(*step) == Some(motion)));
    }
}

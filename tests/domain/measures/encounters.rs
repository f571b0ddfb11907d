//! Drivers in encounters on made-up roads: what is looked at, which contact counts, and what models are not made for.

use std::f64::consts::FRAC_PI_2;

use nearmiss::metrics::{Context, Grade, critical_moments};
use nearmiss::scenario::*;
use nearmiss_drive::driver::{DriverOutcome, NotMadeFor, PreventabilityRecord};

use super::definitions::{car, moving, moving_every, scene};
use super::transform::Move;

/// What drivers make of the contact with an obstacle.
fn contact(scene: &Scene, obstacle: i64) -> Option<PreventabilityRecord> {
    let moments = critical_moments(&Context::new(scene));
    let moment = moments
        .iter()
        .find(|moment| moment.obstacle == obstacle)
        .unwrap();
    assert_eq!(moment.grade, Grade::Contact, "{obstacle}");
    PreventabilityRecord::of(scene, obstacle, moment.step, false)
}

/// Outcomes, and closing speeds in mm/s.
fn results(found: &PreventabilityRecord) -> Vec<(DriverOutcome, Option<i64>)> {
    let speed = |speed: f64| (speed * 1e3).round() as i64;
    let verdicts = found.drivers.iter();
    verdicts
        .map(|one| (one.result, one.closing_speed.map(speed)))
        .collect()
}

#[test]
fn how_the_map_lies_decides_nothing() {
    // From the side and far away: 5 s before it is 75 m beside the path.
    for side in [-1.0, 1.0] {
        let crossing = car(2, (75.0, side * 75.0), -side * FRAC_PI_2, 15.0, 0.0);
        let along_x = scene(vec![car(1, (0.0, 0.0), 0.0, 15.0, 0.0), crossing]);
        let expected = results(&contact(&along_x, 2).unwrap());
        assert_eq!(expected[0].0, DriverOutcome::NotMadeFor);
        for angle in [0.5, 0.8, 1.0, FRAC_PI_2, 2.5] {
            let turned = Move {
                angle,
                ..Move::NONE
            }
            .scene(&along_x);
            assert_eq!(
                results(&contact(&turned, 2).unwrap()),
                expected,
                "{side} {angle}"
            );
        }
    }
}

#[test]
fn each_encounter_has_its_own_contact() {
    let ego = car(1, (0.0, 0.0), 0.0, 20.0, 0.0);
    let (near, far) = (
        car(2, (60.0, 0.0), 0.0, 0.0, 0.0),
        car(3, (90.0, 0.0), 0.0, 5.0, 0.0),
    );
    // The ego drives through the first one.
    let both = scene(vec![ego.clone(), near, far.clone()]);
    assert_eq!(contact(&both, 2).unwrap().closing_speed, Some(20.0));
    assert!(
        contact(&both, 3).is_none(),
        "what follows a contact is not judged"
    );
    // Alone it is judged.
    let alone = scene(vec![ego.clone(), far]);
    assert_eq!(contact(&alone, 3).unwrap().closing_speed, Some(15.0));
    // Two that are touched in the same step each have their contact.
    let two = [2, 3].map(|id| car(id, (60.0, if id == 2 { 1.2 } else { -1.2 }), 0.0, 0.0, 0.0));
    let [left, right] = two;
    let twins = scene(vec![ego, left, right]);
    for id in [2, 3] {
        assert_eq!(
            contact(&twins, id).unwrap().closing_speed,
            Some(20.0),
            "{id}"
        );
    }
}

#[test]
fn who_stands_can_drive_away() {
    // It comes from the left with 10 m/s, 4 s away: 3.5 m/s² for 3 s are 15 m.
    let stands = car(1, (0.0, 0.0), 0.0, 0.0, 0.0);
    let crossing = car(2, (0.0, 42.0), -FRAC_PI_2, 10.0, 0.0);
    let found = contact(&scene(vec![stands, crossing]), 2).unwrap();
    assert!(found.by("ideal").unwrap().avoids(), "{found:?}");
}

/// A car that drives up and turns by 80° to the right within 2 s, to be at (60, 0) at 4 s, and goes on.
fn turning_in() -> Obstacle {
    const SPEED: f64 = 5.0;
    let heading = |t: f64| FRAC_PI_2 - 1.4 * ((t - 2.0) / 2.0).clamp(0.0, 1.0);
    let mut way = vec![(0.0, 0.0)];
    for step in 0..100 {
        let (x, y) = way[step];
        let angle = heading(step as f64 * 0.1);
        way.push((x + 0.1 * SPEED * angle.cos(), y + 0.1 * SPEED * angle.sin()));
    }
    let at = way[40];
    moving(2, |t| {
        let (x, y) = way[(t * 10.0).round() as usize];
        [60.0 + x - at.0, y - at.1, heading(t), SPEED, 0.0]
    })
}

#[test]
fn models_of_motorways_are_not_made_for_who_turns_in() {
    let found = contact(
        &scene(vec![car(1, (0.0, 0.0), 0.0, 14.0, 0.0), turning_in()]),
        2,
    );
    let found = found.unwrap();
    for id in ["cc", "r157", "rss", "fsm"] {
        let verdict = found.by(id).unwrap();
        assert_eq!(
            verdict.not_made_for,
            Some(NotMadeFor::Crossing),
            "{verdict:?}"
        );
        assert_eq!(
            verdict.why_undecided().unwrap(),
            format!("{id} is not made for crossing traffic")
        );
    }
}

#[test]
fn millimetres_at_a_standstill_turn_no_path() {
    // From 15 m/s with 8 m/s² from 2 s on: it stops at 44.06 m, half a metre before a car that appears at 2.9 s. A driver who
    // brakes later passes the end of the ego's path.
    let found = |noise: f64| {
        let ego = moving(1, |t| {
            let braking = (t - 2.0_f64).clamp(0.0, 1.875);
            let x = 15.0 * t.min(2.0) + 15.0 * braking - 4.0 * braking * braking;
            let aside = if t > 3.9 {
                noise * (7.3 * t).sin()
            } else {
                0.0
            };
            let a = if (2.0..3.875).contains(&t) { -8.0 } else { 0.0 };
            [x, aside, 0.0, 15.0 - 8.0 * braking, a]
        });
        let other = moving_every(0.1, 29, 2, |_| [48.56, 0.0, 0.0, 0.0, 0.0]);
        let scene = scene(vec![ego, other]);
        let moments = critical_moments(&Context::new(&scene));
        PreventabilityRecord::of(&scene, 2, moments[0].step, false).unwrap()
    };
    let (clean, noisy) = (found(0.0), found(0.002));
    assert!(
        clean.avoided < clean.decided,
        "who drives on hits it: {clean:?}"
    );
    assert_eq!(results(&clean), results(&noisy));
}

#[test]
fn an_evasion_in_the_last_seconds_is_no_curve() {
    // Turning by 30° within the last 0.8 s: it hits the standing car at an angle.
    let turned = |t: f64| 0.65 * (t - 4.0).clamp(0.0, 0.8);
    let mut way = vec![(0.0, 0.0)];
    for step in 0..100 {
        let (x, y) = way[step];
        let angle = turned(step as f64 * 0.1);
        way.push((x + 3.0 * angle.cos(), y + 3.0 * angle.sin()));
    }
    let (x, y) = way[49];
    let ego = moving(1, |t| {
        let (x, y) = way[(t * 10.0).round() as usize];
        [x, y, turned(t), 30.0, 0.0]
    });
    let found = contact(&scene(vec![ego, car(2, (x, y), 0.0, 0.0, 0.0)]), 2);
    let cc = found.unwrap();
    assert_eq!(cc.by("cc").unwrap().not_made_for, None, "{cc:?}");
}

#[test]
fn who_drives_backwards_is_hit_by_no_one() {
    let ego = moving(1, |t| [-3.0 * t, 0.0, 0.0, -3.0, 0.0]);
    let found = contact(&scene(vec![ego, car(2, (-15.0, 0.0), 0.0, 0.0, 0.0)]), 2).unwrap();
    for id in ["cc", "r157", "rss", "fsm", "nieon"] {
        let verdict = found.by(id).unwrap();
        assert_eq!(verdict.not_made_for, Some(NotMadeFor::Reversing), "{id}");
    }
    assert!(found.by("ideal").unwrap().avoids(), "{found:?}");
}

#[test]
fn a_contact_on_the_way_back_stays_one() {
    // 20 m, a half circle of 6 m radius, and back into a parked car.
    let half = 6.0 * std::f64::consts::PI;
    let ego = moving(1, |t| {
        let s = 7.0 * t;
        let angle = ((s - 20.0) / 6.0).clamp(0.0, std::f64::consts::PI);
        let back = (s - 20.0 - half).max(0.0);
        let x = s.min(20.0) + 6.0 * angle.sin() - back;
        [x, 6.0 - 6.0 * angle.cos(), angle, 7.0, 0.0]
    });
    let found = contact(&scene(vec![ego, car(2, (5.0, 12.0), 0.0, 0.0, 0.0)]), 2).unwrap();
    assert_eq!(found.closing_speed, Some(7.0));
    // Forth and back over the same way into who stands behind its begin: not judged.
    let ego = moving(1, |t| {
        let speed = if t > 2.0 { -7.0 } else { 7.0 };
        [14.0 - 7.0 * (t - 2.0).abs(), 0.0, 0.0, speed, 0.0]
    });
    assert!(contact(&scene(vec![ego, car(2, (-9.0, 0.0), 0.0, 0.0, 0.0)]), 2).is_none());
}

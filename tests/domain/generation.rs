//! Variants of the published scenarios: all pass the gate, most have an effect, and an ideal driver survives it.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use crate::support;

use std::sync::Arc;

use nearmiss::evaluation::default_planning;
use nearmiss::formats::{Entry, commonroad, find};
use nearmiss::generation::{
    AllowedAttacks, Change, ClosedLoop, Consequence, Effort, Gate, Selection, VariantGenerator,
};
use nearmiss::planner::Cancel;
use nearmiss::scenario::Scenario;

/// Every so many scenarios are taken, with fewer motions: the search is slow without optimisation.
const EVERY: usize = if cfg!(debug_assertions) { 15 } else { 1 };
const CANDIDATES: usize = if cfg!(debug_assertions) { 60 } else { 600 };

fn made(scenario: &Arc<Scenario>, effort: &Effort, among: &[i64]) -> (VariantGenerator, Selection) {
    let problem = &scenario.planning_problems[0];
    let settings = default_planning();
    let cancel = Cancel::default();
    let driven = ClosedLoop::watched(
        Arc::clone(scenario),
        problem,
        &settings,
        &cancel,
        &mut |_, _| true,
    );
    let workshop = VariantGenerator::from_closed_loop(driven.unwrap()).unwrap();
    let allowed = AllowedAttacks { among, wish: None };
    let made = workshop.search(effort, allowed, &mut |_| true).unwrap();
    (workshop, made)
}

#[test]
fn variants_of_safe_scenarios_pass_the_gate_and_most_have_an_effect() {
    let Some(folder) =
        support::recorded::shared("from-words-to-collisions/Scenarios/normal_scenarios")
    else {
        return;
    };
    let found = find(&[folder]).unwrap();
    assert_eq!(found.entries.len(), 30);
    let some: Vec<&Entry> = found.entries.iter().step_by(EVERY).collect();
    let effort = Effort {
        candidates: CANDIDATES,
        ..Effort::default()
    };
    let (mut effective, mut fall) = (0, 0.0);
    let mut people = 0;
    for entry in &some {
        let scenario = entry.read().unwrap();
        let (workshop, made) = made(&scenario, &effort, &[]);
        for attack in &made.found.attacks {
            let passed = workshop.gate().check_joint(&attack.change, None);
            assert!(passed.is_ok(), "{}: {passed:?}", entry.display());
            for change in attack.change.changes() {
                is_driven_by_people(change, scenario.dt());
                people += 1;
            }
        }
        let Some(chosen) = &made.chosen else { continue };
        let effect = chosen.attack.effect.as_ref().unwrap();
        let survived = chosen.avoidability.at(0.5) == Some(true);
        effective += usize::from(effect.consequence != Consequence::NoEffect && survived);
        let score = |s: Option<u8>| f64::from(s.unwrap_or(5));
        fall += score(effect.lowest_before()) - score(effect.lowest_after());
    }
    assert!(people > 0);
    let all = some.len();
    let mean = fall / all as f64;
    println!("{effective} of {all} with an effect that is survived, mean fall {mean}");
    if EVERY == 1 {
        assert!(effective * 10 >= all * 6, "{effective} of {all}");
        assert!(mean >= 1.5, "{mean}");
    } else {
        // Two scenarios and a tenth of the motions say nothing about shares.
        assert!(mean > 0.0, "{effective} of {all}, {mean}");
    }
}

#[test]
fn a_second_attacker_is_added_only_where_it_is_needed() {
    let Some(folder) =
        support::recorded::shared("from-words-to-collisions/Scenarios/normal_scenarios")
    else {
        return;
    };
    let found = find(&[folder]).unwrap();
    let one = Effort {
        candidates: CANDIDATES,
        ..Effort::default()
    };
    let two = Effort { together: 2, ..one };
    let mut several = 0;
    for entry in found.entries.iter().step_by(EVERY) {
        let scenario = entry.read().unwrap();
        let (_, alone) = made(&scenario, &one, &[]);
        let (workshop, made) = made(&scenario, &two, &[]);
        let (Some(alone), Some(chosen)) = (alone.chosen, made.chosen) else {
            continue;
        };
        let change = &chosen.attack.change;
        let passed = workshop.gate().check_joint(change, None);
        assert!(passed.is_ok(), "{}: {passed:?}", entry.display());
        let effect = chosen.attack.effect.as_ref().unwrap();
        if change.changes().len() == 1 {
            assert_eq!(change, &alone.attack.change, "{}", entry.display());
            continue;
        }
        several += 1;
        assert_eq!(effect.needs_all(), Some(true));
        for change in change.changes() {
            is_driven_by_people(change, scenario.dt());
        }
        let survived = |delay| chosen.avoidability.at(delay) == Some(true);
        let before = alone.attack.effect.as_ref().unwrap();
        assert!(effect.consequence.is_worse_than(&before.consequence) || survived(0.5));
    }
    println!("{several} scenarios with two attackers");
}

/// No more than people do, from the states alone: up to 4 m/s² faster, 8 slower, 5 across, and no curve tighter than 4 m.
fn is_driven_by_people(change: &Change, dt: f64) {
    for pair in change.motions.windows(2) {
        let ((step, from), (_, to)) = (&pair[0], &pair[1]);
        let acceleration = (to.velocity - from.velocity) / dt;
        let turned = to.pose.heading - from.pose.heading;
        let turned = turned.sin().atan2(turned.cos()).abs();
        let across = f64::midpoint(from.velocity, to.velocity) * turned / dt;
        let moved = (to.pose.position - from.pose.position).norm();
        assert!(
            (-8.0..4.0).contains(&acceleration),
            "step {step}: {acceleration}"
        );
        assert!(across < 5.0, "step {step}: {across}");
        assert!(moved < 0.1 || turned / moved < 0.25, "step {step}");
    }
}

#[test]
fn the_published_attacker_attacks_possibly() {
    let Some(folder) =
        support::recorded::shared("from-words-to-collisions/Generation/BEL_Antwerp-1_14_T-1")
    else {
        return;
    };
    let file = folder.join("BEL_Antwerp-1_14_T-1.xml");
    let scenario = Arc::new(commonroad::read_file(&file).unwrap());
    let (_, made) = made(&scenario, &Effort::default(), &[30762]);
    let chosen = made.chosen.unwrap();
    let effect = chosen.attack.effect.as_ref().unwrap();
    assert!(effect.hits_attacker() && !effect.is_hit_from_behind());
    assert_eq!(chosen.avoidability.at(0.5), Some(true));
    let passed = Gate::new(&scenario).check_joint(&chosen.attack.change, None);
    assert!(passed.is_ok(), "{passed:?}");
}

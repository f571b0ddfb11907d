//! Values that commonroad-crime's own tests expect, on its own scenarios.

use crate::support::recorded::shared;
use std::sync::Arc;

use nearmiss::formats::Entry;
use nearmiss::metrics::{Context, NoValue, Reading, SCENE_MEASURES, measure};
use nearmiss::scenario::{Scenario, Scene};

/// A scenario of commonroad-crime with one of its obstacles as the ego; nothing, said aloud, where it is not there.
fn scene(file: &str, ego: i64, change: impl Fn(&mut Scenario)) -> Option<Scene> {
    let path = shared("commonroad-crime")?.join(file);
    let mut scenario = (*Entry::of_file(&path).read().unwrap()).clone();
    change(&mut scenario);
    Some(Scene::with_obstacle_as_ego(Arc::new(scenario), ego).unwrap())
}

fn at_first(scene: &Scene, id: &str, obstacle: i64) -> Reading {
    let context = Context::new(scene);
    let place = context
        .participants()
        .iter()
        .position(|p| p.obstacle.id == obstacle);
    let encounter = context
        .encounter(place.unwrap(), context.steps().start)
        .unwrap();
    measure(id).unwrap().compute(&encounter)
}

fn of_scene(scene: &Scene, id: &str) -> Reading {
    let context = Context::new(scene);
    let measure = SCENE_MEASURES.iter().find(|m| m.id == id).unwrap();
    (measure.compute)(&context, context.steps().start)
}

#[track_caller]
fn is(found: Reading, expected: f64, within: f64) {
    let value = found
        .value()
        .unwrap_or_else(|| panic!("{found:?} instead of {expected}"));
    assert!(
        (value - expected).abs() <= within,
        "{value} instead of {expected}"
    );
}

#[test]
fn the_parked_vehicles() {
    let Some(scene) = scene("ZAM_Urban-3_3_Repair.xml", 8, |_| {}) else {
        return;
    };
    // It looks at steps of 0.1 s alone: what comes between two is at the later one.
    let at_a_step = |found: Reading, expected: f64| is(found, expected - 0.05, 0.05);
    at_a_step(of_scene(&scene, "ttc_star"), 2.4);
    at_a_step(at_first(&scene, "ttc_star", 6), 2.4);
    at_a_step(at_first(&scene, "thw", 6), 2.4);
    is(at_first(&scene, "dce", 6), 0.0, 0.005);
    is(at_first(&scene, "dce", 7), 0.98, 0.005);
    at_a_step(at_first(&scene, "ttce", 6), 2.4);
    is(of_scene(&scene, "ttb"), 2.0, 1e-9);
    is(of_scene(&scene, "ttr"), 2.0, 1e-9);
    is(at_first(&scene, "tet", 6), 2.0, 1e-9);
    is(at_first(&scene, "tet", 7), 0.9, 1e-9);
    // Expected there is 20.75 m, between the middles of the bumpers. Both bodies are turned by 0.02 rad against the
    // lane, so their corners are nearer by 0.02·(2.5 + 1.608)/2 = 0.041 m, and corners are what would touch.
    let corners = 0.02_f64.sin() * f64::midpoint(2.5, 1.608);
    let middles = 20.75;
    is(at_first(&scene, "headway", 6), middles - corners, 0.005);
}

#[test]
fn without_the_parked_vehicle_nothing_overlaps() {
    let remove = |s: &mut Scenario| s.obstacles.retain(|o| o.id != 6);
    let Some(scene) = scene("ZAM_Urban-3_3_Repair.xml", 8, remove) else {
        return;
    };
    assert_eq!(
        of_scene(&scene, "ttc_star"),
        Reading::None(NoValue::NoRecordedOverlap)
    );
}

#[test]
fn closing_in_on_a_slower_car() {
    let Some(scene) = scene("DEU_Gar-1_1_T-1.xml", 200, |_| {}) else {
        return;
    };
    is(at_first(&scene, "a_long_req", 202), -0.81, 0.005);
}

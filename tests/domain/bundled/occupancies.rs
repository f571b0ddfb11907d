//! Contacts with regions that an obstacle may cover are possible ones.

use std::sync::Arc;

use nearmiss::formats::commonroad::read;
use nearmiss::judge::{judge_collision, judge_under};
use nearmiss::metrics::{Encounter, MEASURES, NoValue, Reading, Thresholds};
use nearmiss::scenario::{Scene, Window};
use nearmiss::verdict::Task;

/// An ego at 10 m/s that comes to a region which obstacle 2 may cover from step 5 to 20, 13 m to 17 m ahead.
fn scene() -> Scene {
    let state = |name: &str, step: i64, x: f64, v: f64| {
        format!(
            "<{name}><position><point><x>{x}</x><y>0</y></point></position><orientation><exact>0</exact></orientation>\
             <time><exact>{step}</exact></time><velocity><exact>{v}</exact></velocity></{name}>"
        )
    };
    let later: String = (1..=20)
        .map(|step| state("state", step, step as f64, 10.0))
        .collect();
    let body = "<shape><rectangle><length>4</length><width>2</width></rectangle></shape>";
    let text = format!(
        "<commonRoad commonRoadVersion='2020a' benchmarkID='ZAM_A-1' timeStepSize='0.1'>\
         <dynamicObstacle id='1'><type>car</type>{body}{}<trajectory>{later}</trajectory></dynamicObstacle>\
         <dynamicObstacle id='2'><type>car</type>{body}{}<occupancySet><occupancy><shape><polygon>\
         <point><x>13</x><y>-1</y></point><point><x>17</x><y>-1</y></point><point><x>17</x><y>1</y></point>\
         <point><x>13</x><y>1</y></point></polygon></shape><time><intervalStart>5</intervalStart>\
         <intervalEnd>20</intervalEnd></time></occupancy></occupancySet></dynamicObstacle></commonRoad>",
        state("initialState", 0, 0.0, 10.0),
        state("initialState", 0, 40.0, 5.0),
    );
    let scenario = read(text.as_bytes(), "a.xml").unwrap();
    Scene::with_obstacle_as_ego(Arc::new(scenario), 1).unwrap()
}

#[test]
fn a_contact_with_a_predicted_occupancy_is_possible() {
    let scene = scene();
    let judgement = judge_collision(&scene, Thresholds::shipped());
    let verdict = &judgement.verdict;
    assert_eq!(judgement.decisive_step, Some(11));
    assert!(verdict.dangerous);
    assert_eq!(verdict.probability, None, "nobody says how likely");
    assert_eq!(verdict.critical.as_ref().unwrap()[0].probability, None);
    assert!(verdict.obstacles[0].reason.starts_with("possible contact"));
    for words in [&verdict.justification, &judgement.reasoning] {
        assert!(words.contains("predicted occupancy"), "{words}");
        assert!(words.contains("possible contact"), "{words}");
        assert!(!words.contains("velocity 0"), "{words}");
    }
}

#[test]
fn a_region_has_a_place_and_no_velocity() {
    let scene = scene();
    let other = scene.participants().next().unwrap();
    let reading = |id: &str, step| {
        let encounter = Encounter::at(&scene, &other, step).unwrap();
        let measure = MEASURES.iter().find(|m| m.id == id).unwrap();
        measure.evaluate(&encounter)
    };
    assert!(
        Encounter::at(&scene, &other, 3).is_none(),
        "a gap stays one"
    );
    assert!(
        reading("ttc", 0).value().is_some(),
        "its first state is known"
    );
    assert_eq!(reading("distance", 8), Reading::Value(3.0));
    assert_eq!(reading("distance", 12), Reading::Value(0.0));
    assert_eq!(reading("risk", 12), Reading::Value(0.0));
    for id in ["ttc", "risk", "v_rel_long", "wttc", "pet", "drac"] {
        assert_eq!(reading(id, 8), Reading::None(NoValue::Occupancy), "{id}");
    }
    let taken = Scene::with_obstacle_as_ego(Arc::clone(&scene.scenario), 2);
    assert!(taken.unwrap_err().to_string().contains("occupancy set"));
    assert_eq!(scene.scenario.possible_egos(), [1]);
}

#[test]
fn what_the_ego_is_about_to_reach_is_a_possible_contact() {
    let scene = scene();
    let window = Window::ending_at(&scene, 8, 8);
    let judgement = judge_under(&scene, Task::Safety, &window, Thresholds::shipped());
    assert!(judgement.verdict.dangerous, "{}", judgement.reasoning);
    assert!(
        judgement.reasoning.contains("possible contact"),
        "{}",
        judgement.reasoning
    );
    assert!(judgement.prospects[0].is_possible);
}

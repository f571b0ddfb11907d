//! Tests that obstacles given as regions are in every forecast, and are reported.

use crate::planner::{Forecast, Forecaster, occupancy_sets};
use nearmiss_formats::bundled;
use nearmiss_scene::scenario::{Obstacle, ObstacleParts, Occupancy, Prediction, Scenario, Steps};

/// A bundled scenario; the motion of its first moving obstacles is replaced by a region.
fn with_regions(count: usize) -> (Scenario, Vec<i64>) {
    let mut scenario = (*bundled()[0].read().unwrap()).clone();
    let dt = scenario.dt();
    let mut replaced = Vec::new();
    for obstacle in &mut scenario.obstacles {
        let moves = matches!(obstacle.prediction, Prediction::Trajectory(_));
        let shape = obstacle.footprint.as_ref().map(|f| f.shape().clone());
        let (true, Some(region)) = (moves && replaced.len() < count, shape) else {
            continue;
        };
        replaced.push(obstacle.id);
        *obstacle = Obstacle::new(
            ObstacleParts {
                id: obstacle.id,
                role: obstacle.role,
                kind: obstacle.kind,
                footprint: obstacle.footprint.clone(),
                initial: obstacle.initial.clone(),
                prediction: Prediction::Occupancies(vec![Occupancy {
                    time: Steps { from: 1, to: 90 },
                    region,
                }]),
                signals: Vec::new(),
            },
            dt,
        );
    }
    assert_eq!(replaced.len(), count);
    (scenario, replaced)
}

#[test]
fn regions_are_in_every_forecast_and_the_sentence_names_whose_they_are() {
    let (scenario, replaced) = with_regions(2);
    let later = (1.5 / scenario.dt()).round() as i64;
    for forecast in Forecast::ALL {
        let traffic = Forecaster::new(&scenario, forecast, None).traffic(later, 10);
        let boxed: Vec<i64> = (0..=10)
            .flat_map(|step| traffic.at(step))
            .map(|there| traffic.bodies[there.body].id)
            .collect();
        let others = boxed.iter().any(|id| !replaced.contains(id));
        assert!(others, "the others are there");
        for id in &replaced {
            let count = boxed.iter().filter(|one| *one == id).count();
            assert_eq!(count, 11, "the region of {id}, once a step");
        }
    }
    let said = occupancy_sets(&scenario).unwrap();
    let who = format!("obstacles {} and {} are given", replaced[0], replaced[1]);
    assert!(said.starts_with(&who), "{said}");
}

#[test]
fn one_and_many_are_told_and_nobody_is_not() {
    let (one, replaced) = with_regions(1);
    let said = occupancy_sets(&one).unwrap();
    assert!(said.starts_with(&format!("obstacle {} is given", replaced[0])));
    let (many, _) = with_regions(6);
    assert!(
        occupancy_sets(&many)
            .unwrap()
            .contains(" and 2 more are given")
    );
    assert_eq!(occupancy_sets(&bundled()[0].read().unwrap()), None);
}

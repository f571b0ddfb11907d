//! Each scenario ends as it is declared, and no other obstacles touch.

use nearmiss::metrics::{Headline, Series, Thresholds, measure};
use nearmiss::scenario::Participant;

use crate::bundled::make::Outcome;
use crate::bundled::{CASES, Case, none};

fn series(case: &Case) -> Series {
    Series::compute(&case.scene, vec![measure("distance").unwrap()])
}

#[test]
fn outcomes_are_as_declared() {
    let mut complaints = Vec::new();
    for case in CASES.iter() {
        let headline = Headline::compute(&case.scene, Thresholds::shipped());
        let (distance, ttc) = (headline.distance.unwrap(), headline.ttc);
        let ttc = ttc.map_or(f64::MAX, |t| t.value);
        let last = case.scene.last_step();
        let holds = match case.made.outcome {
            Outcome::Collision(with) => {
                // The recording ends with the contact, a step or two later.
                headline.collides() && distance.obstacle == with && last - distance.step <= 1
            }
            Outcome::NearMiss => !headline.collides() && (distance.value < 1.0 || ttc < 1.5),
            Outcome::Safe => distance.value > 1.0 && ttc > 1.5,
        };
        if !holds {
            complaints.push(format!(
                "{} is not {:?}: {headline:?}",
                case.made.name, case.made.outcome
            ));
        }
    }
    none(&complaints);
}

#[test]
fn a_collision_is_with_one_only() {
    for case in CASES.iter() {
        let series = series(case);
        let touched = |id: &&i64| {
            series
                .row("distance", **id)
                .iter()
                .any(|r| r.value() == Some(0.0))
        };
        let touched: Vec<i64> = series.obstacles().iter().filter(touched).copied().collect();
        match case.made.outcome {
            Outcome::Collision(with) => assert_eq!(touched, [with], "{}", case.made.name),
            Outcome::NearMiss | Outcome::Safe => assert!(touched.is_empty(), "{}", case.made.name),
        }
    }
}

#[test]
fn the_others_keep_clear_of_each_other() {
    let mut complaints = Vec::new();
    for case in CASES.iter() {
        let all: Vec<Participant<'_>> = case.scene.participants().collect();
        let steps = all
            .iter()
            .map(|p| p.obstacle.track().steps().end)
            .max()
            .unwrap();
        for (i, a) in all.iter().enumerate() {
            for b in &all[i + 1..] {
                let nearest = (0..steps)
                    .filter_map(|step| {
                        Some((a.placed_at(step)?.distance(&b.placed_at(step)?), step))
                    })
                    .min_by(|x, y| x.0.total_cmp(&y.0))
                    .unwrap();
                if nearest.0 < 0.3 {
                    complaints.push(format!(
                        "{}: {} and {} are {:.2} m apart at {}",
                        case.made.name, a.obstacle.id, b.obstacle.id, nearest.0, nearest.1
                    ));
                }
            }
        }
    }
    none(&complaints);
}

#[test]
fn the_cast_is_varied_and_every_outcome_occurs() {
    for case in CASES.iter() {
        let count = case.scene.scenario.obstacles.len();
        assert!(
            (5..=12).contains(&count),
            "{}: {count} obstacles",
            case.made.name
        );
    }
    let count = |f: fn(&Outcome) -> bool| CASES.iter().filter(|c| f(&c.made.outcome)).count();
    assert!(count(|o| matches!(o, Outcome::Collision(_))) >= 2);
    assert!(count(|o| *o == Outcome::NearMiss) >= 2);
    assert!(count(|o| *o == Outcome::Safe) >= 2);
}

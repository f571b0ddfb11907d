//! Sentences made of known facts about random scenes: half of them are made false, and none is called the other.

use std::sync::Arc;

use nearmiss_base::geometry::{Point, Vector};
use nearmiss_scene::scenario::{Sample, Track};

use super::*;

/// A scene of a bundled scenario whose ego drives at random near one of its obstacles.
fn random(rng: &mut fastrand::Rng, all: &[Scene]) -> Option<(Scene, i64, i64)> {
    let scene = &all[rng.usize(..all.len())];
    let who: Vec<_> = scene.participants().collect();
    let who = &who[rng.usize(..who.len())];
    let now = rng.i64(10..scene.last_step().max(11));
    let other = who.at(now)?;
    let dt = scene.scenario.dt();
    let away = Vector::new(80.0 * rng.f64() - 40.0, 80.0 * rng.f64() - 40.0);
    let heading = std::f64::consts::TAU * rng.f64();
    let (speed, acceleration) = (30.0 * rng.f64(), 6.0 * rng.f64() - 3.0);
    let along = Vector::new(heading.cos(), heading.sin());
    let samples = (now - 10..=now).map(|step| {
        let time = (step - now) as f64 * dt;
        let velocity = (speed + acceleration * time).max(0.0);
        let way = speed * time + 0.5 * acceleration * time * time;
        Sample {
            step,
            position: Point::from(other.pose.position.coords + away) + along * way,
            heading: Some(heading),
            velocity: Some(velocity),
            acceleration: Some(acceleration),
        }
    });
    let mut ego = scene.ego.clone();
    ego.recorded.clear();
    ego.track = Track::new(samples.collect(), dt, None);
    let id = who.obstacle.id;
    Some((Scene::new(Arc::clone(&scene.scenario), ego), id, now))
}

/// A number that is plainly another one, if it is to be false.
fn told(rng: &mut fastrand::Rng, truth: f64, is_true: bool) -> f64 {
    if is_true {
        return truth;
    }
    // Far from the distance of the centres, too, which is taken for that of the bodies.
    truth + truth.signum() * (12.0 + 10.0 * rng.f64())
}

/// A fact about an obstacle at a step in words, true or made false; nothing where no fact is plain.
fn fact(
    rng: &mut fastrand::Rng,
    id: i64,
    encounter: &Encounter<'_>,
    is_true: bool,
) -> Option<String> {
    let relation = encounter.relation();
    let distance = encounter.distance();
    let pick = |rng: &mut fastrand::Rng, all: &[&str]| all[rng.usize(..all.len())].to_owned();
    let said = match rng.u8(..9) {
        0 => {
            let d = told(rng, distance, is_true);
            pick(
                rng,
                &[
                    "Obstacle ID is D m away.",
                    "The distance to obstacle ID is D m.",
                    "ID: distance D m",
                    "Car ID keeps a distance of D m.",
                ],
            )
            .replace('D', "\u{1}")
            .replace("I\u{1}", "ID")
            .replace('\u{1}', &format!("{d:.2}"))
        }
        1 if relation.gap_long.abs() > 1.0 => {
            let gap = told(rng, relation.gap_long, is_true);
            pick(
                rng,
                &[
                    "The longitudinal distance of obstacle ID is G m.",
                    "Obstacle ID has a longitudinal gap of G m.",
                ],
            )
            .replace('G', &format!("{gap:.2}"))
        }
        2 if relation.gap_lat.abs() > 1.0 => {
            let gap = told(rng, relation.gap_lat, is_true);
            "The lateral distance of obstacle ID is G m.".replace('G', &format!("{gap:.2}"))
        }
        3 => {
            let speed = told(rng, encounter.other.velocity.abs(), is_true);
            pick(
                rng,
                &[
                    "Obstacle ID drives at S m/s.",
                    "The speed of car ID is S m/s.",
                    "Vehicle ID is doing S m/s.",
                ],
            )
            .replace('S', "\u{1}")
            .replace("\u{1}peed", "Speed")
            .replace('\u{1}', &format!("{speed:.2}"))
        }
        4 if relation.gap_long.abs() > 2.0 => {
            let front = (relation.gap_long > 0.0) == is_true;
            let place = if front { "ahead of" } else { "behind" };
            format!("Obstacle ID is {place} the ego.")
        }
        5 if relation.gap_lat.abs() > 2.0 => {
            let left = (relation.gap_lat > 0.0) == is_true;
            format!(
                "Obstacle ID is to the {} of the ego.",
                if left { "left" } else { "right" }
            )
        }
        6 => {
            let away = encounter.other.pose.position - encounter.ego.pose.position;
            let velocity = encounter.other.velocity_vector() - encounter.ego.velocity_vector();
            let closing = -away.dot(&velocity) / away.norm();
            let along = -relation.gap_long.signum() * relation.velocity.x;
            let across = -relation.gap_lat.signum() * relation.velocity.y;
            // Plain where both axes agree.
            let plain = [closing, along, across].iter().all(|speed| *speed > 0.5)
                || [closing, along, across].iter().all(|speed| *speed < -0.5);
            if !plain || relation.gap_long == 0.0 || relation.gap_lat == 0.0 {
                return None;
            }
            let nears = (closing > 0.0) == is_true;
            let verb = if nears {
                pick(rng, &["approaching the ego", "closing in", "coming closer"])
            } else {
                pick(rng, &["moving away", "receding", "drifting away"])
            };
            format!("Obstacle ID is {verb}.")
        }
        7 => {
            let bound = if is_true {
                1.5 * distance + 1.0
            } else {
                distance / 2.0 - 0.3
            };
            if bound < 0.5 {
                return None;
            }
            format!("The distance to obstacle ID is less than {bound:.1} m.")
        }
        8 if distance > 9.0 => pick(
            rng,
            if is_true {
                &[
                    "Obstacle ID does not touch the ego.",
                    "There is no collision with obstacle ID.",
                ]
            } else {
                &[
                    "Obstacle ID has collided with the ego.",
                    "Obstacle ID is in contact with the ego.",
                ]
            },
        ),
        _ => return None,
    };
    Some(said.replace("ID", &id.to_string()))
}

#[test]
fn no_true_fact_is_called_wrong_and_no_false_one_right() {
    let all: Vec<Scene> = { bundled().into_iter() }
        .map(|entry| {
            let scenario = entry.read().unwrap();
            let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
            Scene::new(scenario, ego)
        })
        .collect();
    let mut rng = fastrand::Rng::with_seed(47);
    let (mut scenes, mut decided, mut missed) = (0, 0, Vec::new());
    while scenes < 10_000 {
        let Some((scene, id, now)) = random(&mut rng, &all) else {
            continue;
        };
        let who = scene.participants().find(|p| p.obstacle.id == id).unwrap();
        let Some(encounter) = Encounter::at(&scene, &who, now) else {
            continue;
        };
        let is_true = rng.bool();
        let Some(text) = fact(&mut rng, id, &encounter, is_true) else {
            continue;
        };
        scenes += 1;
        // Of this step alone: what was so before is another question.
        let subject = Subject::new(&scene, TimeOrigin::Recording, Some((now, now)));
        let found = checked(&text, &subject);
        let told = |is: fn(&Judgement) -> bool| found.iter().any(|c| is(&c.judgement));
        let (right, wrong) = (
            told(|j| *j == Judgement::Right),
            told(|j| *j == Judgement::Wrong),
        );
        let lines: Vec<String> = found.iter().map(CheckedClaim::line).collect();
        assert!(!(is_true && wrong), "{text}: {lines:?}");
        assert!(is_true || !right || wrong, "{text}: {lines:?}");
        if right || wrong {
            decided += 1;
        } else {
            missed.push(text);
        }
    }
    let share = f64::from(decided) / f64::from(scenes);
    assert!(
        share > 0.85,
        "{share}: {:?}",
        &missed[..missed.len().min(20)]
    );
}

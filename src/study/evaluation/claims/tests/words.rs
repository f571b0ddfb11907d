//! Claims in words, and what sentences come to as a whole.

use nearmiss_scene::metrics::RISK_LEVELS;

use super::*;

/// A scene, and an obstacle of it at a step that the predicate holds for, with the window that ends there.
fn where_holds(is: impl Fn(&Encounter<'_>, &Encounter<'_>) -> bool) -> (Scene, i64, (i64, i64)) {
    for entry in bundled() {
        let scenario = entry.read().unwrap();
        let Some(ego) = entry.recorded_ego(&scenario).unwrap() else {
            continue;
        };
        let scene = Scene::new(scenario, ego);
        let found = scene.participants().find_map(|who| {
            (10..scene.last_step()).find_map(|step| {
                let (before, now) = (
                    Encounter::at(&scene, &who, step - 1)?,
                    Encounter::at(&scene, &who, step)?,
                );
                is(&before, &now).then_some((who.obstacle.id, (step, step)))
            })
        });
        if let Some((id, window)) = found {
            return (scene, id, window);
        }
    }
    panic!("no such moment");
}

/// What a sentence comes to, and how its claims were stated.
fn outcome(
    scene: &Scene,
    window: (i64, i64),
    text: &str,
) -> (Option<SentenceOutcome>, Vec<String>) {
    let subject = Subject::new(scene, TimeOrigin::Recording, Some(window));
    let found = sentences(text, &subject);
    let stated = found
        .iter()
        .flat_map(|s| &s.claims)
        .map(CheckedClaim::stated);
    (found.first().map(|s| s.outcome), stated.collect())
}

fn closes(before: &Encounter<'_>, now: &Encounter<'_>) -> bool {
    before.distance() - now.distance() > 0.2 && now.contact().is_none()
}

fn opens(before: &Encounter<'_>, now: &Encounter<'_>) -> bool {
    closes(now, before) && now.contact().is_none()
}

#[test]
fn approach_and_retreat_are_held_against_the_distance() {
    use SentenceOutcome::{NotUnderstood, Right, Wrong};
    let (scene, id, window) = where_holds(closes);
    for (text, wanted, stated) in [
        ("Obstacle ID is approaching the ego.", Right, "approaching"),
        ("Obstacle ID is closing in rapidly.", Right, "approaching"),
        (
            "The distance to obstacle ID is decreasing.",
            Right,
            "approaching",
        ),
        (
            "Obstacle ID is moving away from the ego.",
            Wrong,
            "moving away",
        ),
        ("Obstacle ID is not approaching.", Wrong, "not approaching"),
        // Half of it is not understood: it is never right.
        (
            "Obstacle ID is approaching the ego and it overlaps its shadow.",
            NotUnderstood,
            "approaching",
        ),
    ] {
        let found = outcome(&scene, window, &text.replace("ID", &id.to_string()));
        assert_eq!(found, (Some(wanted), vec![stated.to_owned()]), "{text}");
    }
    for unsaid in [
        "If obstacle ID is approaching, the ego brakes.",
        "Obstacle ID might be closing in.",
        "An approaching vehicle like obstacle ID needs attention.",
        "The closing speed of obstacle ID matters.",
    ] {
        let found = outcome(&scene, window, &unsaid.replace("ID", &id.to_string()));
        assert_eq!(found.1, Vec::<String>::new(), "{unsaid}");
    }
    let (scene, id, window) = where_holds(opens);
    for (text, wanted) in [
        ("Obstacle ID is moving away.", Right),
        ("The gap to obstacle ID is increasing.", Right),
        ("Obstacle ID is approaching the ego.", Wrong),
    ] {
        let found = outcome(&scene, window, &text.replace("ID", &id.to_string()));
        assert_eq!(found.0, Some(wanted), "{text}: {found:?}");
    }
}

#[test]
fn speeds_are_told_in_words() {
    let (scene, id, window) =
        where_holds(|_, now| now.other.acceleration < -1.0 && now.other.velocity > 3.0);
    let of = |text: &str| outcome(&scene, window, &text.replace("ID", &id.to_string())).0;
    assert_eq!(
        of("Obstacle ID is decelerating."),
        Some(SentenceOutcome::Right)
    );
    assert_eq!(
        of("Obstacle ID is accelerating."),
        Some(SentenceOutcome::Wrong)
    );
    let (scene, id, window) = where_holds(|_, now| now.other.velocity > now.ego.velocity + 1.0);
    let of = |text: &str| outcome(&scene, window, &text.replace("ID", &id.to_string())).0;
    assert_eq!(
        of("Obstacle ID is faster than the ego."),
        Some(SentenceOutcome::Right)
    );
    assert_eq!(
        of("Obstacle ID is slower than the ego."),
        Some(SentenceOutcome::Wrong)
    );
}

#[test]
fn lanes_are_those_of_the_map() {
    let lanelets = |scene: &Scene, pose: &nearmiss_base::geometry::Pose| {
        scene.scenario.network.lanelets_at(&pose.position)
    };
    let (scene, id, window) = where_holds(|_, now| now.distance() < 40.0);
    let who = scene.participants().find(|p| p.obstacle.id == id).unwrap();
    let own = lanelets(&scene, &who.at(window.1).unwrap().pose);
    let lanelet = own[0];
    let of = |text: &str| outcome(&scene, window, &text.replace("ID", &id.to_string())).0;
    assert_eq!(
        of(&format!("Obstacle ID is in lanelet {lanelet}.")),
        Some(SentenceOutcome::Right)
    );
    assert_eq!(
        of(&format!("Obstacle ID is in lanelet {}.", lanelet + 90_000)),
        Some(SentenceOutcome::Wrong)
    );
    let ego = lanelets(&scene, &scene.ego.track.at(window.1).unwrap().pose);
    let same = own.iter().any(|id| ego.contains(id));
    let (right, wrong) = if same {
        ("same lanelet", "different lanelet")
    } else {
        ("different lanelet", "same lanelet")
    };
    assert_ne!(
        of(&format!("Obstacle ID is in the {right} as the ego.")),
        Some(SentenceOutcome::Wrong)
    );
    assert_ne!(
        of(&format!("Obstacle ID is in a {wrong}.")),
        Some(SentenceOutcome::Right)
    );
    assert_eq!(
        outcome(
            &scene,
            window,
            &format!("Obstacle {id} changes into the ego's lane.")
        )
        .1,
        ["changing lanes"]
    );
}

#[test]
fn risk_scores_are_those_of_the_window() {
    let (scene, id, window) = where_holds(closes);
    let who = scene.participants().find(|p| p.obstacle.id == id).unwrap();
    let encounter = Encounter::at(&scene, &who, window.1).unwrap();
    for (of, label) in [
        (RiskAspect::Overall, "Overall Risk score"),
        (RiskAspect::Distance(None), "Distance safety score"),
        (RiskAspect::Time(None), "Time safety score"),
        (
            RiskAspect::Distance(Some(true)),
            "Longitudinal Distance Safety Score",
        ),
    ] {
        let score = RISK_LEVELS.aspect(&encounter, of);
        for said in 0..=5 {
            let text = format!("**Obstacle {id}**\n- {label}: {said}");
            let found = outcome(&scene, window, &text);
            let wanted = if said == score {
                SentenceOutcome::Right
            } else {
                SentenceOutcome::Wrong
            };
            assert_eq!(found.0, Some(wanted), "{text}: {found:?}");
        }
    }
    let overall = RISK_LEVELS.aspect(&encounter, RiskAspect::Overall);
    let class = [
        "collision",
        "extreme",
        "high",
        "medium",
        "low",
        "negligible",
    ][usize::from(overall)];
    for text in [
        format!("Obstacle {id}: overall risk: {class} ({overall})"),
        format!("Obstacle {id}: Overall Risk: {class} risk"),
        format!("{{\"ObstacleID\": {id}, \"OverallRiskScore\": \"{overall}\"}}"),
    ] {
        assert_eq!(
            outcome(&scene, window, &text).0,
            Some(SentenceOutcome::Right),
            "{text}"
        );
    }
}

#[test]
fn calculations_and_places_are_checked() {
    let (scene, id, window) = where_holds(closes);
    let who = scene.participants().find(|p| p.obstacle.id == id).unwrap();
    let place = who.at(window.1).unwrap().pose.position;
    let of = |text: String| outcome(&scene, window, &text);
    let right = of(format!(
        "Obstacle {id} is at ({:.2}, {:.2}).",
        place.x, place.y
    ));
    assert_eq!(right.0, Some(SentenceOutcome::Right), "{right:?}");
    let wrong = of(format!(
        "Obstacle {id} is at ({:.2}, {:.2}).",
        place.x + 3.0,
        place.y
    ));
    assert_eq!(wrong.0, Some(SentenceOutcome::Wrong), "{wrong:?}");
    let stated = |text: &str| of(format!("**Obstacle {id}**\n- {text}"));
    let sum = stated("Calculated: 12.80 m / 2.50 m/s = 5.12 s");
    assert!(sum.1.contains(&"12.8 / 2.5 = 5.12".to_owned()), "{sum:?}");
    assert_eq!(
        stated("Calculated: 12.80 m / 2.50 m/s = 7.9 s").0,
        Some(SentenceOutcome::Wrong)
    );
}

#[test]
fn a_distance_is_understood_whole() {
    let (scene, id, window) = where_holds(closes);
    let who = scene.participants().find(|p| p.obstacle.id == id).unwrap();
    let distance = Encounter::at(&scene, &who, window.1).unwrap().distance();
    let text = format!(
        "Obstacle {id} is {distance:.2} m away at step {}.",
        window.1
    );
    assert_eq!(
        outcome(&scene, window, &text).0,
        Some(SentenceOutcome::Right),
        "{text}"
    );
}

#[test]
fn units_with_powers_do_no_harm() {
    let (scene, id, window) = where_holds(closes);
    for text in [
        "**Obstacle ID**\n    * Acceleration: 1.8735 m/s^2",
        "Obstacle ID: from 2 m/s^2 to 3 m/s^2, (4.378 m/s^2, 1.0 m/s^2) / 2 m/s^2 = 3 m/s^2.",
    ] {
        outcome(&scene, window, &text.replace("ID", &id.to_string()));
    }
}

#[test]
fn contact_is_denied_and_told_ahead() {
    let (scene, id, window) = where_holds(|_, now| now.contact().is_some());
    let of = |text: &str| outcome(&scene, window, &text.replace("ID", &id.to_string())).0;
    assert_eq!(
        of("Obstacle ID does not touch the ego."),
        Some(SentenceOutcome::Wrong)
    );
    let before = (window.0 - 5, window.1 - 5);
    let of = |text: &str| outcome(&scene, before, &text.replace("ID", &id.to_string())).0;
    assert_eq!(
        of("Obstacle ID does not touch the ego."),
        Some(SentenceOutcome::Right)
    );
    assert_eq!(
        of("Obstacle ID will collide with the ego."),
        Some(SentenceOutcome::Right)
    );
    assert_eq!(
        of("Obstacle ID is not on a collision course."),
        Some(SentenceOutcome::Wrong)
    );
}

#[test]
fn both_axes_and_changes_are_read_in_their_order() {
    let (a, _) = ids();
    for text in [
        format!("**Obstacle {a}**\n- Longitudinal & lateral distance: 12.57m & -3.36m"),
        format!("**Obstacle {a}**\n- Distance: 12.57m long, -3.36m lat"),
    ] {
        assert_eq!(
            brief(&text),
            [
                format!("{a} gap longitudinal: 12.57m"),
                format!("{a} gap lateral: -3.36m"),
            ],
            "{text}"
        );
    }
    assert_eq!(
        brief(&format!(
            "Obstacle {a}: the longitudinal distance decreased from 9.0 m to 7.5 m."
        )),
        [
            format!("{a} motion: distance decreased"),
            format!("{a} gap longitudinal: 9.0 m to 7.5 m"),
        ]
    );
}

#[test]
fn what_is_of_others_denied_supposed_or_asked_is_claimed_of_no_one() {
    let (scene, id, window) = where_holds(closes);
    for text in [
        "Everything else is moving away.",
        "The scene as a whole has a risk score of 1.",
        "The speed limit is 36 m/s.",
        "The distance to the kerb is 9.16 m.",
        "The longitudinal distance of obstacle ID is not 49.45 m.",
        "The speed of obstacle ID is 9.2 m/s lower.",
        "Suppose obstacle ID is moving away.",
        "I doubt that obstacle ID is moving away.",
        "Is obstacle ID moving away?",
        "Obstacle ID is in front of the ego: false",
        "- is braking: no",
        "Obstacle ID leaves the ego's lane.",
        "Obstacle ID never has a risk score of 4.",
        "Obstacle ID has a risk score of 3 or 4.",
        "The TTC limit of obstacle ID is 2 s.",
        "The distance to obstacle ID increased from 11.35 m to 9.16 m.",
    ] {
        let text = format!(
            "## Obstacle {id}\n\n{}",
            text.replace("ID", &id.to_string())
        );
        let found = outcome(&scene, window, &text);
        assert_eq!(found.1, Vec::<String>::new(), "{text}");
    }
    let comma = outcome(
        &scene,
        window,
        &format!("Obstacle {id} has a speed of 22,8 m/s."),
    );
    assert_eq!(comma.1, ["22.8 m/s"]);
    for denied in [
        "won't be approaching",
        "is not approaching",
        "isn’t approaching",
    ] {
        let found = outcome(&scene, window, &format!("Obstacle {id} {denied}."));
        assert_ne!(found.0, Some(SentenceOutcome::Right), "{denied}: {found:?}");
    }
}

//! The claim language is read back as it was written, a second reader's sentences are no more than that, and what sentences
//! contradict.

use super::*;
use crate::evaluation::claims::{samples, translation_schema, untranslated, written};

/// A stated value without what the words need not tell.
fn bare(stated: ClaimedValue) -> ClaimedValue {
    match stated {
        ClaimedValue::Number {
            value,
            decimals,
            rough,
            ..
        } => ClaimedValue::Number {
            value: value.abs(),
            decimals,
            rough,
            magnitude: false,
        },
        ClaimedValue::Word {
            predicate: Predicate::Touches,
            is_denied: false,
        } => ClaimedValue::Contact,
        ClaimedValue::Side(side) => ClaimedValue::Word {
            predicate: Predicate::At(side),
            is_denied: false,
        },
        stated => stated,
    }
}

#[test]
fn every_kind_of_the_language_is_read_back() {
    let scene = scene();
    let (id, other, window) = cast(&scene);
    let subject = Subject::new(&scene, TimeOrigin::Recording, Some(window));
    let mut lost = Vec::new();
    for named in [None, Some(12)] {
        for claim in samples(id, other, scene.ego.id) {
            // A change has two times.
            let is_of_a_time = !matches!(claim.stated, ClaimedValue::Change { .. });
            let step = named.filter(|_| is_of_a_time);
            let claim = Claim { step, ..claim };
            let text = written(&claim);
            let found = find(&text, &subject);
            let is_there = found.iter().any(|one| {
                one.obstacle == claim.obstacle
                    && one.quantity == claim.quantity
                    && bare(one.stated) == bare(claim.stated)
                    && one.step == step
            });
            if !is_there {
                let said: Vec<_> = { found.iter() }
                    .map(|one| (one.obstacle, one.quantity, one.stated, one.step))
                    .collect();
                lost.push(format!(
                    "{text}: {said:?}, not {:?} {:?}",
                    claim.quantity, claim.stated
                ));
            }
        }
    }
    assert!(lost.is_empty(), "{} lost:\n{}", lost.len(), lost.join("\n"));
}

#[test]
fn a_translation_is_checked_like_the_sentence_and_has_no_numbers_of_its_own() {
    let scene = scene();
    let (id, other, window) = cast(&scene);
    let subject = Subject::new(&scene, TimeOrigin::Recording, Some(window));
    let who = scene.participants().find(|p| p.obstacle.id == id).unwrap();
    let distance = Encounter::at(&scene, &who, window.1).unwrap().distance();
    let true_one = format!("Das Fahrzeug {id} ist {distance:.2} Meter von uns entfernt und fährt.")
        .replace('.', ",")
        .replace("fährt,", "fährt.");
    let text = format!(
        "{true_one}\nDas Fahrzeug {id} ist 99,00 Meter von uns entfernt.\nWir fahren weiter."
    );
    let read = |answer: serde_json::Value| {
        let mut found = sentences(&text, &subject);
        let asked = untranslated(&text, &found, &subject);
        assert_eq!(asked.len(), 1, "{found:?}");
        assert!(
            asked[0].user.contains("⟦1: Das Fahrzeug"),
            "{}",
            asked[0].user
        );
        let read = asked[0].read((&text, &mut found), &answer.to_string(), &subject);
        (
            read,
            found.iter().map(|one| one.outcome).collect::<Vec<_>>(),
        )
    };
    let said = |metres: f64| format!("Obstacle {id} is {metres:.2} m away from the ego.");
    let (count, outcomes) = read(serde_json::json!({"sentences": [
        {"number": 1, "claims": [said(distance)]},
        {"number": 2, "claims": [said(99.0)]},
        {"number": 9, "claims": [said(distance)]},
    ]}));
    assert_eq!(count, Ok(2));
    assert_eq!(
        outcomes[..2],
        [SentenceOutcome::Right, SentenceOutcome::Wrong]
    );
    // The truth instead of what was said, and a part that the language cannot hold.
    let (count, outcomes) = read(serde_json::json!({"sentences": [
        {"number": 1, "claims": [said(distance), "?"]},
        {"number": 2, "claims": [said(distance)]},
    ]}));
    assert_eq!(count, Ok(0));
    assert!(
        outcomes
            .iter()
            .all(|one| *one == SentenceOutcome::NotUnderstood)
    );
    // Half of a sentence of the language, a count that is an id, a second translation.
    let half = format!("Obstacle {id} is {distance:.2} m away from the ego and swerves.");
    let (count, outcomes) = read(serde_json::json!({"sentences": [
        {"number": 1, "claims": [half]},
        {"number": 1, "claims": [said(distance)]},
        {"number": 2, "claims": [format!("{other} vehicles are ahead of the ego.")]},
    ]}));
    assert_eq!(count, Ok(0), "{outcomes:?}");
    assert!(
        read(serde_json::json!({"answer": "all are right"}))
            .0
            .is_err()
    );
    assert!(translation_schema().to_string().contains("claims"));
}

/// Whether the first sentence of a text contradicts something, and what its first claim says of it.
fn contradicts(text: &str) -> Option<String> {
    let scene = scene();
    let (.., window) = cast(&scene);
    let subject = Subject::new(&scene, TimeOrigin::Recording, Some(window));
    let found = sentences(text, &subject);
    let first = &found[0];
    let claim = first.claims.iter().find_map(|one| one.contradicts.clone());
    assert_eq!(claim.is_some(), !first.contradicts.is_empty(), "{first:?}");
    claim
}

#[test]
fn scores_verdicts_and_sentences_contradict_each_other() {
    let scene = scene();
    let (id, other, _) = cast(&scene);
    for (text, is_against) in [
        (
            format!("Obstacle {id} will collide with the ego.\nObstacle {id}: risk score 5."),
            true,
        ),
        (
            format!("Obstacle {id} will collide with the ego.\nObstacle {other}: risk score 5."),
            false,
        ),
        (
            format!("Obstacle {id} touches the ego.\nObstacle {id}: risk score 0."),
            false,
        ),
        (
            format!("Obstacle {id} does not touch the ego.\nObstacle {id}: risk score 0."),
            true,
        ),
        (
            format!("Obstacle {id} is approaching.\nObstacle {id} is moving away."),
            true,
        ),
        (
            format!("Obstacle {id} will collide with the ego.\n{{\"collision\": false}}"),
            true,
        ),
        (
            format!("Obstacle {id} will collide with the ego.\n{{\"collision\": true}}"),
            false,
        ),
        (
            format!("Obstacle {id} will not collide with the ego.\n{{\"collision\": false}}"),
            false,
        ),
        (
            format!("Obstacle {id}: risk score 1.\n{{\"safety_critical\": false}}"),
            true,
        ),
        (
            format!("Obstacle {id}: risk score 3.\n{{\"safety_critical\": false}}"),
            false,
        ),
    ] {
        let said = contradicts(&text);
        assert_eq!(said.is_some(), is_against, "{text}: {said:?}");
    }
}

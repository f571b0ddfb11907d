//! What came of the drive goes back to the model, and the model's grades of its motions stand beside the exact ranking.

use std::sync::Arc;

use nearmiss::evaluation::generating::{Authored, Progress, Ranking, Source};
use nearmiss::store::{Filter, Store};
use serde_json::{Value, json};

use super::bench::{
    ATTACKER, Written, again, chooses, cut_in, does, on_ground, recorded, says, scene, through,
    waypoints, written,
};
use super::support::server::{Recorded, Script};

/// A motion beside the recorded one, which passes the gate and changes nothing.
fn harmless() -> Value {
    waypoints(2, |step| {
        let mut state = recorded(ATTACKER, step);
        let ego = scene().ego.track.at(step).unwrap().pose.position;
        let side = state.pose.to_local(&ego).y.signum();
        let x = ((step - 60) as f64 / 25.0).clamp(0.0, 1.0);
        // Away from the ego.
        state.pose.position -= state.pose.left() * (0.3 * side * x * x * (3.0 - 2.0 * x));
        state
    })
}

/// The text of a message of a request.
fn said(request: &Recorded, place: usize) -> String {
    let body = request.json();
    body["messages"][place]["content"].as_str().unwrap().into()
}

/// A safety verdict with this score for the attacker.
fn grades(score: u8) -> Script {
    let answer = json!({
        "justification": "It closes in.",
        "obstacles": [{"id": ATTACKER, "risk_score": score, "reason": "near"}],
        "critical_obstacles": [{"id": ATTACKER, "probability": 0.9}],
        "probability": 0.9,
        "safety_critical": true,
    });
    says(&answer.to_string())
}

fn drive(written: &mut Written) -> &mut Authored {
    let authored = written.outcome.as_mut().unwrap();
    on_ground(&scene(), |ground| {
        assert!(authored.drive_watched(ground, 0.5, &mut |_| true));
    });
    authored
}

#[tokio::test]
async fn what_came_of_the_drive_goes_back_until_it_has_an_effect() {
    let store = Arc::new(Store::in_memory().unwrap());
    let scripts = vec![
        chooses(json!(ATTACKER)),
        through(ATTACKER, &harmless()),
        does(&cut_in()),
        says("never asked for"),
    ];
    let mut told = written(scripts, |author| {
        author.method.feedback = true;
        author.store = Some(store.clone());
    })
    .await;
    assert_eq!(told.requests.len(), 3, "{:?}", told.authored().declined);
    let attacks = &told.authored().attacks;
    assert_eq!(attacks.len(), 2);
    assert!(attacks[0].feedback.is_some() && attacks[1].feedback.is_none());
    assert!(!attacks[0].admitted.attack.has_effect());
    assert!(attacks[1].admitted.attack.has_effect());
    assert_eq!(attacks[1].admitted.attack.survivable, Some(true));
    let first: Vec<String> = (0..2).map(|place| said(&told.requests[1], place)).collect();
    let second: Vec<String> = (0..4).map(|place| said(&told.requests[2], place)).collect();
    assert_eq!(first[..], second[..2]);
    // The first prompt says that the ego reacts, and the second turn how it did.
    for words in [
        "replans at every step",
        "reacts",
        "0.5 s after the motion departs",
    ] {
        assert!(first[0].contains(words), "{words}: {}", first[0]);
    }
    let words = &second[3];
    let effect = attacks[0].admitted.attack.effect.as_ref().unwrap();
    let near = format!(
        "smallest distance between the two bodies was {:.2} m",
        effect.distance().unwrap()
    );
    let score = format!(
        "lowest risk score of the attacker was {}",
        effect.lowest_after().unwrap()
    );
    for part in [
        &near,
        &score,
        "The ego avoided the danger",
        "t = ",
        "step,t [s],x [m]",
        "Give the whole answer again",
    ] {
        assert!(words.contains(part), "`{part}` is not in {words}");
    }
    let driven = |p: &&Progress| matches!(p, Progress::Driving(_));
    assert_eq!(told.progress.iter().filter(driven).count(), 2);
    let tries = told.authored().tries();
    assert_eq!((tries.conversations, tries.first_admitted), (1, 1));
    assert_eq!((tries.first_effective, tries.effective), (0, 1));

    // The same again costs nothing, and is the same.
    assert_eq!(store.numbers(&Filter::default()).unwrap().len(), 3);
    let mut again = again(&told).await;
    let spent = again.authored().spent;
    assert_eq!((spent.requests, spent.stored), (3, 3));
    let chosen = |authored: &Authored| {
        let taken = on_ground(&scene(), |ground| authored.taken(ground, 0.5));
        let attack = taken.chosen.unwrap().attack;
        let document = json!(authored.record(Some(&attack)));
        assert_eq!(document["motions"][0]["sent_back"], true);
        assert_eq!(document["motions"][0]["outcome"], "no_effect");
        assert_eq!(document["motions"][1]["taken"], true);
        assert!(document["motions"][1]["min_distance_step"].is_i64());
        attack.change
    };
    assert_eq!(chosen(drive(&mut told)), chosen(drive(&mut again)));
}

#[tokio::test]
async fn retries_end_the_news_of_drives() {
    let scripts = vec![through(ATTACKER, &harmless()); 4];
    let told = written(scripts, |author| {
        author.attacker = Some(ATTACKER);
        author.method.feedback = true;
        author.method.retries = 1;
    })
    .await;
    let attacks = &told.authored().attacks;
    assert_eq!((told.requests.len(), attacks.len()), (2, 2));
    assert!(attacks[0].feedback.is_some() && attacks[1].feedback.is_none());
}

#[tokio::test]
async fn motions_are_graded_and_both_rankings_are_compared() {
    let store = Arc::new(Store::in_memory().unwrap());
    let scripts = || {
        vec![
            through(ATTACKER, &harmless()),
            does(&cut_in()),
            // The model prefers the harmless one.
            grades(1),
            grades(4),
        ]
    };
    let mut graded = written(scripts(), |author| {
        author.attacker = Some(ATTACKER);
        (author.method.samples, author.method.grades) = (2, true);
        author.store = Some(store.clone());
    })
    .await;
    assert_eq!(graded.requests.len(), 4);
    let asked: Vec<String> = (2..4).map(|n| said(&graded.requests[n], 1)).collect();
    assert_ne!(asked[0], asked[1]);
    for (request, text) in graded.requests[2..].iter().zip(&asked) {
        let system = said(request, 0);
        assert!(system.contains("safety-critical") && system.contains("time to collision"));
        // Nothing is told of what came of it, and no contact is in what is described.
        for word in ["candidate", "driven against", "attack"] {
            assert!(!system.contains(word) && !text.contains(word), "{word}");
        }
        assert!(
            text.contains(&ATTACKER.to_string()) && !text.contains("Contact"),
            "{text}"
        );
    }
    // What is asked of the candidate is no answer about the scenario.
    let runs = store.numbers(&Filter::default()).unwrap();
    assert_eq!(runs.len(), 4);
    let score = |place: usize| graded.authored().attacks[place].score();
    assert_eq!((score(0), score(1)), (Some(1), Some(4)));
    let authored = drive(&mut graded);
    let agreement = authored.agreement().unwrap();
    assert!(!agreement.agrees && agreement.of == 2);
    assert_eq!((agreement.model.sample, agreement.exact.sample), (0, 1));
    let taken = |authored: &Authored| {
        let taken = on_ground(&scene(), |ground| authored.taken(ground, 0.5));
        let attack = taken.chosen.unwrap().attack;
        let source: Source = authored.find_source(&attack).unwrap().source;
        (source.sample, json!(authored.record(Some(&attack))))
    };
    let (exact, document) = taken(authored);
    assert_eq!((exact, &document["ranked_by"]), (1, &json!("exact")));
    assert_eq!(document["agreement"]["agrees"], false);
    assert_eq!(document["motions"][0]["grade"], 1);
    // The grades decide only where that is asked for.
    authored.rank = Ranking::Model;
    let (model, document) = taken(authored);
    assert_eq!((model, &document["ranked_by"]), (0, &json!("model")));

    // The same motion once more is no further one: two of three answers have the one that the exact ranking prefers.
    let twice = authored.attacks[0].clone();
    assert!(twice.source == authored.agreement().unwrap().exact);
    authored.attacks.push(twice.clone());
    let agreement = authored.agreement().unwrap();
    assert_eq!(agreement.of, 2);
    assert!((agreement.by_chance - 2.0 / 3.0).abs() < 1e-12);
    authored.attacks = vec![twice.clone(), twice];
    assert!(authored.agreement().is_none(), "one motion is no ranking");

    // Nothing is paid twice.
    let again = again(&graded).await;
    assert_eq!(
        (
            again.authored().spent.requests,
            again.authored().spent.stored
        ),
        (4, 4)
    );
}

#[tokio::test]
async fn a_grade_that_says_nothing_does_not_count() {
    let scripts = vec![
        through(ATTACKER, &harmless()),
        does(&cut_in()),
        says("I like trains."),
        grades(3),
    ];
    let mut graded = written(scripts, |author| {
        author.attacker = Some(ATTACKER);
        (author.method.samples, author.method.grades) = (2, true);
        author.method.rank = Ranking::Model;
    })
    .await;
    let problem = |place: usize| {
        let grade = graded.authored().attacks[place].grade.clone().unwrap();
        (grade.score, grade.problem)
    };
    assert_eq!(problem(1), (Some(3), None));
    let (score, why) = problem(0);
    assert!(score.is_none() && why.unwrap().contains("no verdict"));
    let authored = drive(&mut graded);
    assert!(authored.agreement().is_none(), "one grade is no ranking");
    assert_eq!(authored.by_model().unwrap().source.sample, 1);

    // Without any grade the exact ranking decides.
    let nothing =
        says(&json!({"justification": "", "obstacles": [], "safety_critical": false}).to_string());
    let scripts = vec![
        through(ATTACKER, &harmless()),
        does(&cut_in()),
        nothing.clone(),
        nothing,
    ];
    let mut graded = written(scripts, |author| {
        author.attacker = Some(ATTACKER);
        (author.method.samples, author.method.grades) = (2, true);
        author.method.rank = Ranking::Model;
    })
    .await;
    let authored = drive(&mut graded);
    let grade = authored.attacks[0].grade.as_ref().unwrap();
    assert!(
        grade
            .problem
            .as_ref()
            .unwrap()
            .contains("does not grade obstacle"),
        "{grade:?}"
    );
    let taken = on_ground(&scene(), |ground| authored.taken(ground, 0.5));
    assert!(taken.chosen.unwrap().attack.has_effect());
}

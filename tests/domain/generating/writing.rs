//! Motions that models write: refused with reasons, mended, repaired, never paid for twice.

use std::sync::Arc;

use nearmiss::evaluation::Judge;
use nearmiss::evaluation::generating::{AuthorError, Progress};
use nearmiss::generation::Reason;
use nearmiss::llm::Budget;
use nearmiss::store::{Filter, Store};
use serde_json::{Value, json};

use super::bench::{
    ATTACKER, COST, OTHER, again, chooses, cut_in, does, driven, jumping, on_ground, recorded,
    says, scene, through, waypoints, written,
};
use super::support::server::{Recorded, Script};

fn messages(request: &Recorded) -> Vec<(String, String)> {
    let body = request.json();
    let all = body["messages"].as_array().unwrap().iter();
    let text = |value: &Value| value.as_str().unwrap().to_string();
    all.map(|m| (text(&m["role"]), text(&m["content"])))
        .collect()
}

#[tokio::test]
async fn nonsense_makes_nothing_and_costs_no_more_than_was_agreed() {
    let scripts = vec![says("I like trains."); 9];
    let written = written(scripts, |author| {
        author.method.samples = 2;
        author.method.retries = 1;
    })
    .await;
    assert_eq!(written.requests.len(), 5);
    let authored = written.authored();
    assert!(authored.attacks.is_empty());
    assert_eq!((authored.declined.len(), authored.candidates()), (4, 4));
    assert!((0..4).all(|place| written.words(place).contains("no JSON object")));
    let places: Vec<(u32, u32)> = { authored.declined.iter() }
        .map(|d| (d.source.sample, d.source.retry))
        .collect();
    assert_eq!(places, [(0, 0), (0, 1), (1, 0), (1, 1)]);
    let spent = authored.spent;
    assert_eq!((spent.requests, spent.answers, spent.stored), (5, 5, 0));
    assert_eq!((spent.input_tokens, spent.output_tokens), (45_000, 500));
    assert!((spent.usd - 5.0 * COST).abs() < 1e-12 && spent.unpriced == 0);
    let refused = |p: &&Progress| matches!(p, Progress::Refused(_));
    assert_eq!(written.progress.iter().filter(refused).count(), 4);
}

#[tokio::test]
async fn a_jump_goes_back_with_the_gates_words_and_is_mended() {
    let scripts = vec![
        chooses(json!(ATTACKER)),
        through(ATTACKER, &jumping()),
        through(ATTACKER, &driven(2)),
    ];
    let written = written(scripts, |_| {}).await;
    let authored = written.authored();
    assert_eq!((authored.attacks.len(), authored.declined.len()), (1, 1));
    let refusal = &authored.declined[0].refusals[0];
    assert_eq!((&refusal.reason, refusal.step), (&Reason::Jump, Some(46)));
    assert!((refusal.value.unwrap() - 10.7).abs() < 0.01);
    let attack = &authored.attacks[0];
    assert_eq!(
        (attack.source.retry, attack.justification.as_str()),
        (1, "It leaves no room.")
    );

    let conversation = messages(&written.requests[2]);
    let roles: Vec<&str> = conversation.iter().map(|(role, _)| role.as_str()).collect();
    assert_eq!(roles, ["system", "user", "assistant", "user"]);
    let first = messages(&written.requests[1]);
    assert_eq!(conversation[..2], first[..]);
    assert!(conversation[2].1.contains("\"step\":46"));
    let told = &conversation[3].1;
    assert!(told.contains(&format!("- {refusal}\n")), "{told}");
    assert!(told.contains("step 46: jump 10.7"), "{told}");
    let start = recorded(ATTACKER, 45).pose.position;
    assert!(told.contains(&format!(
        "At step 45 the obstacle is recorded at ({:.2}, ",
        start.x
    )));
}

#[tokio::test]
async fn what_can_be_driven_is_taken_as_it_is() {
    let scripts = vec![chooses(json!(ATTACKER)), through(ATTACKER, &driven(2))];
    let written = written(scripts, |_| {}).await;
    let made = &written.authored().attacks[0].admitted;
    assert!(made.repair.is_none());
    for point in driven(2).as_array().unwrap() {
        let change = &made.attack.change.changes()[0];
        let motion = change.motions.iter().find(|(s, _)| point["step"] == *s);
        let at = motion.unwrap().1.pose.position;
        let off = (at.x - point["x"].as_f64().unwrap()).abs();
        assert!(off < 0.006, "{off}");
    }
}

#[tokio::test]
async fn rounded_waypoints_are_repaired_and_the_attack_is_driven() {
    let scripts = vec![chooses(json!(ATTACKER)), through(ATTACKER, &driven(1))];
    let mut written = written(scripts, |_| {}).await;
    let authored = written.outcome.as_mut().unwrap();
    let repair = authored.attacks[0].admitted.repair.clone().unwrap();
    assert!(repair.moved > 0.0 && repair.moved < 0.5, "{repair:?}");
    let reasons: Vec<&str> = { repair.refused.iter() }.map(|r| r.reason.name()).collect();
    assert!(reasons.contains(&"start"), "{reasons:?}");
    let chosen = on_ground(&scene(), |ground| {
        assert!(authored.drive_watched(ground, 0.5, &mut |_| true));
        authored.taken(ground, 0.5)
    });
    let chosen = chosen.chosen.unwrap();
    assert_eq!(
        authored.find_source(&chosen.attack).unwrap().source.sample,
        0
    );
    let effect = chosen.attack.effect.unwrap();
    assert_eq!(effect.main().obstacle, ATTACKER);
    assert!(effect.distance().unwrap() < 1.5, "{:?}", effect.distance());
}

#[tokio::test]
async fn waypoints_by_times_and_places_alone_are_enough() {
    // Over to the ego's side by 0.8 m, smoothly.
    let mut points = waypoints(2, |step| {
        let mut state = recorded(ATTACKER, step);
        let ego = scene().ego.track.at(step).unwrap().pose.position;
        let side = state.pose.to_local(&ego).y.signum();
        let x = ((step - 60) as f64 / 25.0).clamp(0.0, 1.0);
        state.pose.position += state.pose.left() * (0.8 * side * x * x * (3.0 - 2.0 * x));
        state
    });
    for point in points.as_array_mut().unwrap() {
        point["time"] = json!(point["step"].as_f64().unwrap() / 10.0);
        for key in ["step", "heading", "velocity"] {
            point[key] = json!(null);
        }
    }
    let scripts = vec![chooses(json!(ATTACKER)), through(ATTACKER, &points)];
    let written = written(scripts, |author| author.method.retries = 0).await;
    let attacks = &written.authored().attacks;
    assert_eq!(attacks.len(), 1, "{:?}", written.authored().declined);
    let change = &attacks[0].admitted.attack.change.changes()[0];
    assert_eq!((change.from(), change.until()), (Some(45), Some(90)));
    let moved = change.motions[45].1.pose.position - recorded(ATTACKER, 90).pose.position;
    assert!((moved.norm() - 0.8).abs() < 0.4, "{}", moved.norm());
}

#[tokio::test]
async fn a_manoeuvre_becomes_an_attack() {
    let scripts = vec![chooses(json!(ATTACKER)), does(&cut_in())];
    let written = written(scripts, |_| {}).await;
    let attacks = &written.authored().attacks;
    assert_eq!(attacks.len(), 1);
    assert!(attacks[0].admitted.repair.is_none());
    assert_eq!(attacks[0].admitted.attack.rehearsal.distance, 0.0);
}

#[tokio::test]
async fn the_wrong_obstacle_is_refused() {
    let scripts = vec![
        chooses(json!(ATTACKER)),
        through(OTHER, &driven(2)),
        through(90_210, &driven(2)),
        says(""),
    ];
    let written = written(scripts, |_| {}).await;
    assert!(written.authored().attacks.is_empty());
    let asked = format!("instead of obstacle {ATTACKER}");
    assert!(
        written
            .words(0)
            .contains(&format!("moves obstacle {OTHER} {asked}"))
    );
    assert!(
        written
            .words(1)
            .contains("90210, which is not in the scenario")
    );
    assert!(written.words(2).contains("blank"), "{}", written.words(2));
    assert_eq!(written.requests.len(), 4);
}

#[tokio::test]
async fn a_blank_answer_is_not_sent_back() {
    let scripts = vec![
        chooses(json!(ATTACKER)),
        says(""),
        through(ATTACKER, &driven(2)),
    ];
    let written = written(scripts, |_| {}).await;
    assert_eq!(written.authored().attacks.len(), 1);
    let conversation = messages(&written.requests[2]);
    assert_eq!(conversation.len(), 2);
    assert!(conversation[1].1.contains("This motion cannot be used"));
}

/// The driven waypoints with a change in one of them.
fn with(place: usize, key: &str, value: Value) -> Value {
    let mut points = driven(2);
    points[place][key] = value;
    points
}

#[tokio::test]
async fn impossible_physics_is_refused_by_name() {
    let manoeuvre = |key: &str, value: Value| {
        let mut manoeuvre = cut_in();
        manoeuvre[key] = value;
        does(&manoeuvre)
    };
    let start = recorded(ATTACKER, 45);
    let cases: Vec<(Script, &str)> = vec![
        (
            through(ATTACKER, &with(0, "x", json!(start.pose.position.x - 10.7))),
            "position at the start differs from the recorded one 10.7",
        ),
        (through(ATTACKER, &with(4, "y", json!(1e9))), "jump"),
        (
            through(ATTACKER, &with(3, "velocity", json!(-3.0))),
            "speed backwards 3.0",
        ),
        (
            through(ATTACKER, &with(3, "velocity", json!(45.0))),
            "acceleration",
        ),
        (
            through(ATTACKER, &with(3, "heading", json!(2.8))),
            "rad from waypoint 4",
        ),
        (
            through(ATTACKER, &with(9, "step", json!(i64::MAX))),
            "waypoint 10 is at step",
        ),
        (
            through(ATTACKER, &with(0, "step", json!(-7))),
            "waypoint 1 is at step -7",
        ),
        (manoeuvre("duration", json!(1e300)), "the scenario ends"),
        (manoeuvre("start", json!(1e300)), "the scenario ends"),
        (manoeuvre("gap", json!(1e300)), ""),
        (manoeuvre("speed", json!(1e300)), ""),
    ];
    let count = cases.len();
    let (scripts, words): (Vec<Script>, Vec<&str>) = cases.into_iter().unzip();
    let scripts = [vec![chooses(json!(ATTACKER))], scripts].concat();
    let written = written(scripts, |author| {
        author.method.samples = count as u32;
        author.method.retries = 0;
    })
    .await;
    let authored = written.authored();
    assert_eq!(authored.attacks.len(), 0, "{:?}", authored.attacks);
    assert_eq!(authored.declined.len(), count);
    for (place, word) in words.iter().enumerate() {
        let said = written.words(place);
        assert!(said.contains(word), "{place}: `{word}` is not in {said}");
    }
}

#[tokio::test]
async fn nothing_is_paid_for_twice() {
    let store = Arc::new(Store::in_memory().unwrap());
    let scripts = vec![
        chooses(json!(ATTACKER)),
        through(ATTACKER, &jumping()),
        through(ATTACKER, &driven(2)),
    ];
    let first = written(scripts, |author| author.store = Some(store.clone())).await;
    assert_eq!(first.requests.len(), 3);
    assert_eq!(store.numbers(&Filter::default()).unwrap().len(), 3);
    // The server is gone: what is answered now comes from the store.
    let again = again(&first).await;
    let (one, two) = (first.authored(), again.authored());
    let change = |place: usize| &[one, two][place].attacks[0].admitted.attack.change;
    assert_eq!(change(0), change(1));
    assert_eq!((two.spent.stored, two.spent.requests), (3, 3));
    assert!((two.spent.usd_before - 3.0 * COST).abs() < 1e-12);
    assert_eq!(one.spent.usd_before, 0.0);
}

#[tokio::test]
async fn a_server_that_lets_nobody_in_is_asked_once() {
    let refused = Script::json(401, r#"{"error": {"message": "no such key"}}"#);
    let written = written(vec![refused; 9], |author| author.method.samples = 5).await;
    assert_eq!(written.requests.len(), 1);
    let authored = written.authored();
    assert!(
        authored.stopped.as_ref().unwrap().contains("401"),
        "{authored:?}"
    );
    assert!(authored.attacks.is_empty() && authored.declined.is_empty());
}

#[tokio::test]
async fn what_is_refused_before_it_is_sent_is_an_error() {
    let reference = written(Vec::new(), |author| {
        author.judge = Judge::Reference;
    })
    .await;
    let why = reference.outcome.unwrap_err();
    assert!(matches!(why, AuthorError::Ask(_)), "{why}");
    assert!(why.to_string().contains("choose a model"), "{why}");
}

#[tokio::test]
async fn several_conversations_at_once_keep_to_their_own_and_to_the_budget() {
    let scripts = vec![through(ATTACKER, &driven(1)); 4];
    let all = written(scripts, |author| {
        author.attacker = Some(ATTACKER);
        (author.method.samples, author.at_once) = (4, 4);
    })
    .await;
    let samples: Vec<u32> = { all.authored().attacks.iter() }
        .map(|a| a.source.sample)
        .collect();
    assert_eq!(samples, [0, 1, 2, 3]);
    assert_eq!((all.requests.len(), all.authored().spent.answers), (4, 4));

    // What is left of the budget is enough for the first answer alone.
    let scripts = vec![says("none"), through(ATTACKER, &driven(1))];
    let short = written(scripts, |author| {
        author.attacker = Some(ATTACKER);
        let Judge::Model(model) = &mut author.judge else {
            panic!()
        };
        model.parameters.max_tokens = Some(1000);
        model.endpoint.budget = Some(Budget::new(0.0245));
    })
    .await;
    let authored = short.authored();
    let stopped = authored.stopped.as_deref().unwrap_or_default();
    assert_eq!((short.requests.len(), authored.declined.len()), (1, 1));
    assert!(stopped.contains("budget"), "{stopped}");
}

//! The attacker is chosen by the model where that can be taken, else by the reference, and the report says which.

use nearmiss::evaluation::generating::{Author, AuthorError, Bound, ChosenBy, bound};
use serde_json::json;

use super::bench::{
    ATTACKER, OTHER, PARKED, author, chooses, cut_in, does, on_ground, says, scene, written,
};

#[tokio::test]
async fn a_choice_that_cannot_be_taken_is_refused_with_the_reason() {
    let cases = [
        (json!(null), "no obstacle can attack"),
        (json!(424_242), "no obstacle 424242 in the scenario"),
        (json!(PARKED), "is parked and does not move"),
        (json!(scene().ego.id), "is the ego itself"),
    ];
    for (choice, why) in cases {
        // Obeyed, nothing is written.
        let obeyed = written(vec![chooses(choice.clone())], |author| author.obey = true).await;
        assert!(obeyed.choice_refused().contains(why), "{choice}");
        let authored = obeyed.authored();
        assert_eq!(authored.choice.by, ChosenBy::NoAttacker);
        assert_eq!((authored.choice.attacker, obeyed.requests.len()), (None, 1));
        assert!(authored.attacks.is_empty() && authored.declined.is_empty());
        assert!(authored.refusals()[0].to_string().contains(why));

        // Otherwise the reference's first is taken, and the motion is asked for that one.
        let scripts = vec![chooses(choice.clone()), does(&cut_in())];
        let fallen = written(scripts, |_| {}).await;
        assert!(fallen.choice_refused().contains(why), "{choice}");
        let choice = &fallen.authored().choice;
        assert_eq!(choice.by, ChosenBy::Reference);
        assert_eq!(choice.attacker, Some(choice.ranked[0].obstacle));
        let asked = fallen.requests[1].json()["messages"][1]["content"].to_string();
        assert!(
            asked.contains(&format!("for obstacle {ATTACKER} ")),
            "{asked}"
        );
        assert_eq!(fallen.authored().attacks.len(), 1);
    }
}

#[tokio::test]
async fn the_models_choice_stands_beside_the_references() {
    let scripts = vec![chooses(json!(OTHER)), says("none")];
    let written = written(scripts, |author| author.method.retries = 0).await;
    let choice = &written.authored().choice;
    assert_eq!((choice.by, choice.attacker), (ChosenBy::Model, Some(OTHER)));
    assert_eq!(choice.ranked[0].obstacle, ATTACKER);
    let proposal = choice.proposal.as_ref().unwrap();
    let said = proposal.choice.as_ref().unwrap();
    assert_eq!(said.obstacles[0].id, ATTACKER);
    assert_eq!(said.justification, "It is the nearest.");
    assert!(proposal.run.is_some() && proposal.refused.is_none());
    // It was asked about the steps that end where the reference's first could be at the ego.
    assert_eq!(proposal.window.1, choice.ranked[0].step);
    let asked = written.requests[0].json();
    let system = asked["messages"][0]["content"].as_str().unwrap();
    assert!(system.contains("time to collision"), "{system}");
}

#[tokio::test]
async fn an_attacker_that_the_user_names_is_not_asked_for() {
    let scripts = vec![does(&cut_in())];
    let named = written(scripts, |author| author.attacker = Some(ATTACKER)).await;
    let authored = named.authored();
    assert_eq!(authored.choice.by, ChosenBy::User);
    assert!(authored.choice.proposal.is_none());
    assert_eq!((authored.attacks.len(), named.requests.len()), (1, 1));

    let wrong = written(Vec::new(), |author| author.attacker = Some(7)).await;
    let why = wrong.outcome.unwrap_err();
    assert!(matches!(why, AuthorError::Attacker(_)));
    assert!(why.to_string().contains("no obstacle 7"), "{why}");
    assert!(wrong.requests.is_empty());
}

#[tokio::test]
async fn most_votes_decide_and_all_are_kept() {
    let scripts = vec![
        chooses(json!(OTHER)),
        chooses(json!(ATTACKER)),
        chooses(json!(OTHER)),
        says("none"),
    ];
    let polled = written(scripts, |author| {
        author.method.votes = 3;
        author.method.retries = 0;
    })
    .await;
    let choice = &polled.authored().choice;
    assert_eq!((choice.by, choice.attacker), (ChosenBy::Model, Some(OTHER)));
    assert_eq!(choice.tally(), [(OTHER, 2), (ATTACKER, 1)]);
    assert!(choice.tied.is_empty());
    assert_eq!(choice.within, Some(30.0));
    // Three answers to one question, each with a run of its own.
    let bodies = &polled.requests;
    assert_eq!(bodies.len(), 4);
    assert!(
        bodies[..3]
            .iter()
            .all(|body| body.json() == bodies[0].json())
    );
    let runs: std::collections::BTreeSet<_> = choice.votes.iter().map(|v| v.run).collect();
    assert_eq!(runs.len(), 3);
    assert_eq!(choice.proposal.as_ref().unwrap().run, choice.votes[0].run);
    let asked = bodies[3].json()["messages"][1]["content"].to_string();
    assert!(asked.contains(&format!("for obstacle {OTHER} ")));
    let document = json!(polled.authored().record(None));
    let tally = json!([{"attacker": OTHER, "votes": 2}, {"attacker": ATTACKER, "votes": 1}]);
    assert_eq!(document["tally"], tally);
    assert_eq!(document["votes"].as_array().unwrap().len(), 3);
}

#[tokio::test]
async fn the_reference_ranking_breaks_ties() {
    let scripts = vec![
        chooses(json!(OTHER)),
        chooses(json!(ATTACKER)),
        says("none"),
    ];
    let tied = written(scripts, |author| {
        author.method.votes = 2;
        author.method.retries = 0;
    })
    .await;
    let choice = &tied.authored().choice;
    assert_eq!(
        (choice.by, choice.attacker),
        (ChosenBy::Model, Some(ATTACKER))
    );
    assert_eq!(choice.tied, [OTHER]);
    // Its reasons are those of the vote that won.
    assert_eq!(choice.proposal, Some(choice.votes[1].clone()));
    assert_eq!(
        json!(tied.authored().record(None))["tied_with"],
        json!([OTHER])
    );
}

#[tokio::test]
async fn votes_that_say_nothing_do_not_count() {
    let garbage = || {
        vec![
            says("I like trains."),
            chooses(json!(PARKED)),
            chooses(json!(null)),
        ]
    };
    let scripts = [garbage(), vec![chooses(json!(OTHER)), says("none")]].concat();
    let one = written(scripts, |author| {
        author.method.votes = 4;
        author.method.retries = 0;
    })
    .await;
    let choice = &one.authored().choice;
    assert_eq!((choice.by, choice.attacker), (ChosenBy::Model, Some(OTHER)));
    assert_eq!(
        choice.votes.iter().filter(|v| v.refused.is_some()).count(),
        3
    );

    let scripts = [garbage(), vec![says("none")]].concat();
    let none = written(scripts, |author| {
        author.method.votes = 3;
        author.method.retries = 0;
    })
    .await;
    let choice = &none.authored().choice;
    assert_eq!(
        (choice.by, choice.attacker),
        (ChosenBy::Reference, Some(ATTACKER))
    );
    assert!(
        none.choice_refused().contains("no verdict"),
        "{}",
        none.choice_refused()
    );
    let obeyed = written(garbage(), |author| {
        author.method.votes = 3;
        author.obey = true;
    })
    .await;
    assert_eq!(obeyed.authored().choice.by, ChosenBy::NoAttacker);
    assert_eq!(obeyed.requests.len(), 3);
}

/// How near an obstacle's centre comes to the ego's in the steps of a window.
fn nearest(obstacle: i64, window: (i64, i64)) -> f64 {
    let scene = scene();
    let steps = (window.0..=window.1).filter_map(|step| {
        let ego = scene.ego.track.at(step)?.pose.position;
        let other = super::bench::scenario()
            .obstacle(obstacle)?
            .track()
            .at(step)?
            .pose
            .position;
        Some((other - ego).norm())
    });
    steps.fold(f64::INFINITY, f64::min)
}

#[tokio::test]
async fn the_attacker_is_one_that_comes_near_ahead_or_beside() {
    let usual = written(vec![chooses(json!(ATTACKER)), says("none")], |author| {
        author.method.retries = 0;
    })
    .await;
    let window = usual.authored().choice.proposal.as_ref().unwrap().window;
    let (near, far) = (nearest(ATTACKER, window), nearest(OTHER, window));
    assert!(near < far - 1.0, "{near} {far}");
    let between = f64::midpoint(near, far);
    let scripts = vec![chooses(json!(OTHER)), says("none")];
    let told = written(scripts, |author| {
        author.method.within = between;
        author.method.retries = 0;
    })
    .await;
    let why = told.choice_refused();
    assert!(
        why.contains(&format!("not within {between} m ahead of the ego")),
        "{why}"
    );
    assert_eq!(told.authored().choice.attacker, Some(ATTACKER));
    let asked = told.requests[0].json()["messages"][0]["content"].to_string();
    assert!(
        asked.contains(&format!("within {between} m of the ego")),
        "{asked}"
    );
}

#[tokio::test]
async fn where_no_obstacle_comes_near_nothing_is_voted_on() {
    let scripts = vec![chooses(json!(OTHER)), does(&cut_in())];
    let far = written(scripts[1..].to_vec(), |author| {
        author.method.within = 0.5;
        author.method.votes = 3;
    })
    .await;
    let authored = far.authored();
    let choice = &authored.choice;
    assert_eq!(
        (choice.by, choice.attacker),
        (ChosenBy::Reference, Some(ATTACKER))
    );
    assert!(choice.votes.is_empty() && choice.within.is_none());
    // The only request is the one for the motion.
    assert_eq!((far.requests.len(), authored.attacks.len()), (1, 1));
    let document = json!(authored.record(None));
    assert_eq!(
        document["not_asked"],
        "no obstacle comes within 0.5 m ahead of the ego or beside it"
    );
    assert_eq!(document["attacker_by"], "reference");

    let obeyed = written(scripts, |author| {
        author.method.within = 0.5;
        author.obey = true;
    })
    .await;
    assert_eq!(obeyed.authored().choice.by, ChosenBy::NoAttacker);
    assert!(obeyed.requests.is_empty());
    assert_eq!(json!(obeyed.authored().record(None))["attacker_by"], "none");
}

/// What would be asked at most.
fn bounded(with: impl FnOnce(&mut Author)) -> Bound {
    let mut author = author("http://127.0.0.1:1/v1");
    author.method.retries = 0;
    with(&mut author);
    let scene = scene();
    on_ground(&scene, |ground| bound(&author, ground, &scene, 0.5)).unwrap()
}

#[test]
fn the_bound_holds_whichever_obstacle_the_model_chooses() {
    // Without votes only motions are counted.
    let any = bounded(|author| author.method.votes = 0);
    assert_eq!((any.votes, any.motions), (0, 1));
    let named = |id| bounded(|author| author.attacker = Some(id)).tokens;
    let (first, other) = (named(ATTACKER), named(OTHER));
    assert!(other > first && any.tokens >= other, "{first} {other}");

    // Nothing is voted on where no obstacle comes near, and only the reference's first attacks.
    let far = bounded(|author| (author.method.votes, author.method.within) = (3, 0.5));
    assert_eq!((far.votes, far.motions, far.tokens), (0, 1, first));
    let obeyed = bounded(|author| (author.obey, author.method.within) = (true, 0.5));
    assert_eq!(obeyed.requests(), 0);
}

//! The attacker is chosen by the model where that can be taken, else by the reference, and the report says which.

use nearmiss::evaluation::generating::{AuthorError, ChosenBy};
use serde_json::json;

use super::bench::{ATTACKER, OTHER, PARKED, chooses, cut_in, does, says, scene, written};

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
    let written = written(scripts, |author| author.retries = 0).await;
    let choice = &written.authored().choice;
    assert_eq!((choice.by, choice.attacker), (ChosenBy::Model, Some(OTHER)));
    assert_eq!(choice.ranked[0].obstacle, ATTACKER);
    let proposal = choice.proposal.as_ref().unwrap();
    let said = proposal.said.as_ref().unwrap();
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

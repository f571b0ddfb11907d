//! Words that the grammar does not read and that change what a sentence says: it is neither right nor wrong.

use super::*;

/// What sentences about the bundled cut-in come to, at step 44.
fn outcomes(text: &str) -> Vec<SentenceOutcome> {
    let scene = scene();
    let subject = Subject::new(&scene, TimeOrigin::Recording, Some((35, 44)));
    let all = sentences(text, &subject).into_iter();
    all.map(|one| one.outcome).collect()
}

#[test]
fn what_changes_a_sentence_is_not_read_over() {
    // Without such words they are read.
    assert_eq!(outcomes("301 is ahead of me."), [SentenceOutcome::Right]);
    assert_eq!(outcomes("301 is behind me."), [SentenceOutcome::Wrong]);
    for text in [
        "Only 301 is ahead of me.",
        "301 is the only vehicle ahead of me.",
        "No vehicle but 301 is ahead of me.",
        "Only 301 is ahead of me, 2.1 m away.",
        "It is wrong that 301 is ahead of me.",
        "I hope 301 is braking.",
        "Were 301 braking, all would be fine.",
        "The ego is followed by 301.",
        "301 is no less than 1 m ahead.",
        "301 is not 20 m ahead of me.",
        "301 is 125 ft ahead of me.",
        "301 is 15 m ± 2 m ahead of me.",
        "301 is 1,250 m away.",
        "The speed of 301 is twice 4.54 m/s.",
        "A second ago 301 was 1.25 m ahead of me.",
        "301 and 999 are ahead of me.",
        "The lead car is honking.",
        "The bicycle 301 is ahead of me.",
        "301 hits my left side.",
    ] {
        let found = outcomes(text);
        let is_open = |one: &SentenceOutcome| {
            matches!(one, SentenceOutcome::NotUnderstood | SentenceOutcome::Open)
        };
        assert!(found.iter().all(is_open), "{text}: {found:?}");
    }
}

#[test]
fn what_somebody_thinks_is_of_whom_it_is_thought() {
    let scene = scene();
    let subject = Subject::new(&scene, TimeOrigin::Recording, Some((35, 44)));
    for text in [
        "I know 301 is braking.",
        "We are sure that 301 is braking.",
        "I observe 301 braking.",
    ] {
        let claims = find(text, &subject);
        let whom: Vec<i64> = claims.iter().map(|claim| claim.obstacle).collect();
        assert_eq!(whom, [301], "{text}");
    }
}

#[test]
fn small_ids_are_whom_a_clause_is_about() {
    let ids = std::collections::BTreeSet::from([7, 39]);
    let world = find::MentionContext {
        subject: None,
        present: 0,
        has_trajectory: false,
        ids: &ids,
        ego: 1,
        dt: 0.1,
        steps: 0..10,
        now: None,
    };
    let whom = |text: &str| -> Vec<i64> {
        let claims = find::claims(text, &world).into_iter();
        claims.map(|claim| claim.obstacle).collect()
    };
    assert_eq!(whom("39 approaches and 7 recedes."), [39, 7]);
    assert_eq!(whom("7 is behind me and 39 is in front of me."), [7, 39]);
    // A number of vehicles is counted of all, as the ego's.
    assert_eq!(whom("7 vehicles are braking."), [world.ego]);
    assert_eq!(whom("39 is closer than 7."), [39]);
}

#[test]
fn trucks_are_counted_apart_and_cars_may_be_all_vehicles() {
    let scene = scene();
    let subject = Subject::new(&scene, TimeOrigin::Recording, Some((35, 44)));
    let of = |text: &str| match find(text, &subject).first().map(|claim| claim.stated) {
        Some(ClaimedValue::Count { number, types, .. }) => Some((number, types)),
        _ => None,
    };
    let trucks = Some((ObstacleType::Truck, ObstacleType::Truck));
    assert_eq!(of("Two trucks are ahead of me."), Some((2, trucks)));
    assert_eq!(of("Two vehicles are ahead of me."), Some((2, None)));
    assert_eq!(of("Two trucks are ahead in my lane."), Some((2, trucks)));
}

#[test]
fn endless_texts_are_read_in_part() {
    let long = "301 is ahead of me and ".repeat(400);
    assert_eq!(outcomes(&long), [SentenceOutcome::NotUnderstood]);
    let many = "Obstacle 301 is ahead of me.\n".repeat(20_000);
    let scene = scene();
    let subject = Subject::new(&scene, TimeOrigin::Recording, Some((35, 44)));
    let found = find(&many, &subject);
    assert!((1000..10_000).contains(&found.len()), "{}", found.len());
}

//! Forms of recorded answers: the ego's own claims, parts under their own headings, formulas, both axes at once.

use super::*;

/// What an obstacle and the ego are at a step of the bundled cut-in.
struct Moment {
    scene: Scene,
    id: i64,
    window: (i64, i64),
}

/// Numbers of that moment, each with what it is called in the texts.
fn moment() -> (Moment, Vec<(&'static str, f64)>) {
    let scene = scene();
    let (id, window) = (301, (35, 44));
    let who = scene.participants().find(|p| p.obstacle.id == id).unwrap();
    let now = Encounter::at(&scene, &who, window.1).unwrap();
    let relation = now.relation();
    let network = &scene.scenario.network;
    let lanelet = |place| network.lanelets_at(place)[0] as f64;
    let facts = vec![
        ("EX", now.ego.pose.position.x),
        ("EY", now.ego.pose.position.y),
        ("OX", now.other.pose.position.x),
        ("OY", now.other.pose.position.y),
        ("EV", now.ego.velocity),
        ("OV", now.other.velocity),
        ("EL", lanelet(&now.ego.pose.position)),
        ("OL", lanelet(&now.other.pose.position)),
        ("GX", relation.gap_long),
        ("GY", relation.gap_lat),
        ("VX", relation.velocity.x),
        ("VY", relation.velocity.y),
    ];
    (Moment { scene, id, window }, facts)
}

impl Moment {
    /// What the sentences of a text come to.
    fn outcomes(&self, text: &str) -> Vec<SentenceOutcome> {
        let subject = Subject::new(&self.scene, TimeOrigin::Recording, Some(self.window));
        let all = sentences(text, &subject).into_iter();
        all.map(|one| one.outcome).collect()
    }

    /// The claims of a text: of whom (0 for the ego), and as what.
    fn claims(&self, text: &str) -> Vec<(i64, Quantity, String)> {
        let subject = Subject::new(&self.scene, TimeOrigin::Recording, Some(self.window));
        let all = checked(text, &subject).into_iter();
        all.map(|one| {
            let of = if one.claim.is_of_ego {
                0
            } else {
                one.claim.obstacle
            };
            (of, one.claim.quantity, one.stated())
        })
        .collect()
    }
}

/// A text with the numbers of a moment in it, those behind "~" moved.
fn filled(text: &str, id: i64, facts: &[(&str, f64)]) -> String {
    let mut text = text.replace("ID", &id.to_string());
    for (name, value) in facts {
        let digits = if name.ends_with('L') { 0 } else { 2 };
        text = text
            .replace(&format!("<-{name}>"), &format!("{:.digits$}", value + 77.0))
            .replace(&format!("<{name}>"), &format!("{value:.digits$}"));
    }
    text
}

#[test]
fn what_is_said_of_the_ego_and_of_both_is_checked() {
    let (moment, facts) = moment();
    for text in [
        "The ego is in lanelet <EL>.",
        "Both the ego and obstacle ID are in lanelet <EL>.",
        "Obstacle ID is at (<OX>, <OY>) and the ego is at (<EX>, <EY>).",
        "Obstacle ID: position (<OX>, <OY>) vs Ego (<EX>, <EY>).",
        "Obstacle ID: speeds ego (<EV> m/s), obstacle (<OV> m/s).",
        "Obstacle ID is at X: <OX>, Y: <OY>.",
        "1. **Ego Vehicle (9)**:\n   - Position: (<EX>, <EY>)",
        "- **Ego Vehicle at 4.4 seconds:**\n  - Velocity: <EV> m/s",
    ] {
        let good = filled(text, moment.id, &facts);
        assert_eq!(moment.outcomes(&good), [SentenceOutcome::Right], "{good}");
        let bad = filled(
            &text.replace("<E", "<-E").replace("<O", "<-O"),
            moment.id,
            &facts,
        );
        assert_eq!(moment.outcomes(&bad), [SentenceOutcome::Wrong], "{bad}");
    }
}

#[test]
fn formulas_and_both_axes_have_several_numbers() {
    let (moment, facts) = moment();
    for (text, count) in [
        (
            "Obstacle ID: longitudinal TTC: 12.00 m / 2.50 m/s = approximately 4.80 seconds",
            4,
        ),
        (
            "Obstacle ID: longitudinal TTC = \\frac{12.00 \\text{ m}}{|2.50 \\text{ m/s}|} \\approx 4.80 \\text{ seconds}",
            4,
        ),
        ("Obstacle ID: TTC: ~4.96 / (1.87 - 0.06) = 2.74 s", 1),
        (
            "Obstacle ID has a longitudinal and lateral distance of 7.00 m.",
            2,
        ),
        ("Obstacle ID has zero longitudinal and lateral distance.", 2),
        (
            "Obstacle ID touches nothing, as indicated by a longitudinal distance of 7.0 meters.",
            1,
        ),
        (
            "Obstacle ID: gap 8.02 m (absolute longitudinal), 1.00 m (lateral).",
            2,
        ),
        ("Obstacle ID: the distance shrinks (~25 m to ~20 m).", 2),
        ("Obstacle ID is braking (2.67 m/s, -5.02 m/s²).", 3),
    ] {
        let text = filled(text, moment.id, &facts);
        let found = moment.claims(&text);
        assert_eq!(found.len(), count, "{text}: {found:?}");
        assert!(
            found.iter().all(|one| one.0 == moment.id),
            "{text}: {found:?}"
        );
    }
    for text in [
        "Obstacle ID: longitudinal distance <GX> m, lateral <GY> m.",
        "Obstacle ID has a longitudinal relative velocity of <VX> m/s with a distance of <GX> m.",
    ] {
        let good = filled(text, moment.id, &facts);
        assert_eq!(moment.outcomes(&good), [SentenceOutcome::Right], "{good}");
        let bad = filled(&text.replace("<G", "<-G"), moment.id, &facts);
        assert_eq!(moment.outcomes(&bad), [SentenceOutcome::Wrong], "{bad}");
    }
}

#[test]
fn parts_of_what_is_about_an_obstacle_have_headings_of_their_own() {
    let (moment, facts) = moment();
    for text in [
        "### Obstacle ID:\n**Trajectory analysis:**\n- The longitudinal distance is <GX> m.\n\nObstacle 302 is there.",
        "### Obstacles\n**Obstacle ID (car):**\n#### Trajectory analysis\n- The longitudinal distance is <GX> m.\n\nObstacle 302 is there.",
        "**Obstacle ID**\n\n**Distances**\n- The longitudinal distance is <GX> m.\n\nObstacle 302 is there.",
        "1. **Obstacle ID:**\n   **Distances:**\n   - The longitudinal distance is <GX> m.\n\nObstacle 302 is there.",
        "### Obstacle ID\n**Overall risk:**\n- The longitudinal distance is <GX> m.\n\nObstacle 302 is there.",
        "### Analysis for 3.5s - 4.4s\nObstacle ID has a longitudinal distance of <GX> m.\n\nObstacle 302 is there.",
        "### Obstacle ID\n- The ego brakes. The longitudinal distance of the obstacle is <GX> m.\n\nObstacle 302 is there.",
    ] {
        let good = filled(text, moment.id, &facts);
        let found = moment.claims(&good);
        let is_found = |of: i64| {
            found
                .iter()
                .any(|one| one.0 == of && one.1 == Quantity::GapLong)
        };
        assert!(is_found(moment.id), "{good}: {found:?}");
    }
    for text in [
        "### Obstacle ID\n### Obstacle 302\n### Summary\n- The longitudinal distance is <GX> m.",
        "**Obstacle ID**\n- it is there\n**Obstacle 302**\n- it is there\n**Distances**\n- The longitudinal distance is <GX> m.",
        "### Analysis for 1.0s - 2.0s\nObstacle ID has a longitudinal distance of <GX> m.",
    ] {
        let text = filled(text, moment.id, &facts);
        let found = moment.claims(&text);
        assert!(
            found.iter().all(|one| one.1 != Quantity::GapLong),
            "{text}: {found:?}"
        );
    }
}

#[test]
fn both_obstacles_are_the_two_that_a_text_names() {
    let (moment, _) = moment();
    let whom =
        |text: &str| -> Vec<i64> { moment.claims(text).into_iter().map(|one| one.0).collect() };
    let two = "Obstacle 301 and obstacle 302 are there. Both obstacles are approaching the ego.";
    assert_eq!(whom(two), [301, 302]);
    assert_eq!(whom(&format!("Obstacle 303 waits. {two}")), [] as [i64; 0]);
    let faster = moment.claims("Obstacle 301 is there. The ego is faster.");
    assert_eq!(faster.len(), 1, "{faster:?}");
    assert_eq!((faster[0].0, faster[0].1), (0, Quantity::Comparison));
}

#[test]
fn a_denied_approach_is_one_along_its_axis() {
    let (moment, _) = moment();
    let stated = |text: &str| -> Vec<String> {
        moment
            .claims(&format!("Obstacle 301: {text}"))
            .into_iter()
            .map(|one| one.2)
            .collect()
    };
    assert_eq!(
        stated("no closing trend laterally"),
        ["not approaching laterally"]
    );
    assert_eq!(
        stated("there is no lateral closing velocity"),
        ["not approaching laterally"]
    );
    assert_eq!(stated("the ego is closing the gap"), ["approaching"]);
    assert_eq!(
        stated("longitudinal -3.00 m/s, lateral -2.00 m/s (both approaching)")[2..],
        ["approaching longitudinally", "approaching laterally"]
    );
    assert_eq!(
        stated("it is moving parallel to the ego"),
        ["parallel to the ego"]
    );
    assert_eq!(stated("a closing trend is possible"), [] as [&str; 0]);
}

#[test]
fn numbers_of_several_stand_in_their_order() {
    let (moment, _) = moment();
    let whom = |text: &str| -> Vec<(i64, String)> {
        let all = moment.claims(text).into_iter();
        all.map(|one| (one.0, one.2)).collect()
    };
    assert_eq!(
        whom("Obstacles 301 and 302 are 25 m and 15 m away."),
        [(301, "25 m".into()), (302, "15 m".into())]
    );
    assert_eq!(
        whom(
            "Obstacle 301 has longitudinal and lateral velocities of -1.41 m/s and -7.64 m/s respectively."
        ),
        [(301, "-1.41 m/s".into()), (301, "-7.64 m/s".into())]
    );
    assert_eq!(
        whom("Obstacle 301 is 3 m, 4 m and 5 m away, respectively."),
        []
    );
}

#[test]
fn what_is_said_of_changes_and_courses_is_no_more_than_that() {
    let (moment, facts) = moment();
    let stated = |text: &str| -> Vec<String> {
        let text = filled(&format!("Obstacle ID: {text}"), moment.id, &facts);
        moment.claims(&text).into_iter().map(|one| one.2).collect()
    };
    assert_eq!(
        stated("it is decelerating faster than the ego"),
        ["braking"]
    );
    assert_eq!(stated("the ego is braking faster than it"), ["braking"]);
    assert_eq!(
        stated("its velocity is not indicating a collision course"),
        ["no contact to come"]
    );
    assert_eq!(
        stated("relative velocity: ego velocity is 3.00 m/s, obstacle velocity is 4.00 m/s"),
        ["3.00 m/s", "4.00 m/s"]
    );
    assert_eq!(
        stated("a lateral gap of 2.00 m to the right"),
        ["-2.00 m", "right"]
    );
    assert_eq!(stated("it has a lane change possibility"), [] as [&str; 0]);
    assert_eq!(stated("the closing speed accelerates"), [] as [&str; 0]);
    assert_eq!(
        stated("it followed a trajectory away from the ego"),
        [] as [&str; 0]
    );
    assert_eq!(
        stated("lateral distance 2.00 m but moving away")[1..],
        ["moving away laterally"]
    );
    assert_eq!(
        stated("the distance (2.00 m laterally) is increasing"),
        ["moving away", "2.00 m"]
    );
    assert_eq!(
        stated("exact alignment in both dimensions"),
        ["0.0 m", "0.0 m"]
    );
    assert_eq!(
        stated("it is moving towards us but away laterally")[1..],
        ["moving away laterally"]
    );
    assert_eq!(stated("it is 3.00 m away laterally"), ["3.00 m"]);
    assert_eq!(
        stated("it has a lower velocity than the ego"),
        ["slower than the ego"]
    );
    assert_eq!(stated("its velocity exceeds that of all"), [] as [&str; 0]);
    assert_eq!(
        stated("we see a steady decrease in the longitudinal distance"),
        ["approaching longitudinally"]
    );
    assert_eq!(stated("distance safety score: 5.0"), ["5 of distance"]);
    assert_eq!(
        stated("the ego and the obstacle share the same lanelet (301)").len(),
        1
    );
    assert_eq!(stated("it is not closing fast enough"), [] as [&str; 0]);
    assert_eq!(stated("there is no significant approach"), [] as [&str; 0]);
    assert_eq!(stated("it is moving left (3.00 m/s)")[..1], ["3.00 m/s"]);
    assert_eq!(
        stated("the minimum distance is the lateral distance (3.00 m)"),
        ["3.00 m"]
    );
    assert_eq!(
        stated("laterally it is approaching (distance decreasing from 0.00 m to -0.16 m)"),
        ["approaching laterally", "0.00 to -0.16 m"]
    );
    let counted = moment
        .claims("1. **Obstacle 1 (301.0)**:\n   - Speed: 28.46 m/s\n2. **Obstacle 2 (302)**:");
    assert_eq!((counted[0].0, counted.len()), (301, 1));
    let likened = moment.claims("Obstacle 301: its velocity is similar to the ego (33.40 m/s).");
    assert_eq!((likened[0].0, likened.len()), (0, 1));
    // At the end it is ahead, and was so at all steps or not.
    let of = |text: &str| moment.outcomes(&filled(text, moment.id, &facts));
    assert_eq!(of("Obstacle ID moves throughout the window."), []);
    assert_eq!(
        of("Obstacle ID is ahead of the ego throughout the window."),
        [SentenceOutcome::Right]
    );
    assert_eq!(
        of("Obstacle ID is behind the ego throughout the window."),
        [SentenceOutcome::Wrong]
    );
}

#[test]
fn tables_and_brackets_tell_whose_a_number_is() {
    let (moment, _) = moment();
    let whom = |text: &str| -> Vec<(i64, String)> {
        let all = moment.claims(text).into_iter();
        all.map(|one| (one.0, one.2)).collect()
    };
    let both: [(i64, String); 2] = [(301, "2.1 m".into()), (302, "6.1 m".into())];
    for text in [
        "- Gap: 2.1 m (301), 6.1 m (302)",
        "| Measure | 301 | 302 |\n|---|---|---|\n| Distance | 2.1 m | 6.1 m |",
        "| Obstacle | Distance (m) |\n|---|---|\n| 301 | 2.1 |\n| 302 | 6.1 |",
        "obstacle_id,distance_m\n301,2.1\n302,6.1",
        "{\"all\": [{\"id\": 301, \"distance\": 2.1}, {\"id\": 302, \"distance\": 6.1}]}",
    ] {
        assert_eq!(whom(text), both, "{text}");
    }
    assert_eq!(whom("301, 2.1, 302 and so on"), []);
}

#[test]
fn whom_a_sentence_behind_one_about_the_ego_is_about() {
    let (moment, _) = moment();
    let whom = |text: &str| -> Vec<i64> {
        let all = moment.claims(&format!("{text}\n\nObstacle 302 is there."));
        all.into_iter().map(|one| one.0).collect()
    };
    for (text, wanted) in [
        (
            "### Obstacle 301\n- It is risky as the ego is braking and the obstacle is braking.",
            [0, 301],
        ),
        (
            "### Obstacle 301\n- The ego is braking. The distance between them is shrinking.",
            [0, 301],
        ),
        (
            "### Obstacle 301\n- The ego is braking, while the obstacle is accelerating.",
            [0, 301],
        ),
    ] {
        assert_eq!(whom(text), wanted, "{text}");
    }
    // What something is compared with is not what goes on.
    assert_eq!(
        whom("Obstacle 301 is faster than the ego (30.00 m/s) and is braking."),
        [301, 301]
    );
    assert_eq!(
        whom("### Ego vehicle analysis\n- The velocity of the ego vehicle is 3.00 m/s."),
        [0]
    );
    assert_eq!(
        whom("#### Ego vehicle\n- It turns.\n- Speed: 3.00 m/s"),
        [0]
    );
    // "It" may be the ego.
    assert_eq!(
        whom("### Obstacle 301\n- The ego is braking. It is accelerating."),
        [0]
    );
}

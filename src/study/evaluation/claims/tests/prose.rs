//! Prose of other styles than recorded answers: whom it is about, over which steps, and how much; each form true and false.

use super::*;

/// What a text about a bundled scenario comes to, as a whole and claim by claim.
fn judged(name: &str, window: (i64, i64), text: &str) -> Vec<(Option<i64>, Judgement)> {
    let all = bundled();
    let entry = all.iter().find(|e| e.name.contains(name)).unwrap();
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
    let scene = Scene::new(scenario, ego);
    let subject = Subject::new(&scene, TimeOrigin::Recording, Some(window));
    let claims = checked(text, &subject).into_iter();
    let own = claims.filter(|one| !one.claim.is_described);
    own.map(|one| {
        (
            Some(one.claim.obstacle).filter(|_| !one.claim.is_of_ego),
            one.judgement,
        )
    })
    .collect()
}

/// Holds pairs of a true and a false sentence: of the true one all is right, and in the false one something is wrong.
fn hold(name: &str, window: (i64, i64), pairs: &[(&str, &str)]) {
    for (good, bad) in pairs {
        let found = judged(name, window, good);
        let is_right = !found.is_empty() && found.iter().all(|one| one.1 == Judgement::Right);
        assert!(is_right, "{good}: {found:?}");
        let found = judged(name, window, bad);
        let is_wrong = found.iter().any(|one| one.1 == Judgement::Wrong);
        assert!(is_wrong, "{bad}: {found:?}");
    }
}

#[test]
fn a_whole_window_its_extremes_and_their_moments() {
    hold(
        "CutIn",
        (34, 60),
        &[
            (
                "Throughout the window, 307 stays behind me.",
                "Throughout the window, 307 is ahead of me.",
            ),
            ("307 is never ahead of me.", "301 is never ahead of me."),
            (
                "The minimum distance to 301 was 0.36 m, reached at 5.1 s.",
                "The minimum distance to 301 was 0.36 m, reached at 3.5 s.",
            ),
            (
                "The peak deceleration of the ego was 7.2 m/s².",
                "The peak deceleration of the ego was 3.1 m/s².",
            ),
            (
                "During the whole window the ego's speed stayed above 15 m/s.",
                "During the whole window the ego's speed stayed above 32 m/s.",
            ),
            (
                "The distance to 307 never fell below 30 m.",
                "The distance to 301 never fell below 9 m.",
            ),
        ],
    );
}

#[test]
fn asides_participles_and_lists_are_of_whom_they_stand_behind() {
    hold(
        "CutIn",
        (34, 44),
        &[
            (
                "I brake for 301, which is ahead of me, and 304, which is on my left.",
                "I brake for 301, which is behind me, and 304, which is on my left.",
            ),
            (
                "Braking at 6 m/s², the ego is 2.1 m behind 301.",
                "Braking at 2 m/s², the ego is 2.1 m behind 301.",
            ),
            (
                "There is a car 2.1 m ahead of us.",
                "The lead car is 9.1 m ahead of us.",
            ),
            ("304 keeps its lane.", "301 keeps its lane."),
            (
                "301 is the second closest vehicle.",
                "301 is the third closest vehicle.",
            ),
            ("The ego brakes hard.", "The ego accelerates gently."),
            ("302 is farther away than 301.", "307 is closer than 301."),
            (
                "Ten vehicles are around the ego.",
                "Nine vehicles are around the ego.",
            ),
            ("Nothing is within 1 m.", "Nothing is within 10 m."),
            ("Two vehicles are within 10 m.", "The left lane is free."),
            (
                "301 is slower than us by 5.1 m/s.",
                "301 is slower than us by 9 m/s.",
            ),
            (
                "301 is about two metres ahead.",
                "301 is just under 20 m ahead.",
            ),
        ],
    );
    hold(
        "HardBraking",
        (40, 50),
        &[
            (
                "301 is 7.8 m/s slower than us.",
                "301 is 7.8 m/s faster than us.",
            ),
            (
                "The gap to 301 fell from 10.3 m at 4.6 s to 7.8 m at 5.0 s.",
                "The gap to 301 fell from 10.3 m at 4.2 s to 7.8 m at 5.0 s.",
            ),
            (
                "301 and 302 are ahead, both braking.",
                "301 and 304 are here, both braking.",
            ),
            (
                "The ego drives at 22.8 m/s, and 301, which is braking, is ahead.",
                "301 is braking, and so am I.",
            ),
            (
                "The follower 304 is falling back.",
                "The leader 301 is accelerating away from us.",
            ),
            (
                "306 (oncoming) came the other way.",
                "301 is coming the other way.",
            ),
        ],
    );
    hold(
        "CutIn",
        (34, 44),
        &[
            ("304 (left lane): 2.02 m to the left.", "304 (right lane)."),
            (
                "304 has a lateral gap of 2.0 m to the left.",
                "304 has a lateral gap of 2.0 m to the right.",
            ),
            (
                "The car that just cut in is 2.1 m ahead.",
                "301 did not cut in.",
            ),
        ],
    );
    // Of whom these are is not told.
    for text in [
        "The vehicle behind 358 is 1.25 m away.",
        "The car behind 301 is 2 m away.",
        "301 is ahead of 307. It is braking.",
    ] {
        let of = judged("CutIn", (34, 44), text);
        let is_open = of.iter().all(|one| matches!(one.1, Judgement::Unknown(_)));
        assert!(is_open, "{text}: {of:?}");
    }
}

#[test]
fn times_to_contact_and_what_happened_when() {
    hold(
        "HardBraking",
        (40, 50),
        &[
            ("Contact with 301 in 1.0 s.", "Contact with 301 in 5 s."),
            (
                "We will hit the car ahead in about a second.",
                "We will hit the car ahead in about five seconds.",
            ),
            (
                "Car 306 passed the ego at 4.7 s.",
                "Car 306 passed the ego at 2.0 s.",
            ),
            (
                "The gap to 301 shrank to 7.8 m while I drive at a steady 22.8 m/s.",
                "The gap to 301 shrank to 3 m while I drive at a steady 22.8 m/s.",
            ),
        ],
    );
}

#[test]
fn lists_conditions_and_superlatives_of_some() {
    hold(
        "HardBraking",
        (40, 50),
        &[
            (
                "301 and the ego are less than 9 m apart.",
                "301 and the ego are less than 5 m apart.",
            ),
            (
                "A collision with 301 did not occur.",
                "A collision with 301 will occur in 4 s.",
            ),
            (
                "If I had braked, all would be well, but 301, which is less than 8 m ahead, brakes.",
                "If I had braked, all would be well with 301, which is less than 3 m ahead.",
            ),
            (
                "While the ego does not brake, the gap to 301 keeps shrinking.",
                "While the ego does not brake, the gap to 301 keeps growing.",
            ),
            (
                "306, 8.8 m behind, is oncoming.",
                "306, 3.8 m behind, is oncoming.",
            ),
        ],
    );
    // Of those nearby is not all, and the nearest is no least distance.
    for text in [
        "304 is the slowest of the cars near us.",
        "The fastest nearby is 301.",
    ] {
        assert!(judged("HardBraking", (40, 50), text).is_empty(), "{text}");
    }
}

#[test]
fn differences_are_of_those_that_are_compared() {
    hold(
        "CutIn",
        (34, 44),
        &[
            (
                "The ego is 5.1 m/s faster than 301.",
                "The ego is 5.1 m/s slower than 301.",
            ),
            (
                "At its closest, 301 was 2.1 m away.",
                "At its closest, 301 was 6 m away.",
            ),
            ("301 was 9 m away at most.", "301 was 1 m away at most."),
            (
                "The minimum distance to 301 is reached at 4.4 s.",
                "The minimum distance to 301 is reached at 3.5 s.",
            ),
        ],
    );
    for text in [
        "301 is faster than 302 by 3 m/s.",
        "There is no car 10 m ahead.",
        "301 has not always been in my lane.",
        "301 slows us down.",
        "The left lane is free of ice.",
        "One car is ahead.",
    ] {
        let of = judged("CutIn", (34, 44), text);
        let is_wrong = of.iter().any(|one| one.1 == Judgement::Wrong);
        assert!(!is_wrong, "{text}: {of:?}");
    }
}

#[test]
fn who_is_named_again_and_what_is_now() {
    hold(
        "HardBraking",
        (40, 50),
        &[
            (
                "The distance to 301 is 7.8 m, and 301 is braking.",
                "The distance to 301 is 7.8 m, and 301 is accelerating.",
            ),
            (
                "306 passed at 4.7 s and is now 8.8 m behind.",
                "306 passed at 4.7 s and is now 3 m behind.",
            ),
            (
                "301 is closing at 7.8 m/s relative to us, while 304, at 22 m/s, is behind.",
                "301 is closing at 7.8 m/s relative to us, while 304, at 15 m/s, is behind.",
            ),
            ("The ego kept its speed.", "301 kept its speed."),
            (
                "301 is near, and we close at 7.8 m/s.",
                "301 is near, and we close at 3 m/s.",
            ),
        ],
    );
}

#[test]
fn another_one_than_the_sentence_before_is_meant() {
    let of = judged(
        "CutIn",
        (30, 40),
        "Car 301 is 4.6 m ahead. No collision will occur with 304.",
    );
    assert!(of.iter().any(|one| one.0 == Some(304)), "{of:?}");
}

#[test]
fn numbers_in_words_and_times_ago() {
    hold(
        "RedLight",
        (40, 50),
        &[
            (
                "301 is about sixteen and a half metres away.",
                "301 is about forty-five metres away.",
            ),
            (
                "0.5 s ago, 301 was 26.6 m away.",
                "0.5 s ago, 301 was 50.0 m away.",
            ),
            (
                "The time to collision with 301 is 0.8 s.",
                "The time to collision with 301 is 2.8 s.",
            ),
        ],
    );
}

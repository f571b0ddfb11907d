//! Corrected ratings, and ratings still being stored while others are made.

use super::bench::Bench;
use super::side_by_side::{sized, two};
use crate::features::compare::rating::Rate;
use crate::message::Msg;
use nearmiss_store::Choice;

/// What was sent to the store: what was chosen, how many answers were marked, and which rating that replaces.
fn sent(bench: &Bench) -> Vec<(Choice, usize, Option<i64>)> {
    let effects = bench.effects.iter();
    let rated = effects.filter_map(|effect| match effect.request() {
        Some(Rate {
            rating, replaced, ..
        }) => {
            let marked = rating.answers.iter().filter(|answer| answer.wrong).count();
            Some((rating.choice, marked, *replaced))
        }
        _ => None,
    });
    rated.collect()
}

#[test]
fn answers_are_rated_anew_while_they_stand_there() {
    for open in ["space o c", "space o b"] {
        let mut bench = sized(two(), 120, 40);
        bench.press(open);
        let round = bench.model.compare.round;
        bench.press("1");
        bench.send(Msg::reply::<Rate>((round, Ok(4))));
        bench.press("2");
        bench.send(Msg::reply::<Rate>((round, Ok(4))));
        assert!(bench.frame(120, 40).contains("rating 4 changed"), "{open}");
        bench.press("w enter");
        bench.send(Msg::reply::<Rate>((round, Ok(4))));
        bench.press("w");
        let (best, again) = (Choice::Best, Some(4));
        let anew = [
            (best(1), 0, again),
            (best(1), 1, again),
            (best(1), 0, again),
        ];
        let all = [&[(best(0), 0, None)][..], &anew].concat();
        assert_eq!(sent(&bench), all, "{open}");
        // The last one is refused: what is in the store is what is shown.
        bench.send(Msg::reply::<Rate>((
            round,
            Err("the store is locked".into()),
        )));
        bench.press("t");
        bench.send(Msg::reply::<Rate>((
            round,
            Err("the store is locked".into()),
        )));
        assert_eq!(bench.model.compare.choice, Some(best(1)), "{open}");
    }
}

#[test]
fn a_rating_waits_for_the_one_before_it_and_other_answers_have_their_own() {
    let mut bench = sized(two(), 120, 40);
    bench.press("space o c");
    let round = bench.model.compare.round;
    bench.press("1 2 t");
    assert_eq!(sent(&bench), [(Choice::Best(0), 0, None)]);
    // Meanwhile other answers stand there; nothing was made of them yet.
    bench.press("esc space o c");
    bench.send(Msg::reply::<Rate>((round, Ok(4))));
    assert_eq!(sent(&bench)[1..], [(Choice::Tie, 0, Some(4))]);
    bench.send(Msg::reply::<Rate>((round, Ok(4))));
    assert_eq!(bench.model.compare.choice, None);
    bench.press("0");
    assert_eq!(sent(&bench)[2..], [(Choice::AllWrong, 0, None)]);
    bench.send(Msg::reply::<Rate>((
        bench.model.compare.round,
        Err("the store is locked".into()),
    )));
    assert_eq!(bench.model.compare.choice, None);
}

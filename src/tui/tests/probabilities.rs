//! Probabilities of verdicts, in the verdict pane and side by side.

use super::answers::asking;
use super::bench::{Bench, answer};
use super::events;
use nearmiss_scene::verdict::CriticalObstacle;
use nearmiss_study::evaluation::JudgeOutcome;

/// An answer that states probabilities, and has one by its tokens if there is one.
fn given(bench: &mut Bench, tokens: Option<f64>) {
    let (id, _) = bench.asked();
    let mut given = answer("lab/small", true, 301);
    if let JudgeOutcome::Verdict(parsed) = &mut given.judged {
        parsed.verdict.probability = Some(0.83);
        parsed.verdict.token_probability = tokens;
        parsed.verdict.critical = Some(vec![
            CriticalObstacle {
                id: 301,
                probability: Some(0.8),
            },
            CriticalObstacle::new(302),
        ]);
    }
    bench.send(events::answered(id, Ok(Box::new(given))));
}

#[test]
fn stated_probabilities_and_those_by_tokens_are_shown_at_80_by_24_too() {
    let mut bench = asking();
    given(&mut bench, Some(0.97));
    let frame = bench.frame(200, 60);
    for words in [
        "P(yes)    0.83",
        "by tokens 0.97",
        "critical: 301 (0.80), 302",
    ] {
        assert!(frame.contains(words), "{words}\n{frame}");
    }
    let small = bench.frame(80, 24);
    assert!(small.contains("P(yes)    0.83"), "{small}");
}

#[test]
fn without_log_probabilities_there_is_no_row_for_them() {
    let mut bench = asking();
    given(&mut bench, None);
    let frame = bench.frame(200, 60);
    assert!(
        frame.contains("P(yes)    0.83") && !frame.contains("by tokens"),
        "{frame}"
    );
}

//! The reasoning pane: its contents above the answer, and without one.

use super::answers::asking;
use super::bench::{Bench, answer, no_verdict};
use super::events;
use crate::evaluation::{Event, JudgeOutcome, MissingVerdict};
use crate::llm::Chunk;
use crate::store::RunId;

const DIVIDER: &str = "── answer ──";

/// The lines of the pane, from its title on.
fn pane(bench: &Bench) -> Vec<String> {
    let frame = bench.frame(120, 40);
    let lines = frame
        .lines()
        .skip_while(|line| !line.contains("reasoning ·"));
    lines.map(str::to_string).collect()
}

fn place(lines: &[String], words: &str) -> Option<usize> {
    lines.iter().position(|line| line.contains(words))
}

#[test]
fn a_line_divides_the_reasoning_from_the_answer() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.send(events::piece(
        id,
        Event::Chunk(Chunk::Reasoning("thinking hard".into())),
    ));
    bench.send(events::piece(
        id,
        Event::Chunk(Chunk::Text("so it is".into())),
    ));
    let lines = pane(&bench);
    let at = |words| place(&lines, words).unwrap_or_else(|| panic!("{words}: {lines:#?}"));
    assert_eq!(at("thinking hard"), at("── reasoning ──") + 1, "{lines:#?}");
    assert_eq!(at(DIVIDER), at("thinking hard") + 2, "{lines:#?}");
    assert_eq!(at("so it is"), at(DIVIDER) + 1, "{lines:#?}");
    bench.send(events::answered(
        id,
        Ok(Box::new(answer("lab/small", true, 301))),
    ));
    let lines = pane(&bench);
    assert!(
        place(&lines, DIVIDER) < place(&lines, "the answer"),
        "{lines:#?}"
    );
}

#[test]
fn an_answer_without_reasoning_needs_no_line() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.send(events::piece(
        id,
        Event::Chunk(Chunk::Text("so it is".into())),
    ));
    let lines = pane(&bench);
    assert!(place(&lines, "so it is").is_some(), "{lines:#?}");
    assert_eq!(place(&lines, DIVIDER), None, "{lines:#?}");
}

#[test]
fn what_is_waited_for_is_said_until_something_comes() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    let on_its_way = "the question is on its way…";
    assert!(place(&pane(&bench), "waiting 0 s").is_some());
    assert!(place(&pane(&bench), on_its_way).is_some());
    bench.send(events::piece(id, Event::Awaiting(RunId(7))));
    let lines = pane(&bench);
    assert!(place(&lines, "run 7 asks the same").is_some(), "{lines:#?}");
    assert_eq!(place(&lines, on_its_way), None, "{lines:#?}");
    bench.send(events::piece(
        id,
        Event::Chunk(Chunk::Text("so it is".into())),
    ));
    let lines = pane(&bench);
    assert_eq!(place(&lines, "being asked as run 7"), None, "{lines:#?}");
}

#[test]
fn what_never_left_this_machine_is_called_so_with_the_reason() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    let refused = "nothing was sent: a key is needed: set LAB_KEY";
    bench.send(events::answered(id, Err(refused.into())));
    let lines = pane(&bench);
    assert!(lines[0].contains("not sent"), "{lines:#?}");
    assert!(
        place(&lines, "nothing was sent: a key").is_some(),
        "{lines:#?}"
    );
    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.send(events::piece(id, Event::Kept(RunId(1))));
    let mut unsent = no_verdict("lab/small", "");
    unsent.reasoning.clear();
    unsent.judged = JudgeOutcome::Missing(MissingVerdict::NotSent("cannot reach lab".into()));
    bench.send(events::answered(id, Ok(Box::new(unsent))));
    let frame = bench.frame(120, 40);
    assert!(
        frame.contains("nothing was sent: cannot reach lab"),
        "{frame}"
    );
    assert!(
        frame.contains("not sent") && !frame.contains("no answer"),
        "{frame}"
    );
}

#[test]
fn the_text_goes_to_the_claim_that_is_picked() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    let first = "The gap to obstacle 301 is 9 m.";
    let filler = "Nothing else matters here.\n\n".repeat(60);
    let last = "At step 59 the gap to obstacle 301 is 7 m.";
    let text = format!("{first}\n\n{filler}{last}\n\n{filler}");
    bench.send(events::answered(
        id,
        Ok(Box::new(no_verdict("lab/a", &text))),
    ));
    pane(&bench);
    for (words, keys) in [(first, ")"), (last, ")"), (first, "("), (last, "(")] {
        bench.press(keys);
        let lines = pane(&bench);
        let seen = place(&lines, &words[..20]).is_some();
        assert!(seen, "{words}: {lines:#?}");
    }
}

//! Asking, streaming, comparing, cancelling.

use super::bench::{Bench, answer, no_verdict};
use crate::evaluation::Event;
use crate::tui::message::{Effect, Msg};
use crate::tui::model::{Pane, Progress, Shown};

/// The model `lab/small` is asked.
fn asking() -> Bench {
    let mut bench = Bench::bundled();
    bench.press("m");
    bench.type_text("lab");
    bench.press("enter r");
    bench
}

#[test]
fn r_asks_the_chosen_model_and_the_answer_arrives_piece_by_piece() {
    let mut bench = asking();
    let (id, model) = bench.asked();
    assert_eq!(model, "lab/small");
    bench.send(Msg::Asked(id, Event::Reasoning("thinking hard".into())));
    assert!(bench.frame(120, 40).contains("thinking hard"));
    bench.send(Msg::Asked(id, Event::Text("so: ".into())));
    assert!(bench.frame(120, 40).contains("arriving"));
    bench.send(Msg::Answered(
        id,
        Ok(Box::new(answer("lab/small", false, 302))),
    ));
    let frame = bench.frame(120, 40);
    assert!(frame.contains("no ≠"), "{frame}");
    assert!(
        frame.contains("lab/small says so")
            && frame.contains("2,000+100")
            && frame.contains("6.1 s")
    );
}

#[test]
fn c_asks_a_second_model_beside_the_first() {
    let mut bench = asking();
    let (first, _) = bench.asked();
    bench.send(Msg::Answered(
        first,
        Ok(Box::new(answer("lab/small", true, 301))),
    ));
    bench.press("c");
    bench.type_text("lab/other");
    bench.press("enter");
    let (second, model) = bench.asked();
    assert_eq!(model, "lab/other", "any model can be typed");
    bench.send(Msg::Answered(
        second,
        Ok(Box::new(answer("lab/other", false, 303))),
    ));
    let frame = bench.frame(120, 40);
    assert!(
        frame.contains("yes =") && frame.contains("no ≠") && frame.contains("built in"),
        "{frame}"
    );
    assert_eq!(bench.model.answers.shown, Shown::Column(1));
    bench.press("[");
    assert_eq!(bench.model.answers.shown, Shown::Column(0));
    bench.press("[");
    assert_eq!(bench.model.answers.shown, Shown::Reference);
    bench.press("] d");
    assert_eq!(bench.model.answers.columns.len(), 1);
}

#[test]
fn an_answer_without_a_verdict_is_a_state_of_its_own() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.send(Msg::Asked(id, Event::Text("I cannot tell.".into())));
    bench.send(Msg::Answered(
        id,
        Ok(Box::new(no_verdict("lab/small", "I cannot tell."))),
    ));
    bench.press("esc");
    let frame = bench.frame(120, 40);
    assert!(
        frame.contains("no verdict") && frame.contains("I cannot tell."),
        "{frame}"
    );
}

#[test]
fn ctrl_c_cancels_first_and_quits_second() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.press("ctrl-c");
    assert!(matches!(bench.effects.last(), Some(Effect::Abort(aborted)) if *aborted == id));
    assert!(matches!(
        bench.model.answers.columns[0].progress,
        Progress::Broken(_)
    ));
    bench.press("ctrl-c");
    assert!(matches!(bench.effects.last(), Some(Effect::Quit)));
}

#[test]
fn streaming_does_not_steal_the_position() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    let text: String = (0..80).map(|i| format!("line {i}\n\n")).collect();
    bench.send(Msg::Asked(id, Event::Text(text)));
    assert!(
        bench.frame(120, 40).contains("line 79"),
        "the end is followed"
    );
    bench.model.focus = Pane::Reasoning;
    bench.press("pageup pageup");
    bench.frame(120, 40);
    let before = bench.model.answers.scroll;
    bench.send(Msg::Asked(id, Event::Text("new text\n".repeat(30))));
    let frame = bench.frame(120, 40);
    assert_eq!(bench.model.answers.scroll, before);
    assert!(
        frame.contains("new lines below") && !frame.contains("new text"),
        "{frame}"
    );
    bench.press("shift-g");
    assert!(bench.frame(120, 40).contains("new text"));
}

#[test]
fn control_characters_of_an_answer_are_shown_and_not_obeyed() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.send(Msg::Asked(id, Event::Text("a\u{1b}[2Jb\u{7}".into())));
    bench.send(Msg::Answered(id, Err("bad\u{1b}]0;title\u{7}".into())));
    let frame = bench.frame(120, 40);
    assert!(!frame.contains('\u{1b}') && !frame.contains('\u{7}'));
    assert!(frame.contains("a␛[2Jb␇"), "{frame}");
}

#[test]
fn the_built_in_judge_can_be_asked_and_is_kept() {
    let mut bench = Bench::bundled();
    bench.press("r");
    let (id, model) = bench.asked();
    assert_eq!(model, crate::judge::MODEL);
    assert!(bench.model.answers.columns.is_empty());
    bench.send(Msg::Answered(
        id,
        Ok(Box::new(answer(crate::judge::MODEL, true, 301))),
    ));
    assert!(
        bench
            .model
            .toasts
            .last()
            .unwrap()
            .text
            .contains("collision")
    );
}

#[test]
fn another_scenario_cancels_and_clears() {
    let mut bench = asking();
    bench.press("down");
    assert!(bench.effects.iter().any(|e| matches!(e, Effect::Abort(_))));
    assert!(bench.model.answers.columns.is_empty());
}

#[test]
fn stored_answers_come_back_with_their_scenario() {
    let mut bench = Bench::bundled();
    let (hash, task) = bench
        .effects
        .iter()
        .find_map(|e| match e {
            Effect::LoadStored(hash, task) => Some((hash.clone(), *task)),
            _ => None,
        })
        .unwrap();
    bench.send(Msg::Stored(
        "another".into(),
        task,
        vec![answer("lab/x", true, 301)],
    ));
    assert!(
        bench.model.answers.columns.is_empty(),
        "of another scenario"
    );
    bench.send(Msg::Stored(
        hash,
        task,
        vec![answer("lab/x", true, 301), answer("lab/x", false, 1)],
    ));
    assert_eq!(
        bench.model.answers.columns.len(),
        1,
        "the newest of each model"
    );
    assert!(bench.frame(120, 40).contains("yes ="));
}

#[test]
fn retries_are_said() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    let wait = std::time::Duration::from_secs(7);
    bench.send(Msg::Asked(
        id,
        Event::Retrying {
            attempt: 2,
            wait,
            why: "429".into(),
        },
    ));
    let frame = bench.frame(120, 40);
    assert!(
        frame.contains("trying again") && frame.contains("try 2 in 7 s"),
        "{frame}"
    );
}

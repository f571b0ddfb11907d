//! The reasoning pane: its contents above the answer, and without one.

use crate::tests::answers::asking;
use crate::tests::bench::{self, Bench, answer, no_verdict};
use crate::tests::side_by_side::sized;
use nearmiss_ask::llm::{Chunk, ToolCall, ToolRound, ToolTurn};
use nearmiss_store::RunId;
use nearmiss_study::evaluation::{Event, JudgeOutcome, MissingVerdict};

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
    bench.send(bench::piece(
        id,
        Event::Chunk(Chunk::Reasoning("thinking hard".into())),
    ));
    bench.send(bench::piece(
        id,
        Event::Chunk(Chunk::Text("so it is".into())),
    ));
    let lines = pane(&bench);
    let at = |words| place(&lines, words).unwrap_or_else(|| panic!("{words}: {lines:#?}"));
    assert_eq!(at("thinking hard"), at("── reasoning ──") + 1, "{lines:#?}");
    assert_eq!(at(DIVIDER), at("thinking hard") + 2, "{lines:#?}");
    assert_eq!(at("so it is"), at(DIVIDER) + 1, "{lines:#?}");
    bench.send(bench::answered(
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
fn tool_calls_are_a_line_above_the_reasoning_until_they_are_unfolded() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    let call = |id: &str, arguments: &str| ToolCall {
        id: id.into(),
        name: "distance".into(),
        arguments: arguments.into(),
    };
    let turn = ToolTurn {
        calls: vec![call("a", r#"{"obstacle":301}"#), call("b", "{\u{1b}")],
        ..ToolTurn::default()
    };
    let results = vec![
        r#"{"distance":2.5}"#.into(),
        r#"{"error":"no JSON"}"#.into(),
    ];
    let round = ToolRound { turn, results };
    bench.send(bench::piece(id, Event::Tools(Box::new(round))));
    bench.send(bench::piece(
        id,
        Event::Chunk(Chunk::Reasoning("thinking hard".into())),
    ));
    let lines = pane(&bench);
    let at = |lines: &[String], words| {
        place(lines, words).unwrap_or_else(|| panic!("{words}: {lines:#?}"))
    };
    assert!(at(&lines, "▸ 2 tool calls") < at(&lines, "thinking hard"));
    assert_eq!(place(&lines, "distance {"), None, "{lines:#?}");
    bench.model.reading.unfold = true;
    let lines = pane(&bench);
    assert!(at(&lines, "▾ 2 tool calls") < at(&lines, "distance {"));
    assert!(
        !lines.iter().any(|line| line.contains('\u{1b}')),
        "{lines:#?}"
    );
}

#[test]
fn an_answer_without_reasoning_needs_no_line() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.send(bench::piece(
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
    let on_its_way = "question sent, waiting for the answer…";
    assert!(place(&pane(&bench), "waiting 0 s").is_some());
    assert!(place(&pane(&bench), on_its_way).is_some());
    bench.send(bench::piece(id, Event::Awaiting(RunId(7))));
    let lines = pane(&bench);
    assert!(place(&lines, "run 7 asks the same").is_some(), "{lines:#?}");
    assert_eq!(place(&lines, on_its_way), None, "{lines:#?}");
    bench.send(bench::piece(
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
    bench.send(bench::answered(id, Err(refused.into())));
    let lines = pane(&bench);
    assert!(lines[0].contains("not sent"), "{lines:#?}");
    assert!(
        place(&lines, "nothing was sent: a key").is_some(),
        "{lines:#?}"
    );
    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.send(bench::piece(id, Event::Kept(RunId(1))));
    let mut unsent = no_verdict("lab/small", "");
    unsent.reasoning.clear();
    unsent.judged = JudgeOutcome::Missing(MissingVerdict::NotSent("cannot reach lab".into()));
    bench.send(bench::answered(id, Ok(Box::new(unsent))));
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
    bench.send(bench::answered(
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

#[test]
fn in_a_low_pane_the_sentence_of_a_claim_begins_in_sight() {
    let mut bench = sized(asking(), 80, 24);
    let (id, _) = bench.asked();
    let text = format!(
        "{}- Car 301 is at a distance of 994.60 m at step 20.\n- Car 302 is at a distance of 997.50 m at step 20.\n",
        "Nothing else matters here.\n\n".repeat(20)
    );
    let mut said = no_verdict("lab/a", &text);
    said.reasoning.clear();
    bench.send(bench::answered(id, Ok(Box::new(said))));
    bench.frame(80, 24);
    for (begin, claim) in [("Car 301", "994.60 m≠"), ("Car 302", "997.50 m≠")] {
        bench.press(")");
        let frame = bench.frame(80, 24);
        let lines: Vec<String> = frame.lines().map(str::to_string).collect();
        let begin = place(&lines, begin);
        assert!(begin.is_some(), "{frame}");
        assert_eq!(place(&lines, claim), begin.map(|at| at + 1), "{frame}");
    }
}

const WHY: &str = "## Why\n\nThe gap to obstacle 301 is **9 m**.\n\n- it is `near`\n\n```json\n{\n  \"collision\": true,\n\
    \"justification\": \"the gap to obstacle 301 is 3 m\"\n}\n```\n";

#[test]
fn markdown_is_rendered_json_is_folded_and_both_can_be_had_as_sent() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    let mut said = no_verdict("lab/a", WHY);
    said.reasoning.clear();
    bench.send(bench::answered(id, Ok(Box::new(said))));
    let shows = |bench: &Bench, words: &str| place(&pane(bench), words).is_some();
    for (words, there) in [
        ("│Why", true),
        ("• it is near", true),
        ("**", false),
        ("```", false),
        ("▸ verdict JSON, 4 lines", true),
        ("justification", false),
    ] {
        assert_eq!(shows(&bench, words), there, "{words}: {:#?}", pane(&bench));
    }
    bench.perform("unfold-json");
    assert!(shows(&bench, "\"collision\": true") && !shows(&bench, "▸"));
    bench.perform("unfold-json");
    bench.perform("raw-answer");
    for words in ["## Why", "**9 m", "- it is `near`", "```json"] {
        assert!(shows(&bench, words), "{words}: {:#?}", pane(&bench));
    }
}

#[test]
fn reasons_in_json_are_read_as_text_while_they_arrive() {
    let answer = "{\"justification\": \"1. The gap is **9 m**.\\n2. It \\\"closes\\\".\", \"obstacles\": [], \
         \"critical_obstacles\": [], \"probability\": 0.9, \"collision\": true, \"note\": \"long enough to be folded, as real answers are\"}";
    let mut bench = asking();
    let (id, _) = bench.asked();
    let (first, more) = answer.split_at(answer.find("It").unwrap());
    let shows = |bench: &Bench, words: &str| place(&pane(bench), words).is_some();
    let piece = |text: &str| Event::Chunk(Chunk::Text(text.into()));
    bench.send(bench::piece(id, piece(first)));
    for (words, there) in [
        ("1. The gap is 9 m.", true),
        ("justification", false),
        ("\\n", false),
    ] {
        assert_eq!(shows(&bench, words), there, "{words}: {:#?}", pane(&bench));
    }
    bench.send(bench::piece(id, piece(more)));
    for words in ["2. It \"closes\".", "▸ verdict JSON, 1 line"] {
        assert!(shows(&bench, words), "{words}: {:#?}", pane(&bench));
    }
    bench.perform("unfold-json");
    assert!(shows(&bench, "{\"obstacles\": []") && !shows(&bench, "justification"));
    bench.perform("raw-answer");
    assert!(shows(&bench, "{\"justification\": \"1. The gap"));
}

#[test]
fn a_claim_in_folded_json_unfolds_it() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    let mut said = no_verdict("lab/a", WHY);
    said.reasoning.clear();
    bench.send(bench::answered(id, Ok(Box::new(said))));
    let lines = pane(&bench);
    assert!(place(&lines, "4 lines, 1 claim").is_some(), "{lines:#?}");
    // The first claim is in the text, and its sign stands behind what markup leaves of it.
    assert!(place(&lines, "9 m≠").is_some(), "{lines:#?}");
    bench.press(")");
    assert!(place(&pane(&bench), "▸ verdict JSON").is_some());
    bench.press(")");
    let lines = pane(&bench);
    let at = place(&lines, "justification");
    assert!(
        at.is_some_and(|at| lines[at + 1].contains("is 3 m")),
        "{lines:#?}"
    );
}

#[test]
fn when_a_stream_ends_the_reader_is_where_reading_goes_on() {
    let text = (0..90).map(|n| format!("line {n}\n")).collect::<String>();
    let stream = |bench: &mut Bench| {
        let (id, _) = bench.asked();
        let chunk = Event::Chunk(Chunk::Text(text.clone()));
        bench.send(bench::piece(id, chunk));
        pane(bench);
        id
    };
    let end = |bench: &mut Bench, id| {
        let mut said = no_verdict("lab/small", &text);
        said.reasoning.clear();
        bench.send(bench::answered(id, Ok(Box::new(said))));
        pane(bench)
    };
    // A reader who only watched begins at the beginning.
    let mut bench = asking();
    let id = stream(&mut bench);
    assert!(place(&pane(&bench), "line 89").is_some());
    assert!(place(&end(&mut bench, id), "line 0").is_some());
    // A reader stays, in the middle and at the end.
    for (keys, words) in [("up up up", "line 86"), ("up shift-g", "line 89")] {
        let mut bench = asking();
        bench.model.focus = crate::model::Pane::Reasoning;
        let id = stream(&mut bench);
        bench.press(keys);
        pane(&bench);
        let lines = end(&mut bench, id);
        assert!(place(&lines, words).is_some(), "{keys}: {lines:#?}");
        assert!(place(&lines, "line 0 ").is_none(), "{keys}: {lines:#?}");
    }
}

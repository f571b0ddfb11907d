//! Questions and answers: from the built-in judge, from models and from the store.

use crate::features::answers::obstacles::named;
use crate::features::answers::{Ask, LoadStored, Probe, StoredOf};
use crate::keymap::Key;
use crate::message::{Effect, Msg};
use crate::model::{Pane, Progress, ShownAnswer, WindowsToJudge};
use crate::tests::bench::{self, Bench, answer, no_verdict};
use crate::update::update;
use nearmiss_ask::llm::{Chunk, Dialect, Discovered, ModelOffer};
use nearmiss_scene::judge;
use nearmiss_scene::verdict::{CriticalObstacle, ParseQuality, Task};
use nearmiss_store::{Origin, RunId};
use nearmiss_study::evaluation::{Answer, Event, JudgeOutcome, MissingVerdict, StoredOrigin};

/// What the workbench wants earlier answers about.
pub fn stored_of(bench: &Bench) -> StoredOf {
    let wanted = bench.effects.iter().find_map(|e| match e.request() {
        Some(LoadStored(of)) => Some(of.clone()),
        _ => None,
    });
    wanted.unwrap()
}

/// The model `lab/small` is asked.
pub fn asking() -> Bench {
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
    let piece = Chunk::Reasoning("thinking hard".into());
    bench.send(bench::piece(id, Event::Chunk(piece)));
    assert!(bench.frame(120, 40).contains("thinking hard"));
    bench.send(bench::piece(id, Event::Chunk(Chunk::Text("so: ".into()))));
    assert!(bench.frame(120, 40).contains("streaming"));
    bench.send(bench::answered(
        id,
        Ok(Box::new(answer("lab/small", false, 302))),
    ));
    let frame = bench.frame(200, 60);
    assert!(frame.contains("no ≠"), "{frame}");
    assert!(
        frame.contains("lab/small says so")
            && frame.contains("2,000+100")
            && frame.contains("6.1 s")
    );
}

#[test]
fn models_of_this_machine_are_offered_once() {
    let mut bench = Bench::bundled();
    let found = |id: &str| Discovered {
        id: id.into(),
        dialect: Dialect::Ollama,
    };
    let all = vec![found("ollama/tiny"), found("lab/small")];
    bench.send(Msg::reply::<Probe>(all.clone()));
    bench.send(Msg::reply::<Probe>(all));
    bench.press("m");
    let frame = bench.frame(120, 40);
    assert_eq!(frame.matches("ollama/tiny").count(), 1, "{frame}");
    assert_eq!(frame.matches("lab/small").count(), 1, "{frame}");
}

#[test]
fn the_chooser_begins_with_a_model_that_reads_the_prompt() {
    let mut bench = Bench::bundled();
    let offer = |id: &str, key| ModelOffer {
        id: id.into(),
        key,
        warning: None,
    };
    bench.model.offers.clear();
    bench.press("m enter");
    assert_eq!(bench.model.model, judge::MODEL, "there is no other");
    bench.model.offers = vec![
        offer("far/a", Some(("FAR_KEY".into(), false))),
        offer("lab/a", None),
        offer("lab/b", None),
    ];
    bench.press("e x esc r enter");
    assert_eq!(bench.model.model, "lab/a");
    bench.model.model = "lab/b".into();
    bench.press("m enter");
    assert_eq!(bench.model.model, "lab/b");
}

#[test]
fn letters_of_the_plot_stand_over_narrow_columns_too() {
    let mut bench = Bench::bundled();
    let of = stored_of(&bench);
    let ids = ["lab/a-model-of-sorts", "lab/a-model-of-words", "lab/c"];
    let said = ids.map(|id| answer(id, true, 301));
    bench.send(Msg::reply::<LoadStored>((of, said.to_vec())));
    let frame = bench.frame(100, 30);
    let mut lines = frame.lines().skip(1);
    let head = lines
        .find(|line| line.contains("built-in"))
        .unwrap_or_default();
    for letter in ["a ", "b ", "c c"] {
        assert!(head.contains(&format!(" {letter}")), "{frame}");
    }
}

#[test]
fn what_a_model_does_not_take_is_said() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    let piece = Chunk::Note("seed is not sent".into());
    bench.send(bench::piece(id, Event::Chunk(piece)));
    let frame = bench.frame(120, 40);
    assert!(frame.contains("lab/small: seed is not sent"), "{frame}");
}

#[test]
fn c_asks_a_second_model_beside_the_first() {
    let mut bench = asking();
    let (first, _) = bench.asked();
    bench.send(bench::answered(
        first,
        Ok(Box::new(answer("lab/small", true, 301))),
    ));
    bench.press("c");
    bench.type_text("lab/other");
    bench.press("enter");
    let (second, model) = bench.asked();
    assert_eq!(model, "lab/other", "any model can be typed");
    bench.send(bench::answered(
        second,
        Ok(Box::new(answer("lab/other", false, 303))),
    ));
    let frame = bench.frame(120, 40);
    assert!(
        frame.contains("yes =") && frame.contains("no ≠") && frame.contains("built-in"),
        "{frame}"
    );
    assert_eq!(bench.model.answers.shown, ShownAnswer::Column(1));
    bench.press("[");
    assert_eq!(bench.model.answers.shown, ShownAnswer::Column(0));
    bench.press("[");
    assert_eq!(bench.model.answers.shown, ShownAnswer::Reference);
    bench.press("] space a x");
    assert_eq!(bench.model.answers.columns.len(), 1);
}

#[test]
fn an_answer_without_a_verdict_is_a_state_of_its_own() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    let piece = Chunk::Text("I cannot tell.".into());
    bench.send(bench::piece(id, Event::Chunk(piece)));
    bench.send(bench::answered(
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
fn a_repaired_verdict_is_marked_wherever_it_is_shown() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    let mut said = answer("lab/small", true, 301);
    if let JudgeOutcome::Verdict(parsed) = &mut said.judged {
        parsed.how = ParseQuality::Repaired(vec!["comments were skipped".into()]);
    }
    bench.send(bench::answered(id, Ok(Box::new(said))));
    let frame = bench.frame(140, 40);
    for mark in ["yes* =", "* repaired: comments were", "collision, repaired"] {
        assert!(frame.contains(mark), "{mark}:\n{frame}");
    }
}

#[test]
fn ctrl_c_cancels_first_and_quits_second() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.press("ctrl-c");
    assert!(matches!(bench.effects.last(), Some(Effect::Cancel(aborted)) if *aborted == id));
    assert!(matches!(
        bench.model.answers.columns[0].progress,
        Progress::Broken(_)
    ));
    bench.press("ctrl-c");
    assert!(!matches!(bench.effects.last(), Some(Effect::Quit)));
    assert!(bench.frame(120, 40).contains("Ctrl-C again quits"));
    bench.press("ctrl-c");
    assert!(matches!(bench.effects.last(), Some(Effect::Quit)));
}

#[test]
fn streaming_does_not_steal_the_position() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    let text: String = (0..80).map(|i| format!("line {i}\n\n")).collect();
    bench.send(bench::piece(id, Event::Chunk(Chunk::Text(text))));
    assert!(
        bench.frame(120, 40).contains("line 79"),
        "the end is followed"
    );
    bench.model.focus = Pane::Reasoning;
    bench.press("pageup pageup");
    bench.frame(120, 40);
    let before = bench.model.answers.scroll;
    let piece = Chunk::Text("new text\n".repeat(30));
    bench.send(bench::piece(id, Event::Chunk(piece)));
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
    let piece = Chunk::Text("a\u{1b}[2Jb\u{7}".into());
    bench.send(bench::piece(id, Event::Chunk(piece)));
    bench.send(bench::answered(id, Err("bad\u{1b}]0;title\u{7}".into())));
    let frame = bench.frame(120, 40);
    assert!(!frame.contains('\u{1b}') && !frame.contains('\u{7}'));
    assert!(frame.contains("a␛[2Jb␇"), "{frame}");
}

#[test]
fn the_built_in_judge_can_be_asked_and_is_kept() {
    let mut bench = Bench::bundled();
    bench.press("r");
    let (id, model) = bench.asked();
    assert_eq!(model, nearmiss_scene::judge::MODEL);
    assert!(bench.model.answers.columns.is_empty());
    bench.send(bench::answered(
        id,
        Ok(Box::new(answer(nearmiss_scene::judge::MODEL, true, 301))),
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
fn an_answer_goes_on_while_another_scenario_is_looked_at() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.press("down");
    assert!(
        bench
            .effects
            .iter()
            .all(|e| !matches!(e, Effect::Cancel(_)))
    );
    assert!(bench.model.answers.columns.is_empty());
    bench.send(bench::answered(
        id,
        Ok(Box::new(answer("lab/small", true, 301))),
    ));
    let said = &bench.model.toasts.last().unwrap().text;
    assert!(
        said.contains("ZAM_HardBraking-1_1_T-1: collision"),
        "{said}"
    );

    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.press("down ctrl-c");
    assert!(
        bench
            .effects
            .iter()
            .any(|e| matches!(e, Effect::Cancel(aborted) if *aborted == id))
    );
}

#[test]
fn stored_answers_come_back_with_their_scenario_ego_and_task() {
    let mut bench = Bench::bundled();
    let of = stored_of(&bench);
    let other = StoredOf {
        ego: "301, obstacle 301 taken as ego".into(),
        ..of.clone()
    };
    bench.send(Msg::reply::<LoadStored>((
        other,
        vec![answer("lab/x", true, 301)],
    )));
    assert!(bench.model.answers.columns.is_empty(), "about another ego");
    bench.send(Msg::reply::<LoadStored>((
        of,
        vec![answer("lab/x", true, 301), answer("lab/x", false, 1)],
    )));
    assert_eq!(
        bench.model.answers.columns.len(),
        1,
        "the newest of each model"
    );
    assert!(bench.frame(120, 40).contains("yes ="));
    bench.press("n space e t");
    assert!(
        bench.model.answers.columns.is_empty(),
        "answers about the other ego are put away"
    );
}

#[test]
fn an_answer_is_compared_with_the_truth_of_its_own_question() {
    let mut bench = asking();
    bench.press("space a t x left r");
    let (id, _) = bench.asked();
    bench.send(bench::answered(
        id,
        Ok(Box::new(answer("lab/small", true, 301))),
    ));
    assert!(bench.frame(120, 40).contains("yes ="));
    bench.press("home");
    assert!(
        bench.frame(120, 40).contains("yes ="),
        "the cursor moves, the question does not"
    );
}

#[test]
fn more_answers_than_fit_can_all_be_reached() {
    let mut bench = Bench::bundled();
    for i in 0..6 {
        bench.model.model = format!("lab/m{i}");
        bench.press("r");
        let (id, model) = bench.asked();
        let whole = answer(&model, true, 301);
        bench.send(bench::answered(id, Ok(Box::new(whole))));
    }
    let mut seen = String::new();
    for _ in 0..7 {
        let frame = bench.frame(80, 24);
        assert!(
            frame.contains(" of 6 [ ]") && frame.contains("built-in"),
            "{frame}"
        );
        seen.push_str(&frame);
        bench.press("[");
    }
    for i in 0..6 {
        assert!(seen.contains(&format!("lab/m{i} ")), "m{i}");
    }
}

#[test]
fn the_verdict_is_scrolled_apart_from_the_reasoning() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.send(bench::answered(
        id,
        Ok(Box::new(answer("lab/small", true, 301))),
    ));
    bench.model.focus = Pane::Verdict;
    bench.frame(80, 24);
    let reasoning = bench.model.answers.scroll;
    bench.press("shift-g");
    assert!(bench.model.answers.verdict_top > 0);
    assert_eq!(bench.model.answers.scroll, reasoning);
    bench.press("g g");
    assert_eq!(bench.model.answers.verdict_top, 0);
}

#[test]
fn the_table_of_obstacles_is_walked_and_what_differs_is_gone_to() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.send(bench::answered(
        id,
        Ok(Box::new(answer("lab/small", false, 302))),
    ));
    bench.model.focus = Pane::Verdict;
    bench.frame(80, 24);
    let all = named(&bench.model);
    assert!(all.contains(&302) && all.len() > 1, "{all:?}");
    for id in &all {
        bench.press("down");
        assert_eq!(bench.model.answers.cursor, Some(*id));
        let frame = bench.frame(80, 24);
        let row = format!("┃{id} ");
        assert!(frame.contains(&row), "{row} is not in sight\n{frame}");
    }
    bench.press("enter");
    assert_eq!(bench.model.picked, all.last().copied());
    // Its no is wrong: that is gone to, wherever the user is.
    bench.press("home g d");
    let first = bench.model.differences()[0];
    assert_eq!(bench.model.answers.shown, ShownAnswer::Column(first.column));
    assert_eq!(bench.model.clock.step(), first.step);
    assert_ne!(first.step, 0);
}

#[test]
fn asked_from_the_editor_what_changed_stands_beside_it() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.send(bench::answered(
        id,
        Ok(Box::new(answer("lab/small", true, 301))),
    ));
    bench.press("e alt-r");
    let (id, _) = bench.asked();
    let mut new = answer("lab/small", false, 302);
    new.text = "the answer is another".into();
    bench.send(bench::answered(id, Ok(Box::new(new))));
    let frame = bench.frame(200, 60);
    for words in ["verdict: ", "risk of 301: 0 → –", "risk of 302: – → 3"] {
        assert!(frame.contains(words), "{words}\n{frame}");
    }
    assert!(frame.contains("another"), "{frame}");
}

#[test]
fn obstacles_that_are_not_there_are_named() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.send(bench::answered(
        id,
        Ok(Box::new(answer("lab/small", true, 999))),
    ));
    assert!(bench.frame(120, 40).contains("names obstacle 999"));
}

#[test]
fn retries_are_said() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    let wait = std::time::Duration::from_secs(7);
    bench.send(bench::piece(
        id,
        Event::Chunk(Chunk::Retrying {
            attempt: 2,
            wait,
            why: "429".into(),
        }),
    ));
    let frame = bench.frame(120, 40);
    assert!(
        frame.contains("retrying") && frame.contains("try 2 in 7 s"),
        "{frame}"
    );
}

#[test]
fn an_error_is_read_beside_the_answer_and_covers_nothing() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    let mut failed = no_verdict("lab/small", "");
    let why =
        "cannot reach lab (http://127.0.0.1:9/v1/chat): connection refused; check the address";
    failed.reasoning.clear();
    failed.judged = JudgeOutcome::Missing(MissingVerdict::NoAnswer(why.into()));
    bench.send(bench::answered(id, Ok(Box::new(failed))));
    let frame = bench.frame(80, 24);
    let lines: Vec<&str> = frame.lines().collect();
    let title = lines.iter().position(|l| l.contains("reasoning")).unwrap();
    assert!(
        lines[title + 1].contains("no answer: cannot reach"),
        "{frame}"
    );
    assert!(lines[title + 4].contains("address"), "{frame}");
    assert!(
        frame.contains("│all   ") && frame.contains("┌ risk"),
        "{frame}"
    );
    assert!(frame.contains("lab/small"), "whose column it is: {frame}");
    // Where the reasoning is not seen, the error is a message.
    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.press("z");
    bench.send(bench::answered(id, Err(why.into())));
    assert!(bench.frame(80, 24).contains("┌ error "));
}

#[test]
fn shift_r_asks_anew_and_an_answer_of_the_store_says_so() {
    let mut bench = asking();
    bench.press("shift-r");
    let fresh = |bench: &Bench| match bench.effects.last().and_then(Effect::request) {
        Some(Ask { fresh, .. }) => *fresh,
        other => panic!("{other:?}"),
    };
    assert!(fresh(&bench));
    bench.press("r");
    assert!(!fresh(&bench));
    let (id, _) = bench.asked();
    let past = StoredOrigin {
        created_ms: 0,
        origin: Origin::Asked,
        sample: 0,
    };
    let stored = Answer {
        run: Some(RunId(7)),
        past: Some(past),
        ..answer("lab/small", true, 301)
    };
    bench.send(bench::answered(id, Ok(Box::new(stored.clone()))));
    let frame = bench.frame(120, 40);
    assert!(frame.contains("run 7, asked 19"), "{frame}");
    let columns = bench.model.answers.columns.len();
    bench.press("r");
    let (id, _) = bench.asked();
    bench.send(bench::answered(id, Ok(Box::new(stored))));
    assert_eq!(
        bench.model.answers.columns.len(),
        columns,
        "the same run is shown once"
    );
    assert_eq!(bench.model.answers.column().and_then(|c| c.ask), Some(id));
}

#[test]
fn recorded_answers_of_several_models_and_ways_stand_side_by_side() {
    let mut bench = Bench::bundled();
    let of = bench
        .effects
        .iter()
        .find_map(|e| match e.request() {
            Some(LoadStored(of)) => Some(of.clone()),
            _ => None,
        })
        .unwrap();
    assert!(of.recorded && of.name.starts_with("ZAM_"));
    let past = StoredOrigin {
        created_ms: 0,
        origin: Origin::Recorded,
        sample: 0,
    };
    let ways = ["ego · base", "cartesian · cot", "ego · cp+cot+icl"];
    let stored = ways.iter().flat_map(|how| {
        ["gemini", "openai", "deepseek"].map(|name| Answer {
            past: Some(past),
            how: (*how).into(),
            window: None,
            ..answer(&format!("recorded/{name}"), true, 301)
        })
    });
    bench.send(Msg::reply::<LoadStored>((of, stored.collect())));
    assert_eq!(bench.model.answers.columns.len(), 9);
    let shows = |bench: &Bench, words: &[&str]| {
        let frame = bench.frame(200, 50);
        for word in words {
            assert!(frame.contains(word), "{word}: {frame}");
        }
    };
    let names = ["gemini", "openai", "deepse"];
    shows(&bench, &names);
    shows(&bench, &["imported", "cp+cot+icl", "base", "unknown"]);
    bench.press("] ] ] ] ] ] ] ]");
    shows(&bench, &["cart", "cot"]);
    // Asked as it would be asked now, one of each model.
    let first = &bench.model.answers.columns[..3];
    assert!(first.iter().all(|c| c.how == "ego · cp+cot+icl"));
}

#[test]
fn runs_that_reached_no_model_do_not_come_back() {
    let mut bench = Bench::bundled();
    let of = stored_of(&bench);
    let refused = || no_verdict("lab/x", "");
    bench.send(Msg::reply::<LoadStored>((
        of.clone(),
        vec![refused(), refused()],
    )));
    assert!(bench.model.answers.columns.is_empty());
    assert_eq!(bench.model.answers.shown, ShownAnswer::Reference);
    bench.send(Msg::reply::<LoadStored>((
        of,
        vec![refused(), answer("lab/x", true, 301)],
    )));
    assert_eq!(bench.model.answers.columns.len(), 1);
    assert!(
        bench.frame(120, 40).contains("yes ="),
        "the older answer of that model is not hidden by the newer failure"
    );
}

#[test]
fn what_broke_off_does_not_hide_a_whole_answer() {
    let mut bench = Bench::bundled();
    let of = stored_of(&bench);
    let cancelled = Answer {
        judged: JudgeOutcome::Missing(MissingVerdict::Cancelled),
        text: "the beg".into(),
        ..answer("lab/a", true, 301)
    };
    bench.send(Msg::reply::<LoadStored>((
        of,
        vec![cancelled, answer("lab/a", true, 301)],
    )));
    let columns = &bench.model.answers.columns;
    assert_eq!(columns.len(), 1);
    assert!(columns[0].answer().is_some_and(Answer::arrived));
}

#[test]
fn answers_to_other_prompts_are_told_apart() {
    let mut bench = Bench::bundled();
    let of = stored_of(&bench);
    let mine = Answer {
        how: "ego · base · mine 3fa2c1".into(),
        ..answer("lab/a", true, 301)
    };
    bench.send(Msg::reply::<LoadStored>((
        of,
        vec![mine, answer("lab/a", true, 301)],
    )));
    assert_eq!(bench.model.answers.columns.len(), 2);
    let frame = bench.frame(200, 60);
    let row = frame
        .lines()
        .find(|line| line.contains("prompt    "))
        .unwrap_or_else(|| panic!("{frame}"));
    assert!(
        row.contains("mine 3fa2c1") && row.contains("shipped"),
        "{row}"
    );
    assert!(
        !frame.contains("│frame   "),
        "frame and techniques are the same: {frame}"
    );
}

/// On the safety task, before anything of it is computed.
fn before() -> Bench {
    let mut bench = Bench::bundled();
    bench.model.task = Task::Safety;
    bench.model.clock.go(10);
    bench.model.judgements = crate::model::Judgements::default();
    bench.model.refresh();
    bench.press("right");
    bench
}

/// Jumps beyond what was judged ahead, and holds back what that computes.
fn jump(bench: &mut Bench) -> Vec<Effect> {
    let (_, last) = bench.model.clock.range();
    bench.model.clock.go(last - 1);
    held(bench, "right")
}

/// Presses a key and holds back what it computes.
fn held(bench: &mut Bench, key: &str) -> Vec<Effect> {
    let effects = update(&mut bench.model, Msg::Key(Key::parse(key).unwrap()));
    let requests = effects.into_iter();
    let requests = requests.filter(|effect| matches!(effect, Effect::Request(_)));
    requests.collect()
}

/// What was held back is computed after all.
fn compute(bench: &mut Bench, computation: Effect) {
    if let Ok(computed) = computation.at_once() {
        bench.send(computed);
    }
}

fn windows(computations: &[Effect]) -> Vec<usize> {
    let judged = computations.iter().filter_map(Effect::request);
    judged
        .map(|asked: &WindowsToJudge| asked.windows.len())
        .collect()
}

#[test]
fn the_verdict_is_pending_until_it_is_computed() {
    let mut bench = before();
    let computed = jump(&mut bench);
    assert_eq!(windows(&computed).first(), Some(&1), "{computed:?}");
    assert!(bench.model.is_judging() && bench.model.has_reference());
    let frame = bench.frame(120, 40);
    assert!(frame.contains("judging…"), "{frame}");
    for computation in computed {
        compute(&mut bench, computation);
    }
    assert!(!bench.model.is_judging());
    let frame = bench.frame(120, 40);
    assert!(!frame.contains("judging…"), "{frame}");
}

#[test]
fn the_next_steps_are_judged_ahead() {
    let mut bench = before();
    for _ in 0..5 {
        let computed = held(&mut bench, "right");
        assert!(!bench.model.is_judging(), "it was judged ahead");
        assert!(windows(&computed).iter().all(|n| *n == 1), "{computed:?}");
        for computation in computed {
            compute(&mut bench, computation);
        }
    }
    // Back where everything is known.
    let computed = held(&mut bench, "left");
    assert!(windows(&computed).is_empty(), "{computed:?}");
}

#[test]
fn a_judgement_of_another_scene_is_dropped() {
    let mut bench = before();
    let late = jump(&mut bench);
    assert_eq!(windows(&late), [1]);
    bench.press("j enter");
    let known = bench.model.answers.reference.clone();
    for computation in late {
        compute(&mut bench, computation);
    }
    assert_eq!(bench.model.answers.reference, known);
}

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
    bench.send(bench::answered(id, Ok(Box::new(given))));
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

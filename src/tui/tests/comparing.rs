//! Answer columns, and the verdicts they are compared with.

use crate::features::answers::LoadStored;
use crate::message::Msg;
use crate::model::{Progress, ShownAnswer};
use crate::tests::answers::{asking, stored_of};
use crate::tests::bench::{self, Bench, answer, no_verdict};
use nearmiss_scene::verdict::Task;
use nearmiss_store::RunId;
use nearmiss_study::evaluation::{Answer, Event, JudgeOutcome, MissingVerdict};

#[test]
fn the_safety_task_begins_at_the_end_of_its_usual_window() {
    let mut bench = Bench::bundled();
    let last = bench.model.scene().unwrap().last_step();
    bench.press("space a t");
    assert_eq!(bench.model.clock.step(), last - 2);
    let frame = bench.frame(120, 40);
    assert!(!frame.contains("-step window"), "{frame}");
    bench.press("down");
    let last = bench.model.scene().unwrap().last_step();
    assert_eq!(bench.model.clock.step(), last - 2, "the next scenario too");

    let mut bench = Bench::bundled();
    bench.press("home right right right space a t");
    assert_eq!(
        bench.model.clock.step(),
        3,
        "the step stays where the user left it"
    );
    assert!(bench.frame(80, 24).contains("4-step window"));
    bench.press("home");
    assert!(bench.frame(80, 24).contains("1-step window "));
    bench.press("space a t");
    assert!(!bench.frame(80, 24).contains("-step window"), "it has none");
}

#[test]
fn what_an_answer_about_another_window_is_held_against_is_shown() {
    let mut bench = Bench::bundled();
    bench.press("space a t");
    let window = bench.model.window().unwrap();
    let mut said = answer("lab/small", true, 301);
    said.window = Some((window.first(), window.last()));
    if let JudgeOutcome::Verdict(parsed) = &mut said.judged {
        parsed.verdict.task = Task::Safety;
    }
    let of = stored_of(&bench);
    let of = crate::features::answers::StoredOf {
        task: Task::Safety,
        ..of
    };
    bench.send(Msg::reply::<LoadStored>((of, vec![said])));
    for size in [(80, 24), (120, 40)] {
        let frame = bench.frame(size.0, size.1);
        assert!(!frame.contains("truth"), "the same window: {frame}");
    }
    bench.press("home");
    for size in [(80, 24), (120, 40)] {
        let frame = bench.frame(size.0, size.1);
        let row = |name: &str| {
            let line = frame.lines().find(|l| l.contains(&format!("│{name} ")));
            line.unwrap_or_else(|| panic!("{name}: {frame}"))
                .to_string()
        };
        assert!(row("truth").contains("yes 301"), "{frame}");
        let critical = row("critical");
        assert!(
            critical.contains("yes =") && critical.contains(" no"),
            "the built-in judge is at the first step: {frame}"
        );
    }
}

/// Answers of two models, each asked in four ways, the newest first.
fn ways() -> Bench {
    let mut bench = Bench::bundled();
    let ways = [
        "ego · cp+cot+icl",
        "ego · cot",
        "ego · base",
        "ego · cp",
        "cartesian · cp+cot+icl",
    ];
    let stored = ways.iter().flat_map(|how| {
        ["lab/b", "lab/a"].map(|name| Answer {
            how: (*how).into(),
            ..answer(name, true, 301)
        })
    });
    let of = stored_of(&bench);
    bench.send(Msg::reply::<LoadStored>((of, stored.collect())));
    bench
}

fn columns(bench: &Bench) -> Vec<(String, String)> {
    let columns = bench.model.answers.columns.iter();
    columns.map(|c| (c.model.clone(), c.how.clone())).collect()
}

#[test]
fn columns_are_told_apart_by_the_way_they_were_asked() {
    let bench = ways();
    let expected = [
        ("lab/a", "ego · cp+cot+icl"),
        ("lab/b", "ego · cp+cot+icl"),
        ("lab/a", "ego · base"),
        ("lab/a", "ego · cp"),
        ("lab/a", "ego · cot"),
        ("lab/a", "cartesian · cp+cot+icl"),
        ("lab/b", "ego · base"),
        ("lab/b", "ego · cp"),
        ("lab/b", "ego · cot"),
        ("lab/b", "cartesian · cp+cot+icl"),
    ]
    .map(|(model, how)| (model.to_string(), how.to_string()));
    assert_eq!(columns(&bench), expected);
    assert_eq!(bench.model.answers.shown, ShownAnswer::Column(0));
    let frame = bench.frame(80, 24);
    let lines: Vec<&str> = frame.lines().collect();
    let heads = |l: &&str| l.contains("built-in") && l.contains("│");
    let head = lines.iter().position(heads).unwrap();
    assert!(lines[head + 1].contains("│collision "), "the same in sight");
    let wide = bench.frame(200, 60);
    assert!(wide.contains("│technique ") && !wide.contains("│frame "));
}

#[test]
fn the_switches_lead_to_the_answers_that_were_asked_in_that_way() {
    let mut bench = ways();
    let shown = |bench: &Bench| {
        let column = bench.model.answers.column().unwrap();
        (column.model.clone(), column.how.clone())
    };
    assert_eq!(shown(&bench), ("lab/a".into(), "ego · cp+cot+icl".into()));
    bench.press("space a f");
    let cartesian = "cartesian · cp+cot+icl";
    assert_eq!(shown(&bench), ("lab/a".into(), cartesian.into()));
    let first = &columns(&bench)[..2];
    assert!(first.iter().all(|(_, how)| how == cartesian), "{first:?}");
    let frame = bench.frame(80, 24);
    assert!(frame.contains(" cart"), "{frame}");
    // Nothing was asked so: what is shown stays.
    bench.press("space a c");
    assert_eq!(shown(&bench), ("lab/a".into(), cartesian.into()));
    bench.press("space a c");
    bench.model.answers.show(ShownAnswer::Reference);
    // Once round: three frames of words, the picture, and it beside each of them.
    bench.press(&["space a f"; 7].join(" "));
    assert_eq!(bench.model.frame.name(), "cartesian");
    assert_eq!(shown(&bench).1, cartesian);
}

#[test]
fn what_arrives_stays_shown_while_the_next_question_is_made() {
    let mut bench = ways();
    bench.model.model = "lab/small".into();
    bench.press("r");
    let (id, _) = bench.asked();
    bench.press("space a f");
    assert_eq!(bench.model.answers.column().unwrap().ask, Some(id));
}

#[test]
fn a_retry_takes_the_place_of_what_failed() {
    let mut bench = asking();
    let (first, _) = bench.asked();
    bench.send(bench::answered(first, Err("no key".into())));
    assert!(matches!(
        bench.model.answers.columns[0].progress,
        Progress::Unasked(_)
    ));
    for size in [(80, 24), (120, 40)] {
        let frame = bench.frame(size.0, size.1);
        assert!(
            (frame.contains("not sent") || frame.contains("unsent"))
                && !frame.contains("no verdict")
                && !frame.contains("no answer"),
            "{frame}"
        );
    }
    bench.press("r ctrl-c");
    assert_eq!(bench.model.answers.columns.len(), 1, "cancelled");
    bench.press("r");
    let (third, _) = bench.asked();
    let mut failed = no_verdict("lab/small", "");
    failed.judged = JudgeOutcome::Missing(MissingVerdict::NoAnswer("refused".into()));
    bench.send(bench::answered(third, Ok(Box::new(failed))));
    assert_eq!(bench.model.answers.columns.len(), 1);
    bench.press("space a c r");
    assert_eq!(
        bench.model.answers.columns.len(),
        2,
        "another way of asking is no retry"
    );
    let (fourth, _) = bench.asked();
    let said = answer("lab/small", true, 301);
    bench.send(bench::answered(fourth, Ok(Box::new(said))));
    bench.press("r");
    assert_eq!(bench.model.answers.columns.len(), 3, "an answer stays");
}

#[test]
fn what_may_have_been_sent_is_not_called_unsent() {
    let mut bench = asking();
    let (id, _) = bench.asked();
    bench.send(bench::piece(id, Event::Kept(RunId(1))));
    bench.send(bench::answered(id, Err("the disk is full".into())));
    let frame = bench.frame(120, 40);
    assert!(
        frame.contains("no answer") && !frame.contains("not sent"),
        "{frame}"
    );
}

#[test]
fn the_task_goes_round_all_five_and_answers_to_each_are_shown() {
    use nearmiss_scene::verdict::{
        AttackerChoice, Manoeuvre, ManoeuvreKind, Motion, NewMotion, ObstacleRisk, ParseQuality,
        ParsedAnswer, Reading, Task,
    };
    let mut bench = Bench::bundled();
    let mut tasks = Vec::new();
    for _ in Task::ALL {
        bench.press("space a t");
        tasks.push(bench.model.task);
        assert!(
            bench.model.prompt.question.is_some(),
            "{:?}",
            bench.model.task
        );
        assert_eq!(
            bench.model.prompt.question.as_ref().unwrap().case.task,
            bench.model.task
        );
    }
    assert_eq!(
        tasks,
        [
            Task::Safety,
            Task::Recording,
            Task::Attacker,
            Task::Trajectory,
            Task::Collision
        ]
    );
    bench.press("space a t space a t");
    let frame = bench.frame(200, 60);
    // The built-in judge looks at every step, wherever the clock stands.
    for words in ["high risk", "all"] {
        assert!(frame.contains(words), "{words}\n{frame}");
    }
    let asked = bench.model.prompt.question.as_ref().unwrap();
    let scene = bench.model.scene().unwrap();
    let window = asked.case.window;
    assert_eq!(
        (window.first(), window.last()),
        (scene.steps().start, scene.last_step())
    );
    bench.press("space a t r");
    assert!(
        bench
            .model
            .toasts
            .iter()
            .any(|t| t.text.contains("collision, safety or recording only"))
    );
    bench.frame(120, 40);
    bench.model.model = "lab/small".into();
    let give = |bench: &mut Bench, said: ParsedAnswer| {
        bench.press("r");
        let (id, _) = bench.asked();
        let mut given = answer("lab/small", true, 301);
        given.judged = JudgeOutcome::Other(Reading {
            said,
            how: ParseQuality::Strict,
        });
        bench.send(bench::answered(id, Ok(Box::new(given))));
    };
    let risk = |id, risk_score| ObstacleRisk {
        id,
        risk_score,
        reason: "the lane beside".into(),
        written_score: None,
    };
    give(
        &mut bench,
        ParsedAnswer::Attacker(AttackerChoice {
            attacker: Some(302),
            obstacles: vec![risk(302, 1), risk(303, 4)],
            justification: "It can cut in.".into(),
        }),
    );
    let frame = bench.frame(200, 60);
    for words in [
        "attacker  302",
        "others    1",
        "▸ 302 risk 1: the lane beside",
        "It can cut in.",
    ] {
        assert!(frame.contains(words), "{words}\n{frame}");
    }
    bench.press("space a t");
    give(
        &mut bench,
        ParsedAnswer::Trajectory(NewMotion {
            obstacle: 302,
            motion: Motion::Manoeuvre(Manoeuvre {
                kind: ManoeuvreKind::CutIn,
                start: 1.0,
                duration: 2.0,
                gap: Some(4.0),
                speed: None,
            }),
            justification: "Close in front.".into(),
        }),
    );
    let frame = bench.frame(200, 60);
    for words in [
        "obstacle  302",
        "motion    cut-in",
        "when      1.0 s +2.0 s",
        "cut-in from 1.00 s for 2.00 s, gap 4.00 m",
    ] {
        assert!(frame.contains(words), "{words}\n{frame}");
    }
}

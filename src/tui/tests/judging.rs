//! Values that are computed in the background: what the screen shows until they arrive, and what is computed ahead.

use super::bench::Bench;
use crate::keymap::Key;
use crate::message::{Effect, Msg};
use crate::model::WindowsToJudge;
use crate::update::update;
use nearmiss_scene::verdict::Task;

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

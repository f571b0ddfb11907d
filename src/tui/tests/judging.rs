//! Values that are computed in the background: what the screen shows until they arrive, and what is computed ahead.

use super::bench::Bench;
use crate::keymap::Key;
use crate::message::{Computation, Effect, Msg};
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
fn jump(bench: &mut Bench) -> Vec<Computation> {
    let (_, last) = bench.model.clock.range();
    bench.model.clock.go(last - 1);
    held(bench, "right")
}

/// Presses a key and holds back what it computes.
fn held(bench: &mut Bench, key: &str) -> Vec<Computation> {
    let effects = update(&mut bench.model, Msg::Key(Key::parse(key).unwrap()));
    let computed = effects.into_iter().filter_map(|effect| match effect {
        Effect::Compute(computation) => Some(computation),
        _ => None,
    });
    computed.collect()
}

fn windows(computations: &[Computation]) -> Vec<usize> {
    let judged = computations.iter().filter_map(|c| match c {
        Computation::Judge(_, _, windows, _) => Some(windows.len()),
        _ => None,
    });
    judged.collect()
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
        bench.send(Msg::Computed(computation.run()));
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
            bench.send(Msg::Computed(computation.run()));
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
        bench.send(Msg::Computed(computation.run()));
    }
    assert_eq!(bench.model.answers.reference, known);
}

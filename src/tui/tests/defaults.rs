//! Defaults of a question: the same as on the command line.

use super::bench::Bench;
use nearmiss_scene::description::Frame;
use nearmiss_scene::verdict::Task;

/// Goes on to a task.
fn to(bench: &mut Bench, task: Task) {
    for _ in Task::ALL {
        if bench.model.task == task {
            return;
        }
        bench.press("space a t");
    }
    assert_eq!(bench.model.task, task);
}

#[test]
fn every_task_begins_in_its_usual_frame_and_window() {
    let mut bench = Bench::bundled();
    let last = bench.model.scene().map(|s| s.last_step());
    let end = |bench: &Bench| bench.model.window().map(|w| w.last());
    to(&mut bench, Task::Safety);
    assert_eq!(end(&bench), last.map(|l| l - 2));
    to(&mut bench, Task::Attacker);
    assert_eq!((end(&bench), bench.model.frame), (last, Frame::Metrics));
    let said = bench.frame(120, 40);
    assert!(said.contains("built-in judge does not"), "{said}");
    assert!(!said.contains("nothing to judge yet"), "{said}");
    to(&mut bench, Task::Trajectory);
    assert_eq!(end(&bench), last);
    to(&mut bench, Task::Safety);
    assert_eq!(
        (end(&bench), bench.model.frame),
        (last.map(|l| l - 2), Frame::Ego)
    );
}

#[test]
fn what_somebody_chose_stays() {
    let mut bench = Bench::bundled();
    to(&mut bench, Task::Safety);
    bench.press("space a f");
    let chosen = bench.model.frame;
    assert_ne!(chosen, Frame::Ego);
    let pane = bench.model.focus;
    bench.model.focus = crate::model::Pane::Map;
    bench.press("left");
    bench.model.focus = pane;
    let step = bench.model.clock.step();
    for _ in Task::ALL {
        bench.press("space a t");
        assert_eq!(bench.model.clock.step(), step, "{:?}", bench.model.task);
    }
    assert_eq!(
        (bench.model.task, bench.model.frame),
        (Task::Safety, chosen)
    );
}

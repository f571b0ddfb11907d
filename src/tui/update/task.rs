//! Switches between tasks.

use super::super::model::Model;
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::default_frame;

/// The next task that has a template, in the frame that was chosen if it has one for that, else in its usual one.
pub fn next(model: &mut Model) {
    let all = Task::ALL;
    let now = all.iter().position(|t| *t == model.task).unwrap_or(0);
    let after = (1..all.len()).map(|n| all[(now + n) % all.len()]);
    for task in after {
        let has = |frame: &nearmiss_scene::description::Frame| {
            let found = model.library.find(task.name(), frame.name());
            found.is_some()
        };
        let chosen = model.frame_chosen.filter(has);
        let frame = chosen.unwrap_or_else(|| default_frame(&model.library, task));
        if has(&frame) {
            model.task = task;
            model.frame = frame;
            return;
        }
    }
}

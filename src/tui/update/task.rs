//! Switches between tasks.

use super::super::model::Model;
use crate::evaluation::default_frame;
use crate::verdict::Task;

/// The next task that has a template, in the frame that was chosen if it has one for that, else in its usual one.
pub fn next(model: &mut Model) {
    let all = Task::ALL;
    let now = all.iter().position(|t| *t == model.task).unwrap_or(0);
    let after = (1..all.len()).map(|n| all[(now + n) % all.len()]);
    for task in after {
        let has = |frame: &crate::description::Frame| {
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

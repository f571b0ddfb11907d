//! Going from one task to the next.

use super::super::model::Model;
use crate::verdict::Task;

/// The next task that has a template, in a frame that it has one for.
pub fn next(model: &mut Model) {
    let all = Task::ALL;
    let now = all.iter().position(|t| *t == model.task).unwrap_or(0);
    let after = (1..all.len()).map(|n| all[(now + n) % all.len()]);
    for task in after {
        let before = std::mem::replace(&mut model.task, task);
        let has = |model: &Model| {
            let found = model.library.find(model.task.name(), model.frame.name());
            found.is_some()
        };
        if !has(model) {
            model.frame = model.next_frame();
        }
        if has(model) {
            return;
        }
        model.task = before;
    }
}

//! The default frame of a description, shared by the command line and the workbench.

use nearmiss_ask::prompts::Library;
use nearmiss_scene::description::Frame;
use nearmiss_scene::verdict::Task;

/// Of an attacker the metrics, of the rest the ego frame, where the task has it; else the first that it has.
#[must_use]
pub fn default_frame(library: &Library, task: Task) -> Frame {
    let first = match task {
        Task::Attacker => Frame::Metrics,
        _ => Frame::Ego,
    };
    let mut frames = std::iter::once(first).chain(Frame::ALL);
    let has = |frame: &Frame| library.find(task.name(), frame.name()).is_some();
    frames.find(has).unwrap_or(first)
}

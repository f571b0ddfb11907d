//! The identity of a batch question: what distinguishes it from all others.

use super::NewItem;

/// A question without its ground truth and state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Identity<'a> {
    /// The scenario's file, or the name of a bundled one.
    pub path: &'a str,
    /// Name of the task.
    pub task: &'a str,
    /// `provider/model`.
    pub model: &'a str,
    /// The frame of the description.
    pub frame: Option<&'a str>,
    /// The techniques.
    pub techniques: Option<&'a str>,
    /// The end of its window.
    pub lead: Option<&'a str>,
    /// The change of the scene.
    pub transform: Option<&'a str>,
    /// First and last step of its window, where it was drawn.
    pub window: Option<(i64, i64)>,
    /// Values of the axes of the batch.
    pub settings: Option<&'a str>,
    /// Sample number among several answers.
    pub sample: u32,
}

impl NewItem {
    /// Its identity within the batch.
    #[must_use]
    pub fn identity(&self) -> Identity<'_> {
        Identity {
            path: &self.path,
            task: self.task.name(),
            model: &self.model,
            frame: self.frame.as_deref(),
            techniques: self.techniques.as_deref(),
            lead: self.lead.as_deref(),
            transform: self.transform.as_deref(),
            window: self.window,
            settings: self.settings.as_deref(),
            sample: self.sample,
        }
    }
}

//! The identity of a batch question: what distinguishes it from all others.

use super::NewItem;

/// A question without what is true about it and where it stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Identity<'a> {
    /// The scenario's file, or the name of a bundled one.
    pub path: &'a str,
    /// The word for what is asked.
    pub task: &'a str,
    /// `provider/model`.
    pub model: &'a str,
    /// From where it is described.
    pub frame: Option<&'a str>,
    /// The techniques.
    pub techniques: Option<&'a str>,
    /// Where its window ends.
    pub lead: Option<&'a str>,
    /// What is changed about the scene.
    pub transform: Option<&'a str>,
    /// Which of several answers.
    pub sample: u32,
}

impl NewItem {
    /// What tells it from all others of its batch.
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
            sample: self.sample,
        }
    }
}

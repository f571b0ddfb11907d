//! An answer with what its question varies beside the way of asking: the lead and the transform of its scene.

use super::{Lead, Scored};
use nearmiss_scene::scenario::Transform;

/// An answer, or its absence, and which variant of its scene it is about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnswerCase<'a> {
    /// The answer.
    pub scored: &'a Scored,
    /// The lead that its window was asked at; `None` where the batch names none, and outside of batches.
    pub lead: Option<Lead>,
}

impl<'a> AnswerCase<'a> {
    /// Answers about scenes without named leads.
    pub fn all(scored: &'a [Scored]) -> Vec<Self> {
        let case = |scored| Self { scored, lead: None };
        scored.iter().map(case).collect()
    }

    /// Name of the scenario as it was before a transform.
    #[must_use]
    pub fn scenario(&self) -> &'a str {
        Transform::of_name(&self.scored.scenario).0
    }

    /// The transform of its scene; `None` for the scene as it is.
    #[must_use]
    pub fn transform(&self) -> Option<Transform> {
        Transform::of_name(&self.scored.scenario).1
    }

    /// The lead in words: `1 s`, or `end`; `None` without one.
    #[must_use]
    pub fn lead_words(&self) -> Option<String> {
        self.lead.map(|lead| match lead {
            Lead::Paper => "end".into(),
            Lead::Seconds(_) => format!("{lead} s"),
        })
    }
}

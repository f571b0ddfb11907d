//! What a bundle of an experiment says about the scene of a question, so that reports need no scenario file.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use nearmiss_scene::verdict::Verdict;

/// What was read off the scenario of a question where its batch was packed.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SceneRecord {
    /// The built-in judge's verdict; `None` if it was not needed or could not be asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Verdict>,
    /// Why the built-in judge could not be asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unjudged: Option<String>,
    /// From the ids of renumbered obstacles to those in the file; empty if nothing was renumbered.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub ids: BTreeMap<i64, i64>,
}

impl SceneRecord {
    /// The verdict of the built-in judge, or why there is none; `None` if nothing is recorded of it.
    #[must_use]
    pub fn judgement(&self) -> Option<Result<Verdict, String>> {
        match (&self.reference, &self.unjudged) {
            (Some(verdict), _) => Some(Ok(verdict.clone())),
            (None, Some(why)) => Some(Err(why.clone())),
            (None, None) => None,
        }
    }
}

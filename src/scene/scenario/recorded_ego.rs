//! The ego that a recording of a data set is about: one of its tracks, and not among the obstacles while it is the ego.

use std::sync::Arc;

use super::{Ego, EgoSource, Obstacle, Scenario};

/// The track that is the ego of a recording, as long as no other is chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedEgo {
    /// The track, with its size; its id is that of its planning problem too.
    pub obstacle: Obstacle,
    /// The file, as messages name it.
    pub file: String,
}

impl RecordedEgo {
    /// It as the ego; `None` if it has no body.
    #[must_use]
    pub fn ego(&self) -> Option<Ego> {
        Some(Ego {
            id: self.obstacle.id,
            source: EgoSource::Recording(self.file.clone()),
            footprint: self.obstacle.footprint.clone()?,
            track: self.obstacle.track().clone(),
            recorded: Vec::new(),
            diagnostics: Vec::new(),
        })
    }
}

impl Scenario {
    /// The scenario for an ego that is one of its obstacles: the recording's own ego is an obstacle then, as any other.
    pub(super) fn for_taken_ego(self: Arc<Self>) -> Arc<Self> {
        if self.recorded_ego.is_none() {
            return self;
        }
        let mut scenario = Arc::unwrap_or_clone(self);
        let own = scenario.recorded_ego.take().map(|own| own.obstacle);
        scenario.obstacles.extend(own);
        Arc::new(scenario)
    }
}

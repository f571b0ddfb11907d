//! What became of the traffic in a drive.

use std::sync::Arc;

use crate::simulation::{ContactSide, Outcome, Rollout};
use nearmiss_scene::scenario::Scenario;

/// The others during a drive.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DrivenTraffic {
    /// The scenario as it was driven, where an obstacle reacted; else all drove as recorded. Obstacles that reacted have
    /// no motion after the last step of the drive.
    pub scenario: Option<Arc<Scenario>>,
    /// Which obstacles reacted, in order of time.
    pub reactions: Vec<Reaction>,
}

/// An obstacle that reacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reaction {
    /// Its id.
    pub obstacle: i64,
    /// The step of its last recorded state; it reacts from the next one on.
    pub from: i64,
}

/// Traffic that drove into the ego's rear.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HitFromBehind {
    /// It followed its recording, and knew nothing of the ego: such a contact says little about the ego.
    Unaware,
    /// It reacted, too late.
    Reacting,
}

impl HitFromBehind {
    /// Its name in documents.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Unaware => "unaware",
            Self::Reacting => "reacting",
        }
    }
}

impl Rollout {
    /// The scenario as it was driven, of a drive through `recorded`.
    #[must_use]
    pub fn scenario_in<'a>(&'a self, recorded: &'a Scenario) -> &'a Scenario {
        self.traffic.scenario.as_deref().unwrap_or(recorded)
    }

    /// Whether an obstacle drove into the ego's rear with its front, and whether it reacted to the ego.
    #[must_use]
    pub fn hit_from_behind(&self) -> Option<HitFromBehind> {
        let Outcome::Collision(collision) = self.outcome else {
            return None;
        };
        if collision.ego != ContactSide::Rear || collision.other != ContactSide::Front {
            return None;
        }
        let mut reactions = self.traffic.reactions.iter();
        Some(if reactions.any(|r| r.obstacle == collision.with) {
            HitFromBehind::Reacting
        } else {
            HitFromBehind::Unaware
        })
    }
}

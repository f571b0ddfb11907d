//! Messages and effects of planning the ego of a scenario.

use crate::formats::Entry;
use crate::planner::Forecast;
use crate::scenario::Transform;
use crate::tui::loaded::{DriveFiles, DriveKey, Opened};

/// Numbers the drives of the planner; a message of an old one is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct PlanId(pub u64);

/// What planning is asked for.
#[derive(Debug)]
pub enum PlanAsk {
    /// Plan the ego of a scenario, after a change of its scene if there is one, under a forecast.
    Begin(PlanId, Entry, Option<Transform>, Forecast),
    /// Stop that; nothing more is heard of it.
    Stop(PlanId),
    /// Write a planned ego.
    Save(Box<DriveFiles>),
}

/// What is heard of planning.
#[derive(Debug)]
pub enum PlanNews {
    /// So many steps are planned, of so many at most.
    Planned(PlanId, usize, usize),
    /// It has ended: the scenario with the planned ego, or why there is none.
    Ended(PlanId, Result<Box<Opened>, String>),
    /// A planned ego was written: the files, or why not.
    Saved(DriveKey, Result<String, String>),
}

impl PlanNews {
    /// The drive that is under way or has just ended.
    #[must_use]
    pub fn id(&self) -> Option<PlanId> {
        match self {
            Self::Planned(id, ..) | Self::Ended(id, _) => Some(*id),
            Self::Saved(..) => None,
        }
    }
}

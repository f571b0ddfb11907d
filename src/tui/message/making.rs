//! Messages and effects of making a scenario dangerous.

use std::path::PathBuf;
use std::sync::Arc;

use crate::evaluation::generating::Progress;
use crate::tui::loaded::{Generated, Made, VariantRequest, Working};

/// Numbers the searches; a message of an old one is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct MakeId(pub u64);

/// What is asked for.
#[derive(Debug)]
pub enum MakeAsk {
    /// Make a scenario dangerous.
    Begin(MakeId, Box<VariantRequest>),
    /// Stop that; all that is heard of it then is that it has ended.
    Stop(MakeId),
    /// Write a variant into a folder; the current one if none is named.
    Save(Arc<Made>, Option<PathBuf>),
}

/// What is heard of it.
#[derive(Debug)]
pub enum MakeNews {
    /// What is being done.
    Working(MakeId, Working),
    /// What happens while a model writes.
    Heard(MakeId, Progress),
    /// It was stopped, and has ended.
    Stopped(MakeId),
    /// It has ended: what was found, or why nothing could be tried.
    Ended(MakeId, Result<Generated, String>),
    /// A variant was written: the files, or why not.
    Saved(Arc<Made>, Result<String, String>),
}

impl MakeNews {
    /// The search that it is about.
    #[must_use]
    pub fn id(&self) -> Option<MakeId> {
        match self {
            Self::Working(id, _) | Self::Heard(id, _) | Self::Stopped(id) | Self::Ended(id, _) => {
                Some(*id)
            }
            Self::Saved(..) => None,
        }
    }
}

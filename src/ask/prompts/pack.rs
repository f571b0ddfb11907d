//! Packs of templates: sets that ask the same tasks in different ways.

use serde::Deserialize;

/// A set of templates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Pack {
    /// The program's own way of asking.
    #[default]
    Standard,
    /// The way of "From Words to Collisions": its parts, thresholds and JSON keys.
    Paper,
}

impl Pack {
    /// Every pack.
    pub const ALL: [Self; 2] = [Self::Standard, Self::Paper];

    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Standard => "standard",
            Self::Paper => "paper",
        }
    }

    /// The pack with this name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|pack| pack.name() == name)
    }
}

nearmiss_record::word!(Pack, "pack");

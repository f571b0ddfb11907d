//! What scenarios are written as, by name or by the ending of the file.

use std::path::Path;

use serde::Serialize;
use strum::{EnumMessage, IntoStaticStr, VariantArray};

/// The ending of roads beside OpenSCENARIO.
pub const ROADS: &str = "xodr";

/// How the tracks of a recording in the shape of highD are called.
pub(super) const HIGHD_TRACKS: &str = "_tracks.csv";

/// The endings that tell a format, in words.
pub const ENDINGS: &str =
    ".xml (CommonRoad), .xosc (OpenSCENARIO), .arrow, .csv or .parquet (tracks)";

/// What scenarios are written as.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, EnumMessage, IntoStaticStr, VariantArray, Serialize,
)]
#[strum(serialize_all = "lowercase")]
#[serde(into = "&'static str")]
pub enum Target {
    /// CommonRoad 2020a XML, with the ego in a file beside it.
    CommonRoad,
    /// CommonRoad 2018b XML, with the ego in a file beside it.
    #[strum(serialize = "commonroad-2018b")]
    CommonRoad2018b,
    /// OpenSCENARIO and OpenDRIVE: FILE.xosc and FILE.xodr.
    OpenScenario,
    /// Table of tracks: .csv, .parquet or .arrow (`nearmiss help tracks`).
    Tracks,
    /// Table in the format of the INTERACTION Dataset.
    Interaction,
    /// The three tables of a recording in the format of highD.
    HighD,
}

nearmiss_record::named!(Target);

impl Target {
    /// Endings of its files, the usual one first.
    #[must_use]
    pub fn endings(self) -> &'static [&'static str] {
        match self {
            Self::CommonRoad | Self::CommonRoad2018b => &["xml"],
            Self::OpenScenario => &["xosc"],
            Self::Tracks => &["csv", "parquet", "arrow"],
            Self::Interaction | Self::HighD => &["csv"],
        }
    }

    /// The format that the ending of a file means.
    #[must_use]
    pub fn of_ending(file: &Path) -> Option<Self> {
        let mut usual = [Self::CommonRoad, Self::OpenScenario, Self::Tracks].into_iter();
        usual.find(|target| {
            target
                .endings()
                .iter()
                .any(|ending| ends_with(file, ending))
        })
    }

    /// The file of a scenario in a folder.
    #[must_use]
    pub fn file_name(self, scenario: &str) -> String {
        match self {
            Self::HighD => format!("{scenario}{HIGHD_TRACKS}"),
            _ => format!("{scenario}.{}", self.endings()[0]),
        }
    }

    /// Whether the ego is in its files.
    #[must_use]
    pub fn has_ego(self) -> bool {
        !matches!(self, Self::CommonRoad | Self::CommonRoad2018b)
    }
}

/// Whether a file has this ending, in whatever case.
#[must_use]
pub fn ends_with(file: &Path, ending: &str) -> bool {
    let own = file.extension();
    own.is_some_and(|own| own.eq_ignore_ascii_case(ending))
}

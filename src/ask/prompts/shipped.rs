//! The templates and fragments that come with the program, and packs: sets that ask the same tasks in different ways.

use strum::{IntoStaticStr, VariantArray};

/// A file that comes with the program.
#[derive(Debug, Clone, Copy)]
pub struct Shipped {
    /// File name.
    pub file: &'static str,
    /// Its text.
    pub source: &'static str,
}

/// Files of `prompts/`, by name.
macro_rules! shipped {
    ($($file:literal),+ $(,)?) => {
        &[$(Shipped {
            file: $file,
            source: include_str!(concat!("../../../prompts/", $file)),
        }),+]
    };
}

/// Every file, by name.
pub(super) const SHIPPED: &[Shipped] = shipped![
    "_answer.md",
    "_cartesian.md",
    "_critical.md",
    "_ego.md",
    "_horizon.md",
    "_metrics.md",
    "_paper-answer.md",
    "_paper-risk.md",
    "_picture.md",
    "_recording.md",
    "_risk.md",
    "_scene.md",
    "attacker-ego.md",
    "attacker-metrics.md",
    "attacker-picture.md",
    "collision-cartesian.md",
    "collision-ego.md",
    "collision-metrics.md",
    "collision-picture.md",
    "paper-collision-cartesian.md",
    "paper-collision-ego.md",
    "paper-safety-cartesian.md",
    "paper-safety-ego.md",
    "recording-ego.md",
    "recording-metrics.md",
    "safety-cartesian.md",
    "safety-ego.md",
    "safety-metrics.md",
    "safety-picture.md",
    "trajectory.md",
];

/// A set of templates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Pack {
    /// The program's own way of asking.
    #[default]
    Standard,
    /// The way of "From Words to Collisions": its parts, thresholds and JSON keys.
    Paper,
}

nearmiss_record::named!(Pack, "pack");

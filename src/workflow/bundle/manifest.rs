//! The first member of a bundle: what is in it, and what it was made from.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use nearmiss_study::evaluation::Provenance;

/// The form of bundles that this version writes, and the latest that it reads.
pub const FORMAT: u32 = 1;

/// What a bundle contains.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Manifest {
    /// The form of the bundle.
    pub nearmiss_bundle: u32,
    /// When it was packed, milliseconds since 1970, UTC.
    pub created_ms: i64,
    /// What its answers were made from.
    pub provenance: Provenance,
    /// Questions of the batch.
    pub questions: u64,
    /// Stored runs: answers, and attempts without one.
    pub runs: u64,
    /// Ratings of these answers.
    pub ratings: u64,
    /// The scenarios that were asked about.
    pub scenarios: Vec<PackedScenario>,
    /// What is in the file behind the manifest, in order.
    pub members: Vec<Member>,
}

/// A scenario that was asked about.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct PackedScenario {
    /// Its path below the folder that was asked about, or the name of a bundled one.
    pub path: String,
    /// SHA-256 of the scenario; null if it could not be read.
    pub sha256: Option<String>,
    /// Whether its files are in the bundle.
    pub included: bool,
}

/// A part of a bundle.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Member {
    /// Its path, with `/` between the parts.
    pub name: String,
    /// Bytes.
    pub bytes: u64,
    /// SHA-256.
    pub sha256: String,
}

/// The experiment file.
pub(super) const EXPERIMENT: &str = "experiment.toml";
/// The user's thresholds.
pub(super) const THRESHOLDS: &str = "thresholds.toml";
/// Templates and fragments.
pub(super) const TEMPLATES: &str = "templates/";
/// Files with labels.
pub(super) const TRUTH: &str = "truth/";
/// Scenarios and their egos.
pub(super) const SCENARIOS: &str = "scenarios/";
/// The batch, its runs, and its questions with truth, as lines of an export.
pub(super) const BATCH: &str = "batch.jsonl";
/// Ratings, one a line.
pub(super) const RATINGS: &str = "ratings.jsonl";

/// Bytes of the longest path below a folder, and of the longest of its parts that file systems take.
const LONGEST: usize = 1000;
const LONGEST_PART: usize = 255;

/// Whether a name is one that bundles have, and stays below the folder that it is written to.
pub(super) fn is_safe(name: &str) -> bool {
    let known = [EXPERIMENT, THRESHOLDS, BATCH, RATINGS].contains(&name)
        || [TEMPLATES, TRUTH, SCENARIOS].iter().any(|folder| {
            name.strip_prefix(folder)
                .is_some_and(|rest| !rest.is_empty())
        });
    let is_safe = |part: &str| part.len() <= LONGEST_PART && part == safe_part(part);
    known && name.len() <= LONGEST && name.split('/').all(is_safe)
}

/// A part of a path that every system takes.
fn safe_part(part: &str) -> String {
    let allowed = |c: char| !c.is_control() && !"\\:*?\"<>|".contains(c);
    let safe: String = part
        .chars()
        .map(|c| if allowed(c) { c } else { '_' })
        .collect();
    match safe
        .trim_matches(|c: char| c.is_whitespace())
        .trim_end_matches('.')
    {
        "" => "_".into(),
        trimmed => trimmed.into(),
    }
}

/// A path whose parts every system takes.
pub(super) fn safe(path: &str) -> String {
    let parts: Vec<String> = path.split('/').map(safe_part).collect();
    parts.join("/")
}

/// Whether a member is a file of the folder that is unpacked into.
pub(super) fn is_file(name: &str) -> bool {
    name != BATCH && name != RATINGS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_below_the_folder_are_safe() {
        for name in [
            "experiment.toml",
            "templates/a.md",
            "scenarios/x/a b.xml",
            "batch.jsonl",
        ] {
            assert!(is_safe(name), "{name}");
        }
        for name in [
            "",
            "/etc/passwd",
            "scenarios/../../x",
            "scenarios//x",
            "scenarios/",
            "scenarios/./x",
            "scenarios/a\\..\\b",
            "templates/C:x",
            "other/x",
            "experiment.toml/x",
            "scenarios/\u{1b}[2J",
            "scenarios/x.",
        ] {
            assert!(!is_safe(name), "{name}");
        }
        let long = |bytes: usize| format!("scenarios/{}/a.xml", "x".repeat(bytes));
        assert!(is_safe(&long(255)) && !is_safe(&long(256)));
        assert_eq!(safe("a:b/../c\n.xml"), "a_b/_/c_.xml");
    }
}

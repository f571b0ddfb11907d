//! The names of scenarios with a candidate motion.

/// What is put behind a scenario's name where it has a motion in it that is only a candidate.
pub(super) const CANDIDATE: &str = " with a candidate motion";

/// The name of the scenario that a candidate motion was put into; another name as it is.
#[must_use]
pub fn unchanged_name(name: &str) -> &str {
    name.strip_suffix(CANDIDATE).unwrap_or(name)
}

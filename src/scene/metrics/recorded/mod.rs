//! Measures of the recording: what the bodies do from a step on, as it was recorded.

pub(super) mod closest;
pub(super) mod conflict;
pub(super) mod manoeuvre;
mod swept;

pub(super) use closest::Closest;
pub(super) use conflict::Conflict;
pub(super) use manoeuvre::Starts;
pub(super) use swept::Swept;

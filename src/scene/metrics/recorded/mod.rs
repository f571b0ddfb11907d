//! Measures of the recording: what the bodies do from a step on, as it was recorded.

mod closest;
pub(super) mod closest_distance;
mod conflict;
pub(super) mod encroachment;
pub(super) mod first_overlap;
mod manoeuvre;
pub(super) mod post_encroachment;
mod starts;
mod swept;
pub(super) mod time_to_closest;
pub(super) mod time_to_manoeuvre;

pub(super) use closest::Closest;
pub(super) use conflict::Conflict;
pub(super) use manoeuvre::Manoeuvre;
pub(super) use starts::Starts;
pub(super) use swept::Swept;

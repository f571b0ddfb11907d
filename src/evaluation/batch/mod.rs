//! Questions in bulk: a matrix of ways of asking over many scenarios, written into the store and gone on with at will.

mod agreement;
mod asked_words;
mod asking;
mod counted;
mod estimate;
mod handing;
mod matrix;
mod paused;
mod question_builder;
mod recent;
mod scored;
mod shard;
mod spec;
mod truth;
mod variant;

pub use agreement::{Unjudged, beside_the_judge};
pub use asked_words::Described;
pub use asking::{Asking, Ended, Judges, Selection};
pub use counted::{BatchResults, Counting, Offer, Part, counted, offers};
pub use estimate::Estimate;
pub use handing::Handed;
pub use matrix::{Matrix, More, RequestSettings};
pub use paused::Paused;
pub use question_builder::{Ask, Desk, PreparedQuestions, Reading};
pub use scored::{Answers, Relabelled, answers, retold, scored, way_of};
pub use shard::Shard;
pub use spec::{Spec, SpecError};
pub use truth::{Truth, TruthError, TruthSource};
pub use variant::Variant;

#[cfg(test)]
mod tests;

//! Batches: a matrix of prompt configurations over many scenarios, and the results of their stored answers.
//!
//! [`crate::workflow::batch`] asks them.

mod agreement;
mod answer_set;
mod estimate;
mod matrix;
mod question_builder;
mod recent;
mod request_summary;
mod scored;
mod shard;
mod spec;
mod truth;
mod variant;

pub use agreement::{UnjudgedScenario, beside_the_judge};
pub use answer_set::{
    AnswerSet, BatchPart, BatchResults, CountingChoice, OtherTruth, counted, offers,
};
pub use estimate::{Estimate, Price, Size};
pub use matrix::{Matrix, MatrixAdditions, RequestSettings};
pub use question_builder::{Ask, PreparedQuestions, QuestionBuilder, Reading, question_key};
pub use request_summary::SceneDescriptions;
pub use scored::{Answers, Relabelled, answers, label_of, retold, way_of};
pub use shard::Shard;
pub use spec::{Spec, SpecError};
pub use truth::{Truth, TruthError, TruthSource};
pub use variant::Variant;

#[cfg(test)]
mod tests;

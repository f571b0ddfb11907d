//! Batches: a matrix of prompt configurations over many scenarios, and the results of their stored answers.
//!
//! `nearmiss_workflow::batch` asks them.

mod agreement;
mod answer_set;
mod estimate;
mod experiment;
mod matrix;
mod portable;
mod prepared;
mod question_builder;
mod question_line;
mod recent;
mod request_summary;
mod scored;
mod shard;
mod spec;
mod spec_json;
mod split;
mod test_split;
mod truth;
mod variant;
mod window_facts;
mod windows;

pub use agreement::{Judgement, Judgements, UnjudgedScenario, beside_the_judge};
pub use answer_set::{
    AnswerSet, BatchPart, BatchResults, CountingChoice, OtherTruth, counted, offers,
};
pub use estimate::{Estimate, Price, Size};
pub use experiment::{ContentHash, Experiment, HASH_DIGITS, TemplatePin, TuneSettings};
pub use portable::numbered;
pub use prepared::{Ask, PreparedQuestions};
pub use question_builder::{QuestionBuilder, Reading, path_of, question_key};
pub use question_line::QuestionLine;
pub use request_summary::SceneDescriptions;
pub use scored::{Answers, answers, answers_of_part, label_of, retold, way_of};
pub use shard::Shard;
pub use spec::{Spec, SpecError};
pub use split::Split;
pub use test_split::TestSplit;
pub use truth::{Truth, TruthError, TruthSource};
pub use variant::Variant;
pub use windows::{AskedWindow, BatchWindows, WindowSource, critical_of};

#[cfg(test)]
mod axes_tests;
#[cfg(test)]
mod tests;

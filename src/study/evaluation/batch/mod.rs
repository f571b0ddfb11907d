//! Batches: a matrix of prompt configurations over many scenarios, and the results of their stored answers.
//!
//! `nearmiss_workflow::batch` asks them.

mod answer_set;
mod data_set;
mod experiment;
mod matrix;
mod prepared;
mod question_builder;
mod scored;
mod spec;
mod test_split;
mod truth;
mod windows;

pub use answer_set::{
    AnswerSet, BatchPart, BatchResults, CountingChoice, Judgement, Judgements, OtherTruth,
    UnjudgedScenario, counted, offers, with_judge_verdicts,
};
pub use data_set::{
    DataSetAnswer, DataSetCard, DataSetFacts, DataSetQuestion, DataSetRow, DataSetRows, LeftOut,
};
pub use experiment::{ContentHash, Experiment, HASH_DIGITS, TemplatePin, TuneSettings};
pub use matrix::{Shard, Split};
pub use prepared::{Ask, Estimate, PreparedQuestions, Price, Size};
pub use question_builder::{
    QuestionBuilder, QuestionLine, Reading, Variant, question_key, stored_path,
};
pub use scored::{
    Answers, answers, answers_of_part, configuration_of_item, label_of_item, relabel,
};
pub use spec::{SceneDescriptions, Spec, SpecError, numbered};
pub use test_split::TestSplit;
pub use truth::{Truth, TruthError, TruthSource};
pub use windows::{AskedWindow, BatchWindows, WindowSource, critical_obstacles};

#[cfg(test)]
mod tests;

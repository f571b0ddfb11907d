//! Jobs in the background: one id, one command, and one kind of update for all of them.

use std::path::PathBuf;
use std::sync::Arc;

use super::experiment::{
    CountedExperiment, ExperimentBatch, ExperimentNews, ExperimentQuery, ExperimentWritten,
    ItemChange, NewExperiment,
};
use super::runs::{Batch, BatchAnswer, Counts};
use crate::loaded::{GenerationOutcome, GenerationProgress, Opened, VariantRequest};
use nearmiss_ask::llm::ToolLimits;
use nearmiss_drive::planner::Forecast;
use nearmiss_formats::Entry;
use nearmiss_scene::corpus::CorpusIndex;
use nearmiss_scene::scenario::Transform;
use nearmiss_study::evaluation::{Answer, Event, Question};

/// Numbers the jobs; an event of one that has ended is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct JobId(pub u64);

/// The work of a job.
#[derive(Debug)]
pub enum JobRequest {
    /// Ask a model.
    Question {
        /// The question.
        question: Box<Question>,
        /// The model, `provider/model`.
        model: String,
        /// How often it may call tools; `None` where it may not.
        tools: Option<ToolLimits>,
        /// Whether it is asked anew where the store has its answer.
        fresh: bool,
    },
    /// Plan the ego of a scenario, after a change of its scene if there is one, under a forecast.
    Plan(Entry, Option<Transform>, Forecast),
    /// The same by the planner with this place among those of the configuration, from 1.
    PlanBy(Entry, Option<Transform>, Forecast, usize),
    /// Make a scenario dangerous.
    Generate(Box<VariantRequest>),
    /// Prepare all questions of a batch to know what they take; nothing is asked.
    Estimate(Arc<Batch>),
    /// Ask the questions of the batch that was estimated under the same id.
    Batch(Arc<Batch>),
    /// Read an experiment file and prepare its questions to know what they take; nothing is asked.
    Experiment(Box<ExperimentQuery>),
    /// Ask the questions of the experiment that was read under the same id.
    ExperimentBatch(ExperimentBatch),
    /// Write an experiment file.
    WriteExperiment(Box<NewExperiment>),
    /// Read the index in a folder.
    Index(PathBuf),
}

/// Events of a job, by its kind.
#[derive(Debug)]
pub enum JobEvent {
    /// Pieces of an answer; then the whole answer, or why the store refused.
    Question(Update<Event, Box<Answer>>),
    /// Planned steps, and steps at most; then the scenario with the planned ego.
    Plan(Update<(usize, usize), Box<Opened>>),
    /// Making a scenario dangerous.
    Generate(Update<GenerationProgress, GenerationOutcome>),
    /// The estimate of a batch, as far as known.
    Estimate(Update<Counts, Counts>),
    /// Asking the questions of a batch.
    Batch(Update<BatchProgress, ()>),
    /// What an experiment file says, then what it would ask.
    Experiment(Update<ExperimentNews, Box<CountedExperiment>>),
    /// An experiment file was written, or not.
    ExperimentWritten(Update<(), ExperimentWritten>),
    /// Rows of an index, and rows in all; then the index.
    Index(Update<(u64, u64), Arc<CorpusIndex>>),
}

/// How far a job is; the last one tells its outcome.
#[derive(Debug)]
pub enum Update<P, T> {
    /// It goes on.
    Progress(P),
    /// It has ended: what came of it, or why it failed.
    Ended(Result<T, String>),
    /// It was cancelled, and has ended.
    Cancelled,
}

/// How far a batch is.
#[derive(Debug)]
pub enum BatchProgress {
    /// The store knows it by this name, and it has so many questions to ask.
    Named(String, usize),
    /// A question of an experiment changed its state.
    Changed(Box<ItemChange>),
    /// A question was answered, or why not.
    Answered(Result<BatchAnswer, String>),
}

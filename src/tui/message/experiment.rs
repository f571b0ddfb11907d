//! Messages of experiments: an experiment file is read and counted, asked, or written.

use std::path::PathBuf;
use std::sync::Arc;

use super::runs::Batch;
use nearmiss_ask::prompts::Library;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_store::{BatchId, ItemState, SplitPart};
use nearmiss_study::evaluation::PromptConfig;
use nearmiss_workflow::batch::DryRunLine;
use nearmiss_workflow::{ExperimentAxis, ExperimentProgress};

/// An experiment file to be read, and what it would be asked with.
#[derive(Debug)]
pub struct ExperimentQuery {
    /// The file.
    pub file: PathBuf,
    /// The part of its split that would be asked; `None` for all.
    pub part: Option<SplitPart>,
    /// The templates.
    pub library: Library,
    /// The thresholds of risk scores.
    pub thresholds: Arc<Thresholds>,
}

/// How far the reading of an experiment is.
#[derive(Debug)]
pub enum ExperimentNews {
    /// The file was read: its text, and what it says; nothing where it has mistakes.
    Read(Box<(String, Option<ExperimentOutline>)>),
    /// What takes its time now, in words.
    Working(String),
}

/// What an experiment file says, in words.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExperimentOutline {
    /// What it asks, in a line.
    pub title: Option<String>,
    /// Each axis of its matrix with the values.
    pub axes: Vec<ExperimentAxis>,
    /// How many ways of asking that makes.
    pub ways: usize,
    /// Names and values of the other keys.
    pub facts: Vec<(&'static str, String)>,
    /// Whether it splits its scenarios into dev and test.
    pub is_split: bool,
}

/// An experiment with everything counted, before it is asked.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CountedExperiment {
    /// The stored batch that is gone on with; `None` where a new one begins.
    pub batch: Option<BatchId>,
    /// How far that is; of a new one, what it would ask.
    pub progress: ExperimentProgress,
    /// What asking the rest takes, as `evaluate --dry-run` says it.
    pub lines: Vec<DryRunLine>,
    /// Requests that would be sent.
    pub requests: u64,
    /// Questions that would be answered without a request: by the built-in judge or from the store.
    pub free: u64,
    /// The cost in words.
    pub price: String,
    /// Models that cannot be asked as things stand, and why.
    pub refused: Vec<(String, String)>,
    /// Scenarios in dev and test.
    pub split: Option<(usize, usize)>,
    /// How far the test split of the batch is, with its lock and the looks at it.
    pub test: Vec<String>,
    /// What the batch cost so far, US dollars, and how many answers are of unknown cost.
    pub spent: (f64, usize),
    /// Why questions that were asked have no whole answer, and how many, the most first.
    pub reasons: Vec<(String, usize)>,
    /// Warnings about scenarios, ground truth and models.
    pub doubts: Vec<String>,
}

/// An experiment that is asked.
#[derive(Debug)]
pub struct ExperimentBatch {
    /// Its name in the list of tasks.
    pub name: String,
    /// Questions that are asked.
    pub questions: usize,
}

/// A question of an experiment changed its state.
#[derive(Debug, Clone, PartialEq)]
pub struct ItemChange {
    /// How it is asked.
    pub way: PromptConfig,
    /// Its state before.
    pub before: ItemState,
    /// Its state now.
    pub now: ItemState,
}

/// An experiment file to be written from what the workbench would ask.
#[derive(Debug)]
pub struct NewExperiment {
    /// The file.
    pub file: PathBuf,
    /// The scenarios, and how they are asked about.
    pub batch: Batch,
    /// Whether an existing file is replaced.
    pub overwrite: bool,
}

/// What became of a file that was to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ExperimentWritten {
    /// It is there.
    Written(PathBuf),
    /// There is a file of this name already.
    Exists(PathBuf),
}

//! Messages of the history of runs, of results and of batches.

use std::path::PathBuf;
use std::sync::Arc;

use nearmiss_ask::prompts::{Library, Techniques};
use nearmiss_formats::Entry;
use nearmiss_scene::description::Frame;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{Edge, Filter, Page, Run, RunId};
use nearmiss_study::evaluation::batch::{AnswerSet, CountingChoice, Estimate, Experiment};
use nearmiss_study::evaluation::{Answer, Results};
use nearmiss_workflow::TruthChoice;

/// Numbers the lists of runs that are asked for; what an old one gives is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct PageId(pub u64);

/// Requests of the history to the store.
#[derive(Debug)]
pub enum HistoryCommand {
    /// The screen is open: the store is watched.
    Open,
    /// The screen is closed.
    Close,
    /// A part of the list, of at most so many.
    Page(PageId, Filter, Edge, usize),
    /// How many runs fit.
    Count(Filter),
    /// A run whole; and the built-in judge's word on it, for which these files may be the scenario.
    Details(RunId, Vec<Entry>),
    /// Pin a run, or no longer.
    Pin(RunId, bool),
    /// Delete a run, or restore it.
    Delete(RunId, bool),
    /// Write what a person has to say about a run.
    Note(RunId, String),
    /// Write the runs that fit into a file, as JSON lines.
    Export(Filter, PathBuf),
}

/// Answers of the store to the history.
#[derive(Debug)]
pub enum HistoryEvent {
    /// A part of the list.
    Page(PageId, Edge, Result<Page, String>),
    /// How many runs fit.
    Counted(Filter, u64),
    /// A run, if it is still there.
    Details(RunId, Result<Option<Box<Run>>, String>),
    /// The built-in judge's answer to the same question: dangerous or not, where known.
    Truth(RunId, Option<bool>),
    /// The store was written to.
    Changed,
    /// A run was changed, or why not.
    Done(RunId, Result<(), String>),
    /// A file was written: what to say, or why not.
    Exported(Result<String, String>),
}

/// Requests of the results screen to the store.
#[derive(Debug)]
pub enum ResultsCommand {
    /// Stored answers counted.
    Read(ResultsQuery),
    /// A run whole.
    Run(RunId),
    /// Write these rows, with words about what they are, into new files in a folder.
    Export(Vec<Results>, String, Option<PathBuf>),
    /// Stop reading.
    Stop,
}

/// Which stored answers are counted, and against which truth.
#[derive(Debug, Clone)]
pub struct ResultsQuery {
    /// The number of the reading.
    pub id: PageId,
    /// The answers; else those of the newest batch, or all where there is no batch.
    pub answers: Option<AnswerSet>,
    /// What they are compared with.
    pub truth: TruthChoice,
    /// Files that may be their scenarios.
    pub entries: Vec<Entry>,
}

/// Answers of the store to the results screen.
#[derive(Debug)]
pub enum ResultsEvent {
    /// The counted answers.
    Read(PageId, Result<Box<CountedAnswers>, String>),
    /// How many scenarios of how many were opened to find out what is true about them.
    Judging(PageId, (usize, usize)),
    /// The files that were written.
    Exported(Result<String, String>),
    /// A run, if it is still there.
    Run(RunId, Result<Option<Box<Run>>, String>),
}

/// Counts over stored answers.
#[derive(Debug)]
pub struct CountedAnswers {
    /// Which are counted.
    pub counting: AnswerSet,
    /// The choices.
    pub offers: Vec<CountingChoice>,
    /// A row for each way of asking.
    pub rows: Vec<Results>,
    /// Questions of the batch that were not asked, or not yet, or cannot be asked; they are not counted.
    pub unasked: usize,
    /// How far the test split is that may not be counted yet.
    pub locked: Option<String>,
    /// What they are compared with.
    pub truth: TruthChoice,
    /// What else they could be compared with.
    pub truths: Vec<TruthChoice>,
    /// While scenarios are opened to find out what is true about them: how many of how many are done.
    pub judging: Option<(usize, usize)>,
}

/// One question to one model about many scenarios.
#[derive(Debug)]
pub struct Batch {
    /// The task.
    pub task: Task,
    /// From where scenes are described.
    pub frame: Frame,
    /// How it is asked.
    pub techniques: Techniques,
    /// All that is asked.
    pub experiment: Experiment,
    /// Steps in a window.
    pub history: usize,
    /// The templates.
    pub library: Library,
    /// The text of the template where it is not saved: its file and the text.
    pub draft: Option<(String, String)>,
    /// The thresholds of risk scores.
    pub thresholds: Arc<Thresholds>,
    /// The model, `provider/model`.
    pub model: String,
    /// About which scenarios.
    pub entries: Vec<Entry>,
}

/// The estimate of a batch before it is asked.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Counts {
    /// Recordings that were read to draw windows, and how many there are.
    pub read: (usize, usize),
    /// Scenarios that were looked at.
    pub looked: usize,
    /// How many safe scenarios have no window to ask about, and why.
    pub left_out: Option<String>,
    /// Those of them whose truth is unknown: they are left out.
    pub unlabelled: usize,
    /// The size of the questions.
    pub estimate: Estimate,
    /// Why nothing would be sent, as things stand.
    pub refused: Option<String>,
    /// Requests at once.
    pub at_once: usize,
    /// US dollars left of the session's budget, if there is one.
    pub budget: Option<f64>,
}

/// An answer within a batch.
#[derive(Debug)]
pub struct BatchAnswer {
    /// Its subject: hash of the scenario, ego, task.
    pub about: Option<(String, String, Task)>,
    /// The answer.
    pub answer: Box<Answer>,
    /// Whether the built-in judge says that the same question's scene is dangerous; nothing for other tasks.
    pub truth: Option<bool>,
}

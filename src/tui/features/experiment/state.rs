//! The experiment that is shown or asked, and those that were opened before.

use std::path::{Path, PathBuf};

use crate::model::JobId;
use nearmiss_store::{BatchId, SplitPart};
use nearmiss_workflow::batch::DryRunLine;
use nearmiss_workflow::{ExperimentAxis, ExperimentProgress, FolderOfExperiments};

/// Experiments that are remembered at most.
const MAX_REMEMBERED: usize = 10;

/// The state of the screen of an experiment.
#[derive(Debug, Default)]
pub struct ExperimentView {
    /// The file; `None` until one is opened.
    pub file: Option<PathBuf>,
    /// The reading of the file, whose questions can be asked once it has ended.
    pub job: Option<JobId>,
    /// What takes its time while it is read.
    pub working: Option<String>,
    /// The text of the file.
    pub text: Option<String>,
    /// What it says; `None` until it is read, and where it has mistakes.
    pub outline: Option<ExperimentOutline>,
    /// Why it cannot be asked: a line for each mistake.
    pub problem: Option<String>,
    /// What it would ask; `None` until it is counted.
    pub counted: Option<CountedExperiment>,
    /// Its questions by way of asking and state.
    pub progress: ExperimentProgress,
    /// The batch that is asked.
    pub asking: Option<JobId>,
    /// The part of its split that is asked; `None` for all.
    pub part: Option<SplitPart>,
    /// Whether asking awaits a yes.
    pub confirming: bool,
    /// Whether the text of the file is shown.
    pub shows_text: bool,
    /// Files that were opened, the last one first.
    pub recent: Vec<PathBuf>,
    /// The folder that is being looked through for files, with what is in it.
    pub folder: Option<(PathBuf, Result<FolderOfExperiments, String>)>,
    /// A file that was chosen and is to be opened.
    pub chosen: Option<PathBuf>,
    /// A file that is being written.
    pub writing: Option<JobId>,
    /// A file that is there already and would be replaced.
    pub exists: Option<PathBuf>,
}

impl ExperimentView {
    /// Begins anew with a file; what was opened before stays known.
    pub fn begin(&mut self, file: PathBuf) {
        let known = std::mem::take(self);
        *self = Self {
            file: Some(file),
            recent: known.recent,
            folder: known.folder,
            ..Self::default()
        };
    }

    /// Notes that a file was opened.
    pub fn remember(&mut self, file: &Path) {
        self.recent.retain(|known| known != file);
        self.recent.insert(0, file.to_path_buf());
        self.recent.truncate(MAX_REMEMBERED);
    }

    /// The files that can be chosen: those opened before, then those of the working folder.
    #[must_use]
    pub fn offers(&self, here: &Path) -> Vec<(PathBuf, String)> {
        let titles = |path: &Path| {
            let listed = self
                .folder
                .as_ref()
                .and_then(|(_, read)| read.as_ref().ok());
            let mut files = listed.into_iter().flat_map(|listed| &listed.files);
            let found = files.find(|file| here.join(&file.path) == *path);
            found.and_then(|file| file.title.clone())
        };
        let recent = self.recent.iter().map(|path| {
            let title = titles(path).unwrap_or_default();
            (path.clone(), format!("opened before · {title}"))
        });
        let mut offers: Vec<_> = recent.collect();
        if let Some((folder, Ok(listed))) = &self.folder
            && folder.as_os_str().is_empty()
        {
            for file in &listed.files {
                let path = here.join(&file.path);
                if !offers.iter().any(|(known, _)| *known == path) {
                    offers.push((path, file.title.clone().unwrap_or_default()));
                }
            }
        }
        offers
    }
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

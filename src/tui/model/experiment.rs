//! The experiment that is shown or asked, and those that were opened before.

use std::path::{Path, PathBuf};

use crate::message::JobId;
use crate::message::experiment::{CountedExperiment, ExperimentOutline};
use nearmiss_store::SplitPart;
use nearmiss_workflow::{ExperimentProgress, FolderOfExperiments};

/// Experiments that are remembered at most.
const MOST: usize = 10;

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
    /// Whether a job of this number is its own.
    #[must_use]
    pub fn owns(&self, id: JobId) -> bool {
        self.job == Some(id) || self.writing == Some(id)
    }

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
        self.recent.truncate(MOST);
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

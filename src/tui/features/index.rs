//! The index of a corpus: chosen, read in the background, and given to the list.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use nearmiss_base::system::shown_path;
use nearmiss_scene::corpus::CorpusIndex;
use nearmiss_scene::description::visible;
use nearmiss_scene::judge;
use nearmiss_workflow::read_index;
use ratatui::Frame;
use ratatui::layout::Rect;

use crate::action::Action;
use crate::features::jobs::notes;
use crate::features::{Screen, Step};
use crate::keymap::{Code, Key, edit_line, first_line};
use crate::message::Effect;
use crate::model::{Job, JobId, JobKind, JobState, ListIndex, Model, Picker, Update};
use crate::request::{Replies, Request};
use crate::services::Services;
use crate::widgets::hints::{Hint, fixed};
use crate::widgets::{picker, window};

/// The window.
#[derive(Debug, Default)]
pub struct IndexScreen {
    picker: Picker,
}

/// A line: the folder as it is given to the action, empty for none, and what choosing it does.
struct Row {
    folder: String,
    words: String,
}

impl Screen for IndexScreen {
    fn on_key(&mut self, model: &mut Model, key: Key) -> Option<Step> {
        match key.code {
            Code::Esc => return Some(Step::close()),
            Code::Enter => {
                let chosen = rows(model, &self.picker)
                    .into_iter()
                    .nth(self.picker.selected);
                return Some(match chosen {
                    Some(row) => {
                        model.index.typed = Some(row.folder);
                        Step::CloseAndPerform(Action::ChooseIndex)
                    }
                    None => Step::stay(),
                });
            }
            Code::Up => self.picker.selected = self.picker.selected.saturating_sub(1),
            Code::Down | Code::Tab => self.picker.selected += 1,
            _ if edit_line(&mut self.picker.text, key) => self.picker.selected = 0,
            _ => {}
        }
        Some(Step::stay())
    }

    fn paste(&mut self, _model: &mut Model, text: &str) -> Vec<Effect> {
        self.picker.text.push_str(&first_line(text));
        self.picker.selected = 0;
        Vec::new()
    }

    fn follow(&mut self, model: &mut Model) -> Vec<Effect> {
        let last = rows(model, &self.picker).len().saturating_sub(1);
        self.picker.selected = self.picker.selected.min(last);
        Vec::new()
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let inner = window::window(frame, screen, model, "index of a corpus", (92, 12));
        let rows = rows(model, &self.picker)
            .into_iter()
            .map(|row| (visible(&row.words).into_owned(), String::new()));
        picker::draw(frame, inner, model, &self.picker, &rows.collect::<Vec<_>>());
        if self.picker.text.trim().is_empty() {
            let hint =
                "type the folder of an index; `nearmiss corpus index PATH… -o FOLDER` makes one";
            picker::hint(frame, inner, model, hint);
        }
    }

    fn hints(&self, _model: &Model) -> Vec<Hint> {
        fixed(&[
            ("type", "a folder"),
            ("↑↓", "select"),
            ("Enter", "choose"),
            ("Esc", "close"),
        ])
    }
}

fn rows(model: &Model, picker: &Picker) -> Vec<Row> {
    let mut rows = Vec::new();
    let here = &model.recall.here;
    if let Some(folder) = IndexChoice::meant(&picker.text, here) {
        rows.push(Row {
            words: format!("read {}", shown_path(&folder)),
            folder: picker.text.clone(),
        });
    }
    let index = &model.index;
    if let Some(folder) = &index.folder {
        rows.push(Row {
            words: format!("read {} again", shown_path(folder)),
            folder: IndexChoice::text(Some(folder)),
        });
    }
    if let Some(folder) = &index.configured
        && index.folder.as_ref() != Some(folder)
    {
        rows.push(Row {
            words: format!("read {}, from config.toml", shown_path(folder)),
            folder: IndexChoice::text(Some(folder)),
        });
    }
    if index.folder.is_some() {
        rows.push(Row {
            words: "no index".into(),
            folder: String::new(),
        });
    }
    rows
}

/// Reads the index that was typed or chosen, else opens the window to choose one.
pub fn perform(model: &mut Model) -> Vec<Effect> {
    let Some(typed) = model.index.typed.take() else {
        model.screens.open(IndexScreen::default());
        return Vec::new();
    };
    match IndexChoice::meant(&typed, &model.recall.here.clone()) {
        Some(folder) => begin(model, folder),
        None => close(model),
    }
}

/// At the start: the index of the command line, the session or the configuration.
pub fn start(model: &mut Model) -> Vec<Effect> {
    let folder = model.index.folder.clone();
    folder.map_or_else(Vec::new, |folder| begin(model, folder))
}

/// Begins to read an index; what was being read is abandoned.
fn begin(model: &mut Model, folder: PathBuf) -> Vec<Effect> {
    let mut effects = stop(model);
    let id = JobId(model.new_id());
    model.index = IndexChoice {
        folder: Some(folder.clone()),
        configured: model.index.configured.take(),
        job: Some(id),
        ..IndexChoice::default()
    };
    model.list.set_index(ListIndex::Reading);
    effects.push(ReadIndex { id, folder }.into());
    effects
}

/// From now on there is no index.
fn close(model: &mut Model) -> Vec<Effect> {
    let effects = stop(model);
    model.index.folder = None;
    model.index.error = None;
    model.list.set_index(ListIndex::None);
    model.say("no index: terms such as road:urban do not filter");
    effects
}

fn stop(model: &mut Model) -> Vec<Effect> {
    let job = model.index.job.take();
    job.map(Effect::Cancel).into_iter().collect()
}

/// The task is cancelled by the user: there is no index then.
pub fn cancel(model: &mut Model, id: JobId) -> Vec<Effect> {
    if model.index.job == Some(id) {
        model.index.job = None;
        model.index.error = Some("reading was cancelled".into());
        model.list.set_index(ListIndex::Failed);
    }
    vec![Effect::Cancel(id)]
}

/// How far the reading is, or what came of it.
pub fn on_update(model: &mut Model, id: JobId, update: IndexUpdate) {
    if model.index.job != Some(id) {
        return;
    }
    match update {
        Update::Progress(read) => model.index.read = read,
        Update::Ended(Ok(index)) => {
            model.index.job = None;
            model.list.set_index(ListIndex::Ready(index));
        }
        Update::Ended(Err(error)) => {
            model.index.job = None;
            model.index.error = Some(error.clone());
            model.list.set_index(ListIndex::Failed);
            model.complain(format!("the index cannot be used: {}", visible(&error)));
        }
        Update::Cancelled => {
            drop(cancel(model, id));
        }
    }
}

/// Notes in the list of tasks how far it is.
pub fn note(job: &mut Job, update: &IndexUpdate, now: Duration) {
    let state = match update {
        Update::Progress((rows, all)) => {
            job.done = usize::try_from(*rows).unwrap_or(usize::MAX);
            job.of = usize::try_from(*all).unwrap_or(usize::MAX);
            return;
        }
        Update::Ended(Ok(index)) => {
            JobState::Done(format!("{} scenarios", index.scenarios().len()))
        }
        Update::Ended(Err(error)) => JobState::Failed(error.clone()),
        Update::Cancelled => JobState::Cancelled(String::new()),
    };
    job.end(state, now);
}

/// Rows between two messages on progress.
const ROWS_A_MESSAGE: u64 = 65_536;

/// Reads the index in a folder.
#[derive(Debug)]
pub struct ReadIndex {
    /// Its number.
    pub id: JobId,
    /// The folder.
    pub folder: PathBuf,
}

/// Rows of an index, and rows in all; then the index.
pub type IndexUpdate = Update<(u64, u64), Arc<CorpusIndex>>;

impl Request for ReadIndex {
    type Reply = (JobId, IndexUpdate);

    fn sent(&self, model: &mut Model) {
        let title = format!("the index {}", shown_path(&self.folder));
        let job = Job::new(self.id, JobKind::Index, title, 1, model.uptime);
        model.jobs.add(job);
    }

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let store = services.store.clone();
        services.run(self.id, replies, move |cancel, progress| {
            // Without a store nothing was asked.
            let answers = store
                .map(|store| store.verdicts(judge::MODEL, None))
                .transpose()
                .map_err(|error| error.to_string())?;
            let mut reported = 0;
            let index = read_index(
                &self.folder,
                &answers.unwrap_or_default(),
                cancel,
                &mut |rows, all| {
                    if rows >= reported + ROWS_A_MESSAGE || rows == all {
                        reported = rows;
                        progress((rows, all));
                    }
                },
            )
            .map_err(|error| error.to_string())?;
            Ok(index.map(Arc::new))
        });
    }

    fn reply(model: &mut Model, (id, update): Self::Reply) -> Vec<Effect> {
        if notes::note(model, id, |job, now| note(job, &update, now)) {
            on_update(model, id, update);
        }
        Vec::new()
    }
}

/// The chosen index; what was read of it belongs to the list.
#[derive(Debug, Clone, Default)]
pub struct IndexChoice {
    /// Its folder; `None` where there is no index.
    pub folder: Option<PathBuf>,
    /// The folder of the configuration, `None` where it names none.
    pub configured: Option<PathBuf>,
    /// The folder that was typed behind the action's name in the palette.
    pub typed: Option<String>,
    /// The job that reads it.
    pub job: Option<JobId>,
    /// Rows that were read, and rows in all.
    pub read: (u64, u64),
    /// Why it cannot be read.
    pub error: Option<String>,
}

impl IndexChoice {
    /// The folder as text; empty where there is none.
    #[must_use]
    pub fn text(folder: Option<&Path>) -> String {
        folder.map_or_else(String::new, |folder| folder.display().to_string())
    }

    /// The folder that a typed text means, of a program that was started in the folder `here`; nothing for an empty
    /// text.
    #[must_use]
    pub fn meant(text: &str, here: &Path) -> Option<PathBuf> {
        let text = text.trim();
        if text.is_empty() {
            return None;
        }
        let home = text.strip_prefix("~/").zip(std::env::home_dir());
        Some(match home {
            Some((rest, home)) => home.join(rest),
            None => here.join(text),
        })
    }
}

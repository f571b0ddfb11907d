//! The index of a corpus: chosen, read in the background, and given to the list.

use std::path::PathBuf;
use std::time::Duration;

use super::super::message::Effect;
use super::super::model::{IndexChoice, Job, JobId, JobState, ListIndex, Model, Update};
use super::super::screens::index::IndexScreen;
use super::super::tasks::index::{IndexUpdate, ReadIndex};
use nearmiss_scene::description::visible;

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

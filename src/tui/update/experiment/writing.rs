//! Writes a new experiment file from what the workbench would ask.

use super::super::super::action::Action;
use super::super::super::message::Effect;
use super::super::super::model::{Batch, JobId, Model, Update};
use super::super::super::screens::experiments;
use super::super::super::tasks::experiment::{ExperimentWritten, WriteExperiment};
use super::super::batch::batch_of;
use super::open_file;
use nearmiss_scene::verdict::Task;

/// Writes the file that was chosen from what the workbench would ask, else asks for its name.
pub fn write_new(model: &mut Model) -> Vec<Effect> {
    let Some(file) = model.experiment.chosen.take() else {
        return experiments::open_new(model);
    };
    if model.experiment.writing.is_some() {
        return Vec::new();
    }
    let batch = match new_batch(model) {
        Ok(batch) => batch,
        Err(why) => {
            model.say(why);
            return Vec::new();
        }
    };
    let overwrite = model.experiment.exists.as_ref() == Some(&file);
    model.experiment.exists = None;
    let id = JobId(model.new_id());
    model.experiment.writing = Some(id);
    let write = WriteExperiment {
        id,
        file,
        batch,
        overwrite,
    };
    vec![write.into()]
}

/// What a new experiment asks, as the workbench would ask it about the marked scenarios; in words why it cannot be
/// written down.
fn new_batch(model: &Model) -> Result<Batch, String> {
    let entries = model.marks.chosen(&model.list);
    if entries.is_empty() {
        return Err("no scenarios listed".into());
    }
    if !Task::VERDICTS.contains(&model.task) {
        let key = model.look.key(Action::ToggleTask);
        return Err(format!(
            "experiments ask for verdicts, not for the {} task; {key} switches the task",
            model.task.name()
        ));
    }
    if model.frame.is_of_one_obstacle() {
        let key = model.look.key(Action::ToggleFrame);
        return Err(format!(
            "this frame needs one picked obstacle; {key} changes the frame"
        ));
    }
    if let Some((file, _)) = model.prompt.draft() {
        let [edit, discard] =
            [Action::Edit, Action::DiscardDraft].map(|action| model.look.key(action));
        return Err(format!(
            "{file} has changes that are not saved, which an experiment cannot name; {edit} edits and saves it, {discard} discards them"
        ));
    }
    let mut batch = batch_of(model, entries, None);
    batch.experiment.draw_windows();
    Ok(batch)
}

/// A file was written, or is there already, or cannot be written.
pub fn written(model: &mut Model, update: Update<(), ExperimentWritten>) -> Vec<Effect> {
    if matches!(update, Update::Progress(())) {
        return Vec::new();
    }
    model.experiment.writing = None;
    match update {
        Update::Ended(Ok(ExperimentWritten::Written(file))) => {
            let effects = open_file(model, file.clone());
            model.say(format!(
                "wrote {}",
                nearmiss_base::system::shown_path(&file)
            ));
            return effects;
        }
        Update::Ended(Ok(ExperimentWritten::Exists(file))) => {
            model.experiment.exists = Some(file);
        }
        Update::Ended(Err(why)) => model.complain(format!("not written: {why}")),
        Update::Progress(()) | Update::Cancelled => {}
    }
    Vec::new()
}

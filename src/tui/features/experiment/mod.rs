//! Experiments: opens a file, counts what it asks, asks it, or writes a new file.

pub mod draw;
pub mod list;
pub mod request;
pub mod state;

use std::path::PathBuf;

use nearmiss_scene::verdict::Task;
use nearmiss_store::SplitPart;
use nearmiss_study::evaluation::batch::{AnswerSet, BatchPart};
use ratatui::Frame;
use ratatui::layout::Rect;

use crate::action::{Action, Scope};
use crate::features::batch::request::{BatchProgress, BatchUpdate};
use crate::features::batch::{self, batch_of};
use crate::features::{Screen, Step};
use crate::keymap::{Code, Key};
use crate::message::{Effect, ExternalEdit};
use crate::model::{Batch, CountedExperiment, JobId, Model, Update};
use crate::widgets::hints::{self, Hint, fixed};
use list::ExperimentsScreen;
use request::{AskExperiment, ExperimentNews, ExperimentWritten, ReadExperiment, WriteExperiment};

/// The screen; what it shows is kept in the model, so that it is there when it is opened again.
#[derive(Debug, Default)]
pub struct ExperimentScreen {
    scroll: usize,
}

impl Screen for ExperimentScreen {
    fn scope(&self) -> Scope {
        Scope::Experiment
    }

    fn on_key(&mut self, model: &mut Model, key: Key) -> Option<Step> {
        if !model.experiment.confirming {
            return None;
        }
        match key.code {
            Code::Char('y') | Code::Enter => Some(Step::Perform(Action::Accept)),
            Code::Char('n') => Some(self.on_action(model, Action::Cancel)),
            _ => None,
        }
    }

    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        let view = &mut model.experiment;
        match action {
            // Nothing else happens until that is answered.
            _ if view.confirming => {
                view.confirming = !matches!(action, Action::Cancel | Action::Quit);
                Step::stay()
            }
            Action::Cancel => {
                // What is being read is of no use now; what is asked goes on.
                let reading = view.working.take().and(view.job.take());
                Step::Close(reading.map(Effect::Cancel).into_iter().collect())
            }
            Action::ExperimentText => {
                view.shows_text = !view.shows_text;
                self.scroll = 0;
                Step::stay()
            }
            _ => Step::Ignored,
        }
    }

    fn scroll_mut(&mut self) -> Option<&mut usize> {
        Some(&mut self.scroll)
    }

    fn moves(&self, model: &Model) -> bool {
        model.experiment.asking.is_some()
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        draw::draw(frame, screen, model, self.scroll);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        let view = &model.experiment;
        if view.confirming {
            return fixed(&[
                ("y", "ask"),
                ("Enter", "ask"),
                ("n", "cancel"),
                ("Esc", "cancel"),
            ]);
        }
        let mut idle = Vec::new();
        if view.asking.is_none() {
            idle.push(Action::StopExperiment);
        } else {
            idle.extend([Action::RunExperiment, Action::EditExperiment]);
        }
        if !view
            .outline
            .as_ref()
            .is_some_and(|outline| outline.is_split)
        {
            idle.push(Action::ExperimentPart);
        }
        hints::own_but(model, Scope::Experiment, &idle)
    }
}

/// Opens the experiment that was chosen, else the list of experiments.
pub fn open(model: &mut Model) -> Vec<Effect> {
    match model.experiment.chosen.take() {
        Some(file) => open_file(model, file),
        None => list::open(model),
    }
}

/// Opens an experiment file; one that is being asked is shown as it is.
pub fn open_file(model: &mut Model, file: PathBuf) -> Vec<Effect> {
    let file = model.recall.here.join(file);
    model.screens.close::<ExperimentsScreen>();
    model.screens.open(ExperimentScreen::default());
    let same = model.experiment.file.as_ref() == Some(&file);
    if model.experiment.asking.is_some() {
        if !same {
            let key = model.look.key(Action::TaskList);
            model.say(format!(
                "this experiment is still being asked; {key} lists the tasks"
            ));
        }
        return Vec::new();
    }
    let stop = model.experiment.job.take().map(Effect::Cancel);
    if !same {
        model.experiment.begin(file);
    }
    stop.into_iter().chain(read(model)).collect()
}

/// Reads the file and makes its questions.
fn read(model: &mut Model) -> Vec<Effect> {
    let Some(file) = model.experiment.file.clone() else {
        return Vec::new();
    };
    let id = JobId(model.new_id());
    let view = &mut model.experiment;
    view.job = Some(id);
    view.working = Some("reading the file".into());
    view.confirming = false;
    let query = ReadExperiment {
        id,
        file,
        part: view.part,
        library: model.library.clone(),
        thresholds: model.thresholds.clone(),
    };
    vec![query.into()]
}

/// Handles news of the reading.
pub fn on_read(model: &mut Model, update: Update<ExperimentNews, Box<CountedExperiment>>) {
    let view = &mut model.experiment;
    match update {
        Update::Progress(ExperimentNews::Read(read)) => {
            let (text, outline) = *read;
            view.text = Some(text);
            if !outline.as_ref().is_some_and(|outline| outline.is_split) {
                view.part = None;
            }
            view.outline = outline;
            if let Some(file) = view.file.clone() {
                view.remember(&file);
                model.recall.changed = true;
            }
        }
        Update::Progress(ExperimentNews::Working(words)) => view.working = Some(words),
        Update::Ended(Ok(counted)) => {
            view.working = None;
            view.problem = None;
            view.progress = counted.progress.clone();
            view.counted = Some(*counted);
        }
        Update::Ended(Err(why)) => {
            view.working = None;
            view.job = None;
            view.counted = None;
            // Files below the working folder are named as they would be typed.
            let here = format!(
                "{}{}",
                model.recall.here.display(),
                std::path::MAIN_SEPARATOR
            );
            view.problem = Some(match here.len() {
                1 => why,
                _ => why.replace(&here, ""),
            });
        }
        Update::Cancelled => {
            view.working = None;
            view.job = None;
        }
    }
}

/// What keys on its screen do.
pub fn perform(model: &mut Model, action: Action) -> Vec<Effect> {
    if !model.screens.is_top::<ExperimentScreen>() {
        return match model.experiment.file.clone() {
            Some(file) => open_file(model, file),
            None => open(model),
        };
    }
    match action {
        Action::RunExperiment => propose(model),
        Action::StopExperiment => return stop(model),
        Action::ExperimentResults => return results(model),
        Action::EditExperiment => return edit(model),
        Action::RereadExperiment => return read_again(model),
        Action::ExperimentPart => return next_part(model),
        _ => {}
    }
    Vec::new()
}

/// Why nothing can be asked; `None` if something can.
fn blocked(model: &Model) -> Option<String> {
    let view = &model.experiment;
    if view.asking.is_some() {
        let key = model
            .look
            .keymap
            .key_in(Action::StopExperiment, Scope::Experiment);
        return Some(format!("already running; {key} stops it"));
    }
    if view.working.is_some() {
        return Some("still counting; the cost comes first".into());
    }
    let Some(counted) = &view.counted else {
        let why = view.problem.as_ref().and_then(|why| why.lines().next());
        return Some(why.unwrap_or("the experiment is not read").to_string());
    };
    if let Some((model, why)) = counted.refused.first() {
        return Some(format!("{model}: {why}"));
    }
    let none = counted.requests + counted.free == 0;
    let [_, failed, open, _] = view.progress.sums();
    none.then(|| match failed + open {
        0 => "every question has its answer".to_string(),
        _ => "there is no question to ask".to_string(),
    })
}

/// Asks for a yes, with the cost.
fn propose(model: &mut Model) {
    match blocked(model) {
        Some(why) => model.say(why),
        None => model.experiment.confirming = true,
    }
}

/// Asks what is to be asked.
pub fn run(model: &mut Model) -> Vec<Effect> {
    model.experiment.confirming = false;
    if let Some(why) = blocked(model) {
        model.say(why);
        return Vec::new();
    }
    let view = &mut model.experiment;
    let (Some(id), Some(counted), Some(file)) = (view.job.take(), &view.counted, &view.file) else {
        return Vec::new();
    };
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let ask = AskExperiment {
        id,
        name: name.into_owned(),
        questions: usize::try_from(counted.requests + counted.free).unwrap_or(usize::MAX),
    };
    view.asking = Some(id);
    vec![ask.into()]
}

/// Stops what is asked: first new requests, then those already sent.
fn stop(model: &mut Model) -> Vec<Effect> {
    match model.experiment.asking {
        Some(id) => batch::stop(model, id),
        None => {
            model.say("nothing is asked at the moment");
            Vec::new()
        }
    }
}

/// Follows the batch of the experiment; once it is over, the file is read anew where its screen is open.
pub fn on_batch(model: &mut Model, id: JobId, update: &BatchUpdate) -> Vec<Effect> {
    let view = &mut model.experiment;
    if view.asking != Some(id) {
        return Vec::new();
    }
    match update {
        Update::Progress(BatchProgress::Changed(change)) => {
            view.progress.change(&change.way, change.before, change.now);
        }
        Update::Progress(_) => {}
        Update::Ended(_) | Update::Cancelled => {
            view.asking = None;
            view.counted = None;
            if model.screens.find::<ExperimentScreen>().is_some() {
                return read(model);
            }
        }
    }
    Vec::new()
}

/// Shows the results of the batch; a test split stays locked there.
fn results(model: &mut Model) -> Vec<Effect> {
    let view = &model.experiment;
    let running = view.asking.and_then(|id| {
        let job = model.jobs.all.iter().find(|job| job.id == id)?;
        job.batch.as_deref()?.parse().ok()
    });
    let batch = running.or_else(|| view.counted.as_ref()?.batch);
    let Some(batch) = batch else {
        model.say(match view.working {
            Some(_) => "still reading",
            None => "not run yet: there are no results",
        });
        return Vec::new();
    };
    let part = match (&view.outline, view.part) {
        (Some(outline), Some(part)) if outline.is_split => BatchPart::Split(part),
        (Some(outline), None) if outline.is_split => BatchPart::Split(SplitPart::Dev),
        _ => BatchPart::Plain,
    };
    model.results.chosen = Some(AnswerSet::Batch(batch, part));
    vec![Effect::Step(Step::Perform(Action::Results))]
}

/// Opens the file in the user's editor.
fn edit(model: &mut Model) -> Vec<Effect> {
    let view = &model.experiment;
    let Some(file) = &view.file else {
        return Vec::new();
    };
    if view.asking.is_some() {
        model.say("it is being asked: what is changed now would be another batch; stop it first");
        return Vec::new();
    }
    vec![Effect::EditOutside(ExternalEdit {
        file: file.display().to_string(),
        text: view.text.clone().unwrap_or_default(),
        copy: false,
        place: Some(file.clone()),
    })]
}

/// The user's editor has ended: the file is read anew. Without an editor the text is shown.
pub fn edited(model: &mut Model, file: &PathBuf, result: Result<String, String>) -> Vec<Effect> {
    if let Err(why) = result {
        model.complain(why);
        model.experiment.shows_text = true;
    }
    if model.experiment.file.as_ref() == Some(file) {
        read_again(model)
    } else {
        Vec::new()
    }
}

/// Reads the file again.
fn read_again(model: &mut Model) -> Vec<Effect> {
    if model.experiment.asking.is_some() {
        model.say("it is being asked; it is read again when that is over");
        return Vec::new();
    }
    let stop = model.experiment.job.take().map(Effect::Cancel);
    model.experiment.counted = None;
    model.experiment.problem = None;
    stop.into_iter().chain(read(model)).collect()
}

/// Asks about the next part of the split: both, dev, test.
fn next_part(model: &mut Model) -> Vec<Effect> {
    let view = &mut model.experiment;
    if !view
        .outline
        .as_ref()
        .is_some_and(|outline| outline.is_split)
    {
        model.say("no split; `split = { test = 0.5 }` in the file makes one");
        return Vec::new();
    }
    if view.asking.is_none() {
        view.part = match view.part {
            None => Some(SplitPart::Dev),
            Some(SplitPart::Dev) => Some(SplitPart::Test),
            Some(SplitPart::Test) => None,
        };
    }
    read_again(model)
}

/// Writes the file that was chosen from what the workbench would ask, else asks for its name.
pub fn write_new(model: &mut Model) -> Vec<Effect> {
    let Some(file) = model.experiment.chosen.take() else {
        return list::open_new(model);
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

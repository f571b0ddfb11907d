//! Marks scenarios, and asks one question about many.

use super::super::action::Action;
use std::sync::Arc;

use super::super::message::Effect;
use super::super::model::{
    Batch, Card, Column, Counts, JobId, JobKind, JobState, Model, Pane, Update,
};
use super::super::screens::batch::BatchScreen;
use super::super::tasks::batch::{BatchAnswer, BatchProgress, BatchUpdate, EstimateBatch};
use super::editing::show_error;
use super::stored_answers;
use nearmiss_formats::Entry;
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::batch::Experiment;
use nearmiss_workflow::configured_experiment;

/// Marks the selected scenario, or takes its mark away.
pub fn mark(model: &mut Model) {
    match model.list.current() {
        Some(place) => {
            let entry = model.list.rows[place].entry.clone();
            model.marks.toggle(&entry);
            let count = model.marks.count(&model.list);
            let key = model.look.key(Action::AskMarked);
            let words = match count {
                0 => format!("no scenario marked; {key} asks about all listed"),
                _ => format!("{count} marked; {key} asks about them"),
            };
            model.say(match model.focus {
                Pane::Scenarios => words,
                // Away from the list, moving keys select nothing there.
                _ => {
                    let sign = if model.marks.has(&entry) {
                        "*"
                    } else {
                        "unmarked:"
                    };
                    format!("{sign} {}; select others in the list · {words}", entry.name)
                }
            });
        }
        None => model.say("no scenario selected"),
    }
}

/// Shows what asking about the marked scenarios would take, and begins to count it.
pub fn propose(model: &mut Model) -> Vec<Effect> {
    let entries = model.marks.chosen(&model.list);
    let asked = model.model.clone();
    if asked != judge::MODEL && show_error(model) {
        return Vec::new();
    }
    if entries.is_empty() {
        model.say("no scenarios listed");
        return Vec::new();
    }
    if model.frame.is_of_one_obstacle() {
        let key = model.look.key(Action::ToggleFrame);
        model.say(format!(
            "this frame needs one picked obstacle; {key} changes the frame"
        ));
        return Vec::new();
    }
    // The built-in judge gets no prompt.
    let draft = model.prompt.draft().filter(|_| asked != judge::MODEL);
    let mut batch = batch_of(model, entries, draft);
    if Task::VERDICTS.contains(&batch.task) {
        batch.experiment.every_scenario = true;
        batch.experiment.draw_windows();
    }
    let batch = Arc::new(batch);
    let id = JobId(model.new_id());
    model.card = Some(Card {
        id,
        batch: Arc::clone(&batch),
        counts: Counts::default(),
        marked: model.marks.count(&model.list) > 0,
    });
    model.screens.open(BatchScreen);
    vec![EstimateBatch { id, batch }.into()]
}

/// A batch about these scenarios, asked as the workbench would ask, each about the window at its end. `draft` is a
/// template that is not saved.
pub fn batch_of(model: &Model, entries: Vec<Entry>, draft: Option<(String, String)>) -> Batch {
    let decided = model.decided();
    Batch {
        task: model.task,
        frame: model.frame,
        techniques: decided.techniques,
        experiment: Experiment {
            models: vec![model.model.clone()],
            tasks: vec![model.task],
            frames: vec![model.frame],
            techniques: vec![decided.techniques],
            tools: model.tool_limits().map(|_| true).into(),
            pack: model.library.pack(),
            ..configured_experiment(&model.config)
        },
        history: decided.history,
        library: model.library.clone(),
        draft,
        thresholds: model.thresholds.clone(),
        model: model.model.clone(),
        entries,
    }
}

/// Handles a batch's events; the list of tasks has them already.
pub fn on_update(model: &mut Model, id: JobId, update: BatchUpdate) {
    match update {
        Update::Progress(BatchProgress::Answered(Ok(ended))) => show(model, ended),
        Update::Progress(_) => {}
        Update::Ended(_) | Update::Cancelled => over(model, id),
    }
}

/// An answer about the scenario that is open stands among the others; what is shown stays shown.
fn show(model: &mut Model, ended: BatchAnswer) {
    let about = stored_answers::subject(model);
    let same = about.is_some_and(|of| ended.about == Some((of.scenario, of.ego, of.task)));
    let run = ended.answer.run;
    let is_it = |c: &Column| run.is_some() && c.answer().and_then(|a| a.run) == run;
    if !same || ended.answer.model == judge::MODEL || model.answers.columns.iter().any(is_it) {
        return;
    }
    let column = Column::from(*ended.answer);
    let (shown, scroll) = (model.answers.shown, model.answers.scroll);
    let kept = model.answers.columns.len();
    model.answers.add(column);
    // Adding made no room: the places of the others are as they were.
    if model.answers.columns.len() == kept + 1 {
        (model.answers.shown, model.answers.scroll) = (shown, scroll);
    }
}

/// One message for the whole batch.
fn over(model: &mut Model, id: JobId) {
    let mut all = model.jobs.all.iter().rev();
    let Some(job) = all.find(|job| job.id == id) else {
        return;
    };
    let why = job
        .why
        .as_ref()
        .map_or(String::new(), |why| format!("; first: {why}"));
    let (failed, words) = match &job.state {
        JobState::Done(words) | JobState::Cancelled(words) => (job.tally.2 > 0, words.clone()),
        JobState::Failed(words) => (true, words.clone()),
        _ => return,
    };
    let text = format!("{}: {words}{why}", job.title);
    if failed {
        model.complain(text);
    } else {
        model.tell(text);
    }
}

/// Lets every batch begin nothing more.
pub fn stop_all(model: &mut Model) -> Vec<Effect> {
    let running = model.jobs.all.iter().filter(|job| job.is_running());
    let batches = running
        .filter(|job| job.kind == JobKind::Batch)
        .map(|job| job.id);
    let batches: Vec<_> = batches.collect();
    batches.into_iter().flat_map(|id| stop(model, id)).collect()
}

/// Lets a batch begin nothing more; the second time, what it began is cancelled too.
pub fn stop(model: &mut Model, id: JobId) -> Vec<Effect> {
    model.say("no new requests; again cancels those already sent");
    vec![Effect::Cancel(id)]
}

//! Reopens the scenario of an earlier run, with the question that was asked.

use super::super::action::Action;
use super::super::message::Effect;
use super::super::model::OpenId;
use super::super::model::{Column, Model, ShownAnswer};
use super::open_changed;
use crate::features::answers;
use crate::features::experiment::ExperimentScreen;
use crate::features::history::{self, HistoryScreen};
use nearmiss_ask::prompts::Techniques;
use nearmiss_scene::description::Frame;
use nearmiss_scene::scenario::{Transform, obstacle_taken};
use nearmiss_store::Run;
use nearmiss_study::evaluation::Answer;

/// Opens the scenario of a run, if it is to be found.
pub fn begin(model: &mut Model, run: Run) -> Vec<Effect> {
    let name = run.question.scenario.clone();
    let Some(entry) = model.files_of(&name).into_iter().next() else {
        model.say(format!(
            "{name} is not in the list; start nearmiss with the folder that it is in"
        ));
        return Vec::new();
    };
    model.screens.close::<HistoryScreen>();
    model.screens.close::<ExperimentScreen>();
    let mut effects = history::leave(model);
    let listed = model.list.rows.iter().position(|row| row.entry == entry);
    let place = listed.unwrap_or_else(|| model.list.append(entry));
    model.list.show(place);
    model.zoomed = false;
    let (ego, (_, change)) = (obstacle_taken(&run.question.ego), Transform::of_name(&name));
    effects.extend(open_changed(model, place, ego, change));
    if let Some((id, _)) = model.opening {
        model.reopening = Some((id, Box::new(run)));
    }
    effects
}

/// A scenario was opened: if it was for a run, it is asked about as the run was, and the answer stands beside it.
pub fn opened(model: &mut Model, id: OpenId) {
    let Some((_, run)) = model.reopening.take_if(|(opening, _)| *opening == id) else {
        return;
    };
    let question = &run.question;
    // Answers to another question do not compare.
    if model.task != question.task {
        answers::leave(model, &question.scenario);
        model.task = question.task;
    }
    if let Some(frame) = Frame::parse(&question.frame) {
        model.frame = frame;
        model.frame_chosen = Some(frame);
    }
    if let Ok(techniques) = Techniques::parse(&question.techniques) {
        model.techniques = techniques;
        model.techniques_chosen = true;
    }
    if let Some((_, last)) = question.window {
        model.clock.playing = false;
        model.clock.go(last);
        model.placed = None;
    }
    model.refresh();
    let hash = model.opened.as_ref().map(|o| o.scenario.hash.to_string());
    let ego = model.scene().map(|scene| scene.ego.to_string());
    let mut doubts = Vec::new();
    if question.scenario_hash.is_some() && question.scenario_hash != hash {
        doubts.push("the file has changed since");
    }
    if question.scenario_hash.is_some() && ego.as_ref() != Some(&question.ego) {
        doubts.push("its ego has changed since");
    }
    let doubts: String = doubts.iter().map(|d| format!("; {d}")).collect();
    let changed = match model.opened.as_ref().and_then(|opened| opened.change) {
        Some(change) => {
            let back = model.look.key(Action::RecordedEgo);
            format!(", transformed as for the answer: {change}; {back} shows the original")
        }
        None => String::new(),
    };
    let text = format!("run {} reopened{changed}{doubts}", run.id);
    if doubts.is_empty() {
        model.say(text);
    } else {
        model.complain(text);
    }
    model.reopened = Some(run.id);
    put(model, Answer::from(*run));
}

/// Earlier answers came, and the one that was opened again was not to hide them: it takes its place among them.
pub fn before_stored(model: &mut Model) -> Option<Column> {
    let run = model.reopened.take()?;
    let only = model.answers.columns.len() == 1;
    let is_it = |column: &Column| column.answer().and_then(|a| a.run) == Some(run);
    if !only || !is_it(&model.answers.columns[0]) {
        return None;
    }
    model.answers.columns.pop()
}

/// Puts it back.
pub fn after_stored(model: &mut Model, column: Column) {
    if let Some(answer) = column.answer() {
        put(model, answer.clone());
    }
}

/// Shows an answer of the store; the same run stands there once.
fn put(model: &mut Model, answer: Answer) {
    let run = answer.run;
    let same = |c: &Column| c.answer().and_then(|a| a.run) == run;
    model.answers.columns.retain(|column| !same(column));
    model.answers.add(Column::from(answer));
    let last = model.answers.columns.len() - 1;
    model.answers.show(ShownAnswer::Column(last));
}

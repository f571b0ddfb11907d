//! The screen of results: reading the store, moving in the matrix, down to an answer and back.

use super::super::action::{Action, Scope};
use super::super::keymap::Key;
use super::super::message::Effect;
use super::super::message::runs::{PageId, ResultsAsk, ResultsNews};
use super::super::model::{Model, Overlay};
use super::{actions, keys, reopen};
use crate::evaluation::Outcome;

/// Opens the screen; what it showed before is there until the store is read.
pub fn open(model: &mut Model) -> Vec<Effect> {
    model.overlays.retain(|o| *o != Overlay::Results);
    model.overlays.push(Overlay::Results);
    let id = PageId(model.new_id());
    let entries = model.list.rows.iter().map(|row| row.entry.clone());
    let ask = ResultsAsk::Read(id, entries.collect());
    let results = &mut model.results;
    results.asked = id;
    results.reading = true;
    results.inside = None;
    results.wanted = None;
    vec![Effect::Results(ask)]
}

/// A key while the screen is on top.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    match keys::action(model, key, Scope::Results) {
        Some(Action::Cancel) => back(model),
        Some(action) => actions::perform(model, action),
        None => Vec::new(),
    }
}

/// A level back: from the answers to the matrix, from the matrix to the main screen.
pub fn back(model: &mut Model) -> Vec<Effect> {
    let results = &mut model.results;
    results.wanted = None;
    if results.inside.take().is_some() {
        return Vec::new();
    }
    model.overlays.retain(|o| *o != Overlay::Results);
    // Nobody waits for it any longer.
    model.results.asked = PageId(model.new_id());
    model.results.reading = false;
    vec![Effect::Results(ResultsAsk::Stop)]
}

/// Does something on the screen; where it is not open, it is opened and nothing else is done.
pub fn perform(model: &mut Model, action: Action) -> Vec<Effect> {
    if model.overlays.last() != Some(&Overlay::Results) {
        return open(model);
    }
    let results = &mut model.results;
    match action {
        Action::CellLeft if results.inside.is_none() => {
            results.column = results.column.saturating_sub(1);
        }
        Action::CellRight if results.inside.is_none() => {
            results.column = (results.column + 1).min(Outcome::ALL.len());
        }
        Action::OpenCell => return enter(model),
        _ => {}
    }
    Vec::new()
}

/// From a cell to its answers, from an answer to its scenario.
fn enter(model: &mut Model) -> Vec<Effect> {
    let results = &mut model.results;
    let answers = results.answers();
    let Some(place) = results.inside else {
        if answers.is_empty() {
            model.say("there is no answer in this cell");
        } else {
            results.inside = Some(0);
        }
        return Vec::new();
    };
    let Some(run) = answers.get(place).map(|answer| answer.run) else {
        return Vec::new();
    };
    results.wanted = Some(run);
    vec![Effect::Results(ResultsAsk::Run(run))]
}

/// Moves the selection.
pub fn moved(model: &mut Model, action: Action) {
    let page = isize::from(model.size.1.cast_signed() / 2).max(1);
    model.results.move_by(match action {
        Action::Up => -1,
        Action::Down => 1,
        Action::PageUp => -page,
        Action::PageDown => page,
        Action::Top => isize::MIN,
        _ => isize::MAX,
    });
}

/// What the store says.
pub fn heard(model: &mut Model, news: ResultsNews) -> Vec<Effect> {
    match news {
        ResultsNews::Read(id, result) if id == model.results.asked => {
            model.results.reading = false;
            match result {
                Ok(rows) => {
                    model.results.error = None;
                    model.results.take(rows);
                }
                Err(error) => {
                    model.results.error = Some(error.clone());
                    model.complain(error);
                }
            }
        }
        ResultsNews::Run(id, result) if model.results.wanted == Some(id) => {
            model.results.wanted = None;
            match result {
                Ok(Some(run)) => {
                    if !reopen::files(model, &run.question.scenario).is_empty() {
                        model.overlays.retain(|o| *o != Overlay::Results);
                    }
                    return reopen::begin(model, *run);
                }
                Ok(None) => model.say(format!("run {id} is no longer in the store")),
                Err(error) => model.complain(error),
            }
        }
        ResultsNews::Read(..) | ResultsNews::Run(..) => {}
    }
    Vec::new()
}

//! Text input of the history: search words, notes, file names.

use std::path::PathBuf;

use super::{moved, read};
use crate::action::Action;
use crate::keymap::{Code, Key, edit_line};
use crate::message::Effect;
use crate::model::{InputPurpose, Model};
use crate::tasks::history::HistoryCommand;
use nearmiss_store::{Edge, Filter, FilterError};

/// A key while something is typed.
pub fn typed(model: &mut Model, key: Key) -> Vec<Effect> {
    let history = &mut model.history;
    let mut line = match &history.typing {
        Some(InputPurpose::Search) => history.line.clone(),
        Some(InputPurpose::Note(_, text) | InputPurpose::Export(text)) => text.clone(),
        None => return Vec::new(),
    };
    match key.code {
        Code::Esc => {
            let searching = history.typing.take() == Some(InputPurpose::Search);
            return if searching {
                search(model, String::new())
            } else {
                Vec::new()
            };
        }
        Code::Enter => return entered(model),
        Code::Up | Code::Down if history.typing == Some(InputPurpose::Search) => {
            return moved(
                model,
                if key.code == Code::Up {
                    Action::Up
                } else {
                    Action::Down
                },
            );
        }
        _ if edit_line(&mut line, key) => {}
        _ => return Vec::new(),
    }
    put(model, line)
}

/// Text pasted while something is typed.
pub fn paste(model: &mut Model, text: &str) -> Vec<Effect> {
    let text: String = text.chars().filter(|c| !c.is_control()).collect();
    let line = match &model.history.typing {
        Some(InputPurpose::Search) => model.history.line.clone(),
        Some(InputPurpose::Note(_, text) | InputPurpose::Export(text)) => text.clone(),
        None => return Vec::new(),
    };
    put(model, line + &text)
}

fn put(model: &mut Model, line: String) -> Vec<Effect> {
    match &mut model.history.typing {
        Some(InputPurpose::Note(_, text) | InputPurpose::Export(text)) => {
            *text = line;
            Vec::new()
        }
        Some(InputPurpose::Search) | None => search(model, line),
    }
}

/// Searches as one types.
pub fn search(model: &mut Model, line: String) -> Vec<Effect> {
    let read_as = Filter::read(&line);
    let history = &mut model.history;
    history.wrong = read_as.as_ref().err().map(ToString::to_string);
    let filter = match read_as {
        Err(FilterError::Name(name)) => Filter::read(&without(&line, &name)),
        other => other,
    };
    history.line = line;
    let Ok(filter) = filter else {
        return Vec::new();
    };
    if filter == history.filter {
        return Vec::new();
    }
    history.filter = filter;
    history.total = None;
    history.newer = false;
    read(model, Edge::Newest)
}

/// The line without the filters of this name: what is no filter holds nothing back, nor does the word that it was while
/// its colon was not there.
fn without(line: &str, name: &str) -> String {
    let of_name = |part: &&str| {
        part.split_once(':')
            .is_some_and(|(before, _)| before == name)
    };
    let parts = line.split_whitespace().filter(|part| !of_name(part));
    parts.collect::<Vec<_>>().join(" ")
}

fn entered(model: &mut Model) -> Vec<Effect> {
    match model.history.typing.take() {
        Some(InputPurpose::Note(id, text)) => {
            if let Some(run) = model.history.details.as_mut().filter(|run| run.id == id) {
                run.notes.clone_from(&text);
            }
            vec![HistoryCommand::Note(id, text).into()]
        }
        Some(InputPurpose::Export(file)) if file.trim().is_empty() => {
            model.say("no file was named");
            Vec::new()
        }
        Some(InputPurpose::Export(file)) => {
            model.say(format!("writing {file} …"));
            let filter = model.history.filter.clone();
            let ask = HistoryCommand::Export(filter, PathBuf::from(file.trim()));
            vec![ask.into()]
        }
        Some(InputPurpose::Search) | None => Vec::new(),
    }
}

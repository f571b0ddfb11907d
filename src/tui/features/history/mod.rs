//! The run history: a searchable list, and the selected run beside or below it.

pub mod draw;
pub mod request;
pub mod state;

use std::path::PathBuf;

use nearmiss_store::{Edge, Filter, FilterError, RunId};
use ratatui::Frame;
use ratatui::layout::Rect;

use crate::action::{Action, Scope};
use crate::features::history::request::{HistoryCommand, HistoryEvent};
use crate::features::{Screen, Step};
use crate::keymap::{Code, Key, edit_line};
use crate::message::{Effect, Mouse};
use crate::model::{InputPurpose, Model, PAGE, PageId};
use crate::widgets::hints::{self, Hint, fixed};

/// The history of runs; what it shows is kept in the model, so that it is there again when it is reopened.
#[derive(Debug)]
pub struct HistoryScreen;

/// Opens the history, searched as it was last.
pub fn open(model: &mut Model) -> Vec<Effect> {
    model.screens.open(HistoryScreen);
    model.history.typing = None;
    model.history.on_details = false;
    model.history.wanted = None;
    let mut effects = vec![HistoryCommand::Open.into()];
    effects.extend(read(model, Edge::Newest));
    effects
}

/// Effects when it closes.
pub fn leave(model: &mut Model) -> Vec<Effect> {
    model.history.loading = None;
    model.history.typing = None;
    vec![HistoryCommand::Close.into()]
}

impl Screen for HistoryScreen {
    fn scope(&self) -> Scope {
        Scope::History
    }

    fn on_key(&mut self, model: &mut Model, key: Key) -> Option<Step> {
        let typing = model.history.typing.is_some();
        typing.then(|| Step::Stay(typed(model, key)))
    }

    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        use Action::*;
        match action {
            Cancel if model.history.typing.is_none() && !model.history.line.is_empty() => {
                return Step::Stay(search(model, String::new()));
            }
            Cancel => return Step::Close(leave(model)),
            Up | Down | PageUp | PageDown | Top | Bottom => {
                return Step::Stay(moved(model, action));
            }
            SearchRuns => model.history.typing = Some(InputPurpose::Search),
            OtherHalf => model.history.on_details = !model.history.on_details,
            ExportRuns => model.history.typing = Some(InputPurpose::Export("runs.jsonl".into())),
            UndoDelete => return Step::Stay(undo(model)),
            ReopenRun | PinRun | DeleteRun | NoteRun | CopyRun => {
                return act(model, action);
            }
            _ => return Step::Ignored,
        }
        Step::stay()
    }

    fn on_mouse(&mut self, model: &mut Model, mouse: Mouse) -> Step {
        Step::Stay(on_mouse(model, mouse))
    }

    fn paste(&mut self, model: &mut Model, text: &str) -> Vec<Effect> {
        paste(model, text)
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        draw::draw(frame, screen, model);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        match model.history.typing {
            Some(InputPurpose::Search) => fixed(&[
                ("type", "words and filters"),
                ("↑↓", "select"),
                ("Enter", "keep"),
                ("Esc", "clear"),
            ]),
            Some(InputPurpose::Note(..)) => {
                fixed(&[("type", "note"), ("Enter", "save"), ("Esc", "cancel")])
            }
            Some(InputPurpose::Export(_)) => fixed(&[
                ("type", "file name"),
                ("Enter", "export"),
                ("Esc", "cancel"),
            ]),
            None => hints::own(model, Scope::History),
        }
    }
}

/// Asks for a part of the list, in place of any other that is on its way.
fn read(model: &mut Model, edge: Edge) -> Vec<Effect> {
    let id = PageId(model.new_id());
    let history = &mut model.history;
    let most = match edge {
        Edge::Newest | Edge::From(_) => history.again().1,
        Edge::Oldest | Edge::Older(_) | Edge::Newer(_) => PAGE,
    };
    history.asked = id;
    history.loading = Some(edge);
    let ask = HistoryCommand::Page(id, history.filter.clone(), edge, most);
    vec![ask.into()]
}

/// Moves the selection, or the details.
fn moved(model: &mut Model, action: Action) -> Vec<Effect> {
    let drawn = model.drawn.history();
    let history = &mut model.history;
    let area = if history.on_details {
        drawn.details
    } else {
        drawn.list
    };
    let page = isize::from(area.height.max(2).cast_signed() - 1);
    let by = model.look.lines(action, page);
    if history.on_details {
        let last = drawn.lines.saturating_sub(usize::from(area.height));
        history.scroll = history.scroll.saturating_add_signed(by).min(last);
        return Vec::new();
    }
    match action {
        Action::Top if history.newer => {
            history.rows.clear();
            history.selected = 0;
            return read(model, Edge::Newest);
        }
        Action::Bottom if history.older => return read(model, Edge::Oldest),
        _ => history.move_by(by),
    }
    follow(model)
}

/// The mouse over the history.
fn on_mouse(model: &mut Model, mouse: Mouse) -> Vec<Effect> {
    let drawn = model.drawn.history();
    match mouse {
        Mouse::WheelUp(at) | Mouse::WheelDown(at) => {
            let up = matches!(mouse, Mouse::WheelUp(_));
            let action = if up { Action::Up } else { Action::Down };
            let kept = std::mem::replace(&mut model.history.on_details, drawn.details.contains(at));
            let lines = if model.history.on_details { 3 } else { 1 };
            let effects = (0..lines).flat_map(|_| moved(model, action)).collect();
            model.history.on_details = kept;
            effects
        }
        Mouse::Press(at) if drawn.list.contains(at) => {
            let row = drawn.top + usize::from(at.y - drawn.list.y);
            model.history.on_details = false;
            if row < model.history.rows.len() {
                model.history.selected = row;
            }
            follow(model)
        }
        Mouse::Press(at) => {
            model.history.on_details = drawn.details.contains(at);
            Vec::new()
        }
        Mouse::Drag(_) | Mouse::Release(_) => Vec::new(),
    }
}

/// Asks for what the selection needs: the run's details, and the runs around it.
fn follow(model: &mut Model) -> Vec<Effect> {
    let mut effects = details(model, false);
    if let Some(edge) = model.history.missing() {
        effects.extend(read(model, edge));
    }
    effects
}

fn details(model: &mut Model, again: bool) -> Vec<Effect> {
    let current = model.history.current();
    if current == model.history.wanted && !again {
        return Vec::new();
    }
    if current != model.history.wanted {
        model.history.scroll = 0;
    }
    model.history.wanted = current;
    let Some(id) = current else {
        model.history.details = None;
        return Vec::new();
    };
    let name = &model.history.rows[model.history.selected].scenario;
    let files = model.files_of(name);
    vec![HistoryCommand::Details(id, files).into()]
}

/// Handles the store's answers.
pub fn on_event(model: &mut Model, event: HistoryEvent) -> Step {
    let open = model.screens.find::<HistoryScreen>().is_some();
    match event {
        HistoryEvent::Page(id, edge, result) if open && id == model.history.asked => {
            model.history.loading = None;
            match result {
                Ok(page) => {
                    model.history.error = None;
                    model.history.take(edge, page);
                }
                Err(error) => {
                    model.history.error = Some(error.clone());
                    model.complain(error);
                }
            }
            let mut effects = details(model, matches!(edge, Edge::Newest | Edge::From(_)));
            if std::mem::take(&mut model.history.stale) {
                effects.extend(changed(model));
            } else if let Some(edge) = model.history.missing() {
                effects.extend(read(model, edge));
            }
            let whole = matches!(edge, Edge::Newest | Edge::From(_));
            if whole || model.history.total.is_none() {
                let filter = model.history.filter.clone();
                let count = HistoryCommand::Count(filter);
                effects.push(count.into());
            }
            return Step::Stay(effects);
        }
        HistoryEvent::Counted(filter, count) if filter == model.history.filter => {
            model.history.total = Some(count);
        }
        HistoryEvent::Details(id, Ok(run)) if model.history.wanted == Some(id) => {
            model.history.details = run;
            let then = model.history.then.take_if(|(then, _)| *then == id);
            if let Some((_, action)) = then.filter(|_| open) {
                return act(model, action);
            }
        }
        HistoryEvent::Details(id, Err(error)) if model.history.wanted == Some(id) => {
            model.complain(error);
        }
        HistoryEvent::Truth(id, truth) if model.history.wanted == Some(id) => {
            model.history.truth = Some((id, truth));
        }
        HistoryEvent::Changed if open => return Step::Stay(changed(model)),
        HistoryEvent::Done(id, Err(error)) => {
            model.history.undo.retain(|(undone, _)| *undone != id);
            model.complain(error);
            if open {
                return Step::Stay(changed(model));
            }
        }
        HistoryEvent::Done(_, Ok(())) if open => return Step::Stay(changed(model)),
        HistoryEvent::Exported(Ok(words)) => model.tell(words),
        HistoryEvent::Exported(Err(why)) => model.complain(why),
        _ => {}
    }
    Step::stay()
}

/// The store changed: what is at hand is read again, after what is on its way.
fn changed(model: &mut Model) -> Vec<Effect> {
    if model.history.loading.is_some() {
        model.history.stale = true;
        return Vec::new();
    }
    let (edge, _) = model.history.again();
    read(model, edge)
}

/// Does something with the selected run.
fn act(model: &mut Model, action: Action) -> Step {
    let history = &mut model.history;
    let Some(id) = history.current() else {
        model.say("no run is selected");
        return Step::stay();
    };
    let row = &mut history.rows[history.selected];
    match action {
        Action::PinRun => {
            row.pinned = !row.pinned;
            return Step::Stay(vec![HistoryCommand::Pin(id, row.pinned).into()]);
        }
        Action::DeleteRun if row.pinned => {
            let key = model.look.key(Action::PinRun);
            model.say(format!("run {id} is pinned; {key} unpins it"));
            return Step::stay();
        }
        Action::DeleteRun => {
            let deleted = !history.filter.deleted;
            history.undo.push((id, deleted));
            forget(model, id);
            let word = if deleted { "deleted" } else { "restored" };
            let key = model.look.key(Action::UndoDelete);
            model.say(format!("run {id} {word}; {key} takes that back"));
            let mut effects = vec![HistoryCommand::Delete(id, deleted).into()];
            effects.extend(follow(model));
            return Step::Stay(effects);
        }
        _ => {}
    }
    history.then = None;
    let Some(run) = history.shown().cloned() else {
        // Keys may be faster than the store.
        history.then = Some((id, action));
        return Step::stay();
    };
    match action {
        Action::NoteRun => model.history.typing = Some(InputPurpose::Note(id, run.notes)),
        Action::CopyRun => {
            let text = if run.reasoning.is_empty() {
                run.answer
            } else {
                format!("{}\n\n{}", run.reasoning, run.answer)
            };
            model.say(format!("{} characters copied", text.chars().count()));
            return Step::Stay(vec![Effect::Copy(text)]);
        }
        _ => return Step::Reopen(Box::new(run)),
    }
    Step::stay()
}

/// Takes a run off the list.
fn forget(model: &mut Model, id: RunId) {
    let history = &mut model.history;
    history.rows.retain(|run| run.run != id.0);
    history.selected = history.selected.min(history.rows.len().saturating_sub(1));
    history.total = history.total.map(|n| n.saturating_sub(1));
}

/// Takes the last deletion back.
fn undo(model: &mut Model) -> Vec<Effect> {
    let Some((id, deleted)) = model.history.undo.pop() else {
        model.say("nothing was deleted in this session");
        return Vec::new();
    };
    let word = if deleted {
        "is back"
    } else {
        "is deleted again"
    };
    model.say(format!("run {id} {word}"));
    vec![HistoryCommand::Delete(id, !deleted).into()]
}

/// A key while something is typed.
fn typed(model: &mut Model, key: Key) -> Vec<Effect> {
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
fn paste(model: &mut Model, text: &str) -> Vec<Effect> {
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
fn search(model: &mut Model, line: String) -> Vec<Effect> {
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

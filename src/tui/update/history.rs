//! The history of runs: searching, moving, changing runs and taking that back.

mod typing;

pub use typing::paste;
use typing::{search, typed};

use super::super::action::{Action, Scope};
use super::super::keymap::Key;
use super::super::message::runs::{HistoryAsk, HistoryNews, PageId};
use super::super::message::{Effect, Mouse};
use super::super::model::{Model, Overlay, PAGE, Typing};
use super::{actions, keys, reopen};
use crate::store::{Edge, Filter, RunId};

/// Opens the history, with this line to search for.
pub fn open(model: &mut Model, line: Option<String>) -> Vec<Effect> {
    model.overlays.retain(|o| *o != Overlay::History);
    model.overlays.push(Overlay::History);
    if let Some(line) = line {
        model.history.line = line;
        model.history.filter = Filter::read(&model.history.line).unwrap_or_default();
        model.history.wrong = None;
        model.history.rows.clear();
        model.history.selected = 0;
        model.history.total = None;
    }
    model.history.typing = None;
    model.history.on_details = false;
    model.history.wanted = None;
    let mut effects = vec![Effect::History(HistoryAsk::Open)];
    effects.extend(read(model, Edge::Newest));
    effects
}

/// Closes it.
pub fn close(model: &mut Model) -> Vec<Effect> {
    model.overlays.retain(|o| *o != Overlay::History);
    model.history.loading = None;
    model.history.typing = None;
    vec![Effect::History(HistoryAsk::Close)]
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
    let ask = HistoryAsk::Page(id, history.filter.clone(), edge, most);
    vec![Effect::History(ask)]
}

/// A key while the history is on top.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    if model.history.typing.is_some() {
        return typed(model, key);
    }
    match keys::action(model, key, Scope::History) {
        Some(Action::Cancel) if !model.history.line.is_empty() => search(model, String::new()),
        Some(Action::Cancel) => close(model),
        Some(action) => actions::perform(model, action),
        None => Vec::new(),
    }
}

/// Does something in the history; where it is not open, it is opened and nothing else is done.
pub fn perform(model: &mut Model, action: Action) -> Vec<Effect> {
    if model.overlays.last() != Some(&Overlay::History) {
        return open(model, None);
    }
    match action {
        Action::SearchRuns => model.history.typing = Some(Typing::Search),
        Action::OtherHalf => model.history.on_details = !model.history.on_details,
        Action::ExportRuns => model.history.typing = Some(Typing::Export("runs.jsonl".into())),
        Action::UndoDelete => return undo(model),
        Action::ReopenRun
        | Action::PinRun
        | Action::DeleteRun
        | Action::NoteRun
        | Action::CopyRun => return on_run(model, action),
        _ => {}
    }
    Vec::new()
}

/// Does something with the selected run.
fn on_run(model: &mut Model, action: Action) -> Vec<Effect> {
    let history = &mut model.history;
    let Some(id) = history.current() else {
        model.say("no run is selected");
        return Vec::new();
    };
    let row = &mut history.rows[history.selected];
    match action {
        Action::PinRun => {
            row.pinned = !row.pinned;
            return vec![Effect::History(HistoryAsk::Pin(id, row.pinned))];
        }
        Action::DeleteRun if row.pinned => {
            model.say(format!("run {id} is pinned; p unpins it"));
            return Vec::new();
        }
        Action::DeleteRun => {
            let deleted = !history.filter.deleted;
            history.undo.push((id, deleted));
            forget(model, id);
            let word = if deleted { "deleted" } else { "restored" };
            model.say(format!("run {id} {word}; u takes that back"));
            let mut effects = vec![Effect::History(HistoryAsk::Delete(id, deleted))];
            effects.extend(follow(model));
            return effects;
        }
        _ => {}
    }
    history.then = None;
    let Some(run) = history.shown().cloned() else {
        // Keys may be faster than the store.
        history.then = Some((id, action));
        return Vec::new();
    };
    match action {
        Action::NoteRun => model.history.typing = Some(Typing::Note(id, run.notes)),
        Action::CopyRun => {
            let text = match run.reasoning.is_empty() {
                true => run.answer,
                false => format!("{}\n\n{}", run.reasoning, run.answer),
            };
            model.say(format!("{} characters copied", text.chars().count()));
            return vec![Effect::Copy(text)];
        }
        _ => return reopen::begin(model, run),
    }
    Vec::new()
}

/// Takes a run off the list.
fn forget(model: &mut Model, id: RunId) {
    let history = &mut model.history;
    history.rows.retain(|run| run.run != id.0);
    history.selected = history.selected.min(history.rows.len().saturating_sub(1));
    history.total = history.total.map(|n| n.saturating_sub(1));
}

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
    vec![Effect::History(HistoryAsk::Delete(id, !deleted))]
}

/// Moves the selection, or the details.
pub fn moved(model: &mut Model, action: Action) -> Vec<Effect> {
    let drawn = model.drawn.history();
    let history = &mut model.history;
    let area = if history.on_details {
        drawn.details
    } else {
        drawn.list
    };
    let page = isize::from(area.height.max(2).cast_signed() - 1);
    let by = match action {
        Action::Up => -1,
        Action::Down => 1,
        Action::PageUp => -page,
        Action::PageDown => page,
        Action::Top => isize::MIN,
        _ => isize::MAX,
    };
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
pub fn on_mouse(model: &mut Model, mouse: Mouse) -> Vec<Effect> {
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
    let files = reopen::files(model, name);
    vec![Effect::History(HistoryAsk::Details(id, files))]
}

/// What the store says.
pub fn heard(model: &mut Model, news: HistoryNews) -> Vec<Effect> {
    let open = model.overlays.contains(&Overlay::History);
    match news {
        HistoryNews::Page(id, edge, result) if open && id == model.history.asked => {
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
                let count = HistoryAsk::Count(filter);
                effects.push(Effect::History(count));
            }
            return effects;
        }
        HistoryNews::Counted(filter, count) if filter == model.history.filter => {
            model.history.total = Some(count);
        }
        HistoryNews::Details(id, Ok(run)) if model.history.wanted == Some(id) => {
            model.history.details = run;
            let then = model.history.then.take_if(|(then, _)| *then == id);
            if let Some((_, action)) = then.filter(|_| open) {
                return on_run(model, action);
            }
        }
        HistoryNews::Details(id, Err(error)) if model.history.wanted == Some(id) => {
            model.complain(error);
        }
        HistoryNews::Truth(id, truth) if model.history.wanted == Some(id) => {
            model.history.truth = Some((id, truth));
        }
        HistoryNews::Changed if open => return changed(model),
        HistoryNews::Done(id, Err(error)) => {
            model.history.undo.retain(|(undone, _)| *undone != id);
            model.complain(error);
            if open {
                return changed(model);
            }
        }
        HistoryNews::Done(_, Ok(())) if open => return changed(model),
        HistoryNews::Exported(Ok(words)) => model.tell(words),
        HistoryNews::Exported(Err(why)) => model.complain(why),
        _ => {}
    }
    Vec::new()
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

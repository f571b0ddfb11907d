//! The run history: a searchable list, and the selected run beside or below it.

mod draw;
mod events;
mod run;
mod runs;
mod typing;

use ratatui::Frame;
use ratatui::layout::Rect;

pub use events::on_event;

use super::{Screen, Step};
use crate::action::{Action, Scope};
use crate::keymap::Key;
use crate::message::{Effect, Mouse};
use crate::model::{InputPurpose, Model, PAGE, PageId};
use crate::tasks::history::HistoryCommand;
use crate::widgets::hints::{self, Hint, fixed};
use nearmiss_store::Edge;

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
        typing.then(|| Step::Stay(typing::typed(model, key)))
    }

    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        use Action::*;
        match action {
            Cancel if model.history.typing.is_none() && !model.history.line.is_empty() => {
                return Step::Stay(typing::search(model, String::new()));
            }
            Cancel => return Step::Close(leave(model)),
            Up | Down | PageUp | PageDown | Top | Bottom => {
                return Step::Stay(moved(model, action));
            }
            SearchRuns => model.history.typing = Some(InputPurpose::Search),
            OtherHalf => model.history.on_details = !model.history.on_details,
            ExportRuns => model.history.typing = Some(InputPurpose::Export("runs.jsonl".into())),
            UndoDelete => return Step::Stay(runs::undo(model)),
            ReopenRun | PinRun | DeleteRun | NoteRun | CopyRun => {
                return runs::act(model, action);
            }
            _ => return Step::Ignored,
        }
        Step::stay()
    }

    fn on_mouse(&mut self, model: &mut Model, mouse: Mouse) -> Step {
        Step::Stay(on_mouse(model, mouse))
    }

    fn paste(&mut self, model: &mut Model, text: &str) -> Vec<Effect> {
        typing::paste(model, text)
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

//! Typing the filter of the list: narrowed down at once, kept by Enter, cancelled by Esc.

use super::super::action::Action;
use super::super::keymap::{Code, Key, edit_line, first_line};
use super::super::message::Effect;
use super::super::model::{Filtering, Model, Pane};
use super::{actions, jumps, open_current};

/// Begins to type; the old text is selected, so that the first character replaces it.
pub fn begin(model: &mut Model) {
    model.focus = Pane::Scenarios;
    if model.list.filtering.is_some() {
        return;
    }
    let before = model.list.filter.clone();
    model.list.filtering = Some(Filtering {
        selected: !before.is_empty(),
        before,
        line: model.list.selected,
        place: jumps::here(model),
    });
}

/// A key while the filter is typed.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    match key.code {
        Code::Esc => return cancel(model),
        Code::Enter | Code::Tab => {
            keep(model);
            return Vec::new();
        }
        Code::Up => return actions::perform(model, Action::Up),
        Code::Down => return actions::perform(model, Action::Down),
        Code::Left | Code::Right | Code::Home | Code::End => {
            unselected(model);
            return Vec::new();
        }
        _ => {}
    }
    let mut filter = model.list.filter.clone();
    if model.list.filtering.as_ref().is_some_and(|f| f.selected) && replaces(key) {
        filter.clear();
    }
    if !edit_line(&mut filter, key) {
        return Vec::new();
    }
    typed(model, filter)
}

/// Text that is pasted while the filter is typed.
pub fn paste(model: &mut Model, text: &str) -> Vec<Effect> {
    let selected = model.list.filtering.as_ref().is_some_and(|f| f.selected);
    let kept = if selected { "" } else { &model.list.filter };
    let filter = format!("{kept}{}", first_line(text));
    typed(model, filter)
}

/// Whether a key takes the place of the selected text.
fn replaces(key: Key) -> bool {
    key.writes().is_some() || key.code == Code::Backspace
}

fn unselected(model: &mut Model) {
    if let Some(filtering) = &mut model.list.filtering {
        filtering.selected = false;
    }
}

fn typed(model: &mut Model, filter: String) -> Vec<Effect> {
    unselected(model);
    if filter == model.list.filter {
        return Vec::new();
    }
    model.list.set_filter(filter);
    open_current(model)
}

/// The filter stays; what was open before is a place to go back to.
fn keep(model: &mut Model) {
    let Some(filtering) = model.list.filtering.take() else {
        return;
    };
    if let Some(place) = filtering.place
        && model.list.opened != Some(place.scenario)
    {
        model.jumps.leave(place);
    }
}

/// The filter is what it was, and so are the selected line and the open scenario.
pub fn cancel(model: &mut Model) -> Vec<Effect> {
    let Some(filtering) = model.list.filtering.take() else {
        return Vec::new();
    };
    if model.list.filter != filtering.before {
        model.list.set_filter(filtering.before);
    }
    let last = model.list.lines.len().saturating_sub(1);
    model.list.selected = filtering.line.min(last);
    match filtering.place {
        Some(place) if model.list.opened != Some(place.scenario) => jumps::reach(model, place),
        _ => Vec::new(),
    }
}

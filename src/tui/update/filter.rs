//! Typing the filter of the list: narrowed down at once, kept by Enter, cancelled by Esc.

use super::super::action::Action;
use super::super::keymap::{Code, Key, edit_line, first_line};
use super::super::message::Effect;
use super::super::model::{Filtering, Model, Pane};
use super::{actions, jumps, open_current};
use nearmiss_scene::description::visible;

/// Begins to type; the old text is selected, so that the first character replaces it.
pub fn begin(model: &mut Model) {
    model.focus = Pane::Scenarios;
    if model.list.filtering.is_some() {
        return;
    }
    let before = model.list.filter.clone();
    if let Some(dropped) = model.list.dropped.take().filter(|_| before.is_empty()) {
        model.list.set_filter(dropped);
    }
    model.list.filtering = Some(Filtering {
        selected: !model.list.filter.is_empty(),
        before,
        line: model.list.selected,
        place: jumps::here(model),
        rest: None,
    });
}

/// The kept filter goes; the key that types a filter brings it back.
pub fn drop_kept(model: &mut Model) {
    let filter = std::mem::take(&mut model.list.filter);
    model.list.set_filter(String::new());
    let (key, shown) = (
        model.look.key(Action::Filter),
        visible(&filter).into_owned(),
    );
    let all = model.list.rows.len();
    model.say(format!(
        "filter /{shown} removed: all {all} scenarios are listed; {key} Enter brings it back"
    ));
    model.list.dropped = Some(filter);
}

/// A key while the filter is typed.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    match key.code {
        Code::Esc => return cancel(model),
        Code::Enter | Code::Tab => {
            let effects = open_match(model);
            keep(model);
            return effects;
        }
        Code::Up | Code::Down => {
            let mut effects = open_match(model);
            let action = if key.code == Code::Up {
                Action::Up
            } else {
                Action::Down
            };
            effects.extend(actions::perform(model, action));
            return effects;
        }
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
    if let Some(filtering) = &mut model.list.filtering {
        filtering.rest = Some(REST);
    }
    Vec::new()
}

/// The best match is opened after so many seconds without typing.
const REST: f64 = 0.25;

/// Time passes: the best match is opened once typing rests.
pub fn pass(model: &mut Model, seconds: f64) -> Vec<Effect> {
    let filtering = model.list.filtering.as_mut();
    let Some(left) = filtering.and_then(|filtering| filtering.rest.as_mut()) else {
        return Vec::new();
    };
    *left -= seconds;
    if *left <= 0.0 {
        open_match(model)
    } else {
        Vec::new()
    }
}

/// Opens the selected match, unless it is open.
fn open_match(model: &mut Model) -> Vec<Effect> {
    let filtering = model.list.filtering.as_mut();
    match filtering.and_then(|filtering| filtering.rest.take()) {
        Some(_) => open_current(model),
        None => Vec::new(),
    }
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

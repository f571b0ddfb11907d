//! The source of the scenario: opened at the picked obstacle, read when it is first looked at.

use super::super::action::{Action, Scope};
use super::super::keymap::{Code, Key};
use super::super::loaded::Source;
use super::super::message::Effect;
use super::super::model::{Model, Overlay};
use super::actions;

/// Opens the source of what is open.
pub fn open(model: &mut Model) -> Vec<Effect> {
    let place = model.list.opened.filter(|_| model.opened.is_some());
    let Some(place) = place else {
        model.say("no scenario is open");
        return Vec::new();
    };
    if model.source.as_ref().is_some_and(|(of, _)| *of == place) {
        show(model);
        return Vec::new();
    }
    let entry = model.list.rows[place].entry.clone();
    vec![Effect::ReadSource(place, entry)]
}

/// The source was read; it is shown if it is still that of what is open.
pub fn read(model: &mut Model, place: usize, read: Result<Box<Source>, String>) {
    if model.list.opened != Some(place) {
        return;
    }
    match read {
        Ok(source) => {
            model.source = Some((place, source));
            show(model);
        }
        Err(error) => model.complain(error),
    }
}

fn show(model: &mut Model) {
    let scroll = at_picked(model).unwrap_or(0);
    // Keys may be faster than the file: it may have been asked for twice.
    model
        .overlays
        .retain(|o| !matches!(o, Overlay::Source { .. }));
    model.overlays.push(Overlay::Source { scroll });
}

/// The row of the picked obstacle, with what comes just before it.
fn at_picked(model: &Model) -> Option<usize> {
    let (_, source) = model.source.as_ref()?;
    let row = source.row_of(model.picked?)?;
    Some(row.saturating_sub(2))
}

/// A key while it is shown; nothing for one that closes it.
pub fn on_key(model: &mut Model, key: Key) -> Option<Vec<Effect>> {
    let last = model.source.as_ref()?.1.row_count().saturating_sub(1);
    let page = usize::from(model.size.1.saturating_sub(6)).max(1);
    let action = model.look.keymap.action(key, Scope::Global);
    if let Some(action @ (Action::NextObstacle | Action::PreviousObstacle)) = action {
        let effects = actions::perform(model, action);
        let to = at_picked(model);
        if let (Some(to), Some(scroll)) = (to, scroll(model)) {
            *scroll = to;
        }
        return Some(effects);
    }
    let scroll = scroll(model)?;
    match key.code {
        Code::Up | Code::Char('k') => *scroll = scroll.saturating_sub(1),
        Code::Down | Code::Char('j') => *scroll += 1,
        Code::PageUp => *scroll = scroll.saturating_sub(page),
        Code::PageDown | Code::Char(' ') => *scroll += page,
        Code::Home | Code::Char('g') => *scroll = 0,
        Code::End | Code::Char('G') => *scroll = last,
        _ => return None,
    }
    *scroll = (*scroll).min(last);
    Some(Vec::new())
}

fn scroll(model: &mut Model) -> Option<&mut usize> {
    match model.overlays.last_mut()? {
        Overlay::Source { scroll } => Some(scroll),
        _ => None,
    }
}

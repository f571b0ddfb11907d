//! Dispatches keys, actions and mouse to the topmost screen, and applies its requests.

use super::super::action::Action;
use super::super::keymap::Key;
use super::super::message::{Effect, Mouse};
use super::super::model::Model;
use super::keys::{self, KeyEffect};
use super::{actions, jumps, reopen};
use crate::features::{self, Screen, Step};

/// A key while a screen is open.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    let Some(mut screen) = model.screens.pop() else {
        return Vec::new();
    };
    if let Some(step) = screen.on_key(model, key) {
        return take(model, Some(screen), step);
    }
    let scope = screen.scope();
    model.screens.put_back(screen);
    let action = match keys::pressed(model, key, scope) {
        KeyEffect::Action(action) => Some(action),
        KeyEffect::Chord => return Vec::new(),
        KeyEffect::Nothing => None,
    };
    let Some(action) = action else {
        return Vec::new();
    };
    if let Some(effects) = offer(model, action) {
        return effects;
    }
    if model.takes(action) {
        actions::perform(model, action)
    } else {
        Vec::new()
    }
}

/// Closes the window on top, whatever is open inside it.
pub fn close_top(model: &mut Model) -> Vec<Effect> {
    let open = model.screens.iter().count();
    let mut effects = Vec::new();
    for _ in 0..LEVELS {
        effects.extend(on_action(model, Action::Cancel));
        if model.screens.iter().count() < open {
            break;
        }
    }
    effects
}

/// Levels inside a window, each of which Cancel closes.
const LEVELS: usize = 5;

/// An action while a screen is open; Cancel closes every screen that does nothing else of it.
pub fn on_action(model: &mut Model, action: Action) -> Vec<Effect> {
    match offer(model, action) {
        Some(effects) => effects,
        None if action == Action::Cancel && !model.screens.is_empty() => {
            model.screens.pop();
            Vec::new()
        }
        None => actions::perform(model, action),
    }
}

/// Offers an action to the top screen; `None` if that has no use for it.
fn offer(model: &mut Model, action: Action) -> Option<Vec<Effect>> {
    let mut screen = model.screens.pop()?;
    match features::act(screen.as_mut(), model, action) {
        Step::Ignored => {
            model.screens.put_back(screen);
            None
        }
        step => Some(take(model, Some(screen), step)),
    }
}

/// The mouse while a screen is open.
pub fn on_mouse(model: &mut Model, mouse: Mouse) -> Vec<Effect> {
    let Some(mut screen) = model.screens.pop() else {
        return Vec::new();
    };
    let step = screen.on_mouse(model, mouse);
    take(model, Some(screen), step)
}

/// Text that is pasted while a screen is open.
pub fn paste(model: &mut Model, text: &str) -> Vec<Effect> {
    let Some(mut screen) = model.screens.pop() else {
        return Vec::new();
    };
    let effects = screen.paste(model, text);
    model.screens.put_back(screen);
    effects
}

/// Does what follows from a step of a screen, which was taken away for it, or of news for one.
pub fn take(model: &mut Model, screen: Option<Box<dyn Screen>>, step: Step) -> Vec<Effect> {
    if let Some(screen) = screen
        && !matches!(
            step,
            Step::Close(_) | Step::CloseAndPerform(_) | Step::Visit(_)
        )
    {
        model.screens.put_back(screen);
    }
    match step {
        Step::Stay(effects) | Step::Close(effects) => effects,
        Step::Perform(action) => actions::perform(model, action),
        // The action may concern the screen below.
        Step::CloseAndPerform(action) => on_action(model, action),
        Step::Reopen(run) => reopen::begin(model, *run),
        Step::Visit(place) => {
            jumps::leave(model);
            jumps::reach(model, place)
        }
        Step::Ignored => Vec::new(),
    }
}

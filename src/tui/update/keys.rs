//! Keys: looked up on the main screen, in menus and on screens that are open.

use crate::action::{Action, Scope};
use crate::features::{self, Screen, Step};
use crate::keymap::{Code, Key, KeyMeaning};
use crate::message::{Effect, Mouse};
use crate::model::Model;
use crate::update::pressed::{KeyEffect, pressed};
use crate::update::{actions, opened, opening};
use nearmiss_settings::Keys;

/// A key where nothing is typed and no screen is open.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    match pressed(model, key, model.focus.scope()) {
        KeyEffect::Action(action) => actions::perform(model, action),
        KeyEffect::Nothing => {
            if let Some(words) = model.look.keymap.moved(key) {
                model.say(words);
            }
            Vec::new()
        }
        KeyEffect::Chord => Vec::new(),
    }
}

/// The key that opens the menus on the main screen.
fn space() -> Key {
    Key::plain(Code::Char(' '))
}

/// A key of the menus; `None` where it has another meaning.
pub fn on_menu_key(model: &mut Model, key: Key) -> Option<Vec<Effect>> {
    let begun = model.look.in_menu();
    if !begun && !begins(model, key) {
        return None;
    }
    if model.compare.hides() {
        model.say("menus name models: rate first");
        return Some(Vec::new());
    }
    let key = if begun { key } else { space() };
    Some(match pressed(model, key, Scope::Global) {
        KeyEffect::Action(action) if model.takes(action) => actions::perform(model, action),
        KeyEffect::Action(_) => {
            model.say("this works on the main screen");
            Vec::new()
        }
        KeyEffect::Chord | KeyEffect::Nothing => Vec::new(),
    })
}

/// Whether a key opens the menus here.
fn begins(model: &Model, key: Key) -> bool {
    let keymap = &model.look.keymap;
    if keymap.meaning(&[space()], Scope::Global) != KeyMeaning::Prefix {
        return false;
    }
    if model.compare.open {
        let meaning = keymap.meaning(&[key], Scope::Compare);
        let is_free = meaning == KeyMeaning::Nothing && model.compare.marking.is_none();
        return key == space() && is_free && model.compare.ratings.is_none();
    }
    if !model.prompt.editing || model.prompt.entry.is_some() {
        return false;
    }
    let editor = &model.prompt.editor;
    let commands = editor.keys() == Keys::Vim && editor.commands() && !editor.awaits();
    let alt = Key {
        alt: true,
        ..space()
    };
    key == alt || key.code == Code::Function(8) || (commands && key == space())
}

/// A key while a screen is open.
pub fn on_screen_key(model: &mut Model, key: Key) -> Vec<Effect> {
    let Some(mut screen) = model.screens.pop() else {
        return Vec::new();
    };
    if let Some(step) = screen.on_key(model, key) {
        return take(model, Some(screen), step);
    }
    let scope = screen.scope();
    model.screens.put_back(screen);
    let action = match pressed(model, key, scope) {
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
        Step::Reopen(run) => opened::begin(model, *run),
        Step::Visit(place) => {
            opening::leave_place(model);
            opening::reach(model, place)
        }
        Step::Ignored => Vec::new(),
    }
}

//! The menus of the space bar where keys have other meanings: side by side, and in the template editor.

use super::super::action::Scope;
use super::super::keymap::{Code, Key, KeyMeaning};
use super::super::message::Effect;
use super::super::model::Model;
use super::actions;
use super::keys::{self, KeyEffect};
use nearmiss_settings::Keys;

/// The key that opens the menus on the main screen.
fn space() -> Key {
    Key::plain(Code::Char(' '))
}

/// A key of the menus; `None` where it has another meaning.
pub fn on_key(model: &mut Model, key: Key) -> Option<Vec<Effect>> {
    let begun = model.look.in_menu();
    if !begun && !begins(model, key) {
        return None;
    }
    if model.compare.hides() {
        model.say("menus name models: rate first");
        return Some(Vec::new());
    }
    let key = if begun { key } else { space() };
    Some(match keys::pressed(model, key, Scope::Global) {
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

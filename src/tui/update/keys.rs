//! Keys of the main screen and of screens of their own: single ones, and those of a chord one after another.

use super::super::action::{Action, Scope};
use super::super::keymap::{Code, Key, Meaning, latin};
use super::super::message::Effect;
use super::super::model::Model;
use super::actions;

/// A key where nothing is typed and no overlay is open.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    match action(model, key, model.focus.scope()) {
        Some(action) => actions::perform(model, action),
        None => Vec::new(),
    }
}

/// What a key does where `scope` holds, with those that were pressed before it; nothing for the beginning of a chord.
pub fn action(model: &mut Model, key: Key, scope: Scope) -> Option<Action> {
    if key.code == Code::Esc && give_up(model) {
        return None;
    }
    let begun = std::mem::take(&mut model.look.pending);
    let with = |key: Key| {
        let mut keys = begun.clone();
        keys.push(key);
        keys
    };
    let mut keys = with(key);
    let mut meaning = model.look.keymap.meaning(&keys, scope);
    // A letter of another alphabet that means nothing is taken for the key it is on.
    if let (Meaning::Nothing, Some(latin)) = (meaning, latin(key)) {
        keys = with(latin);
        meaning = model.look.keymap.meaning(&keys, scope);
    }
    match meaning {
        Meaning::Action(action) => return Some(action),
        Meaning::Prefix => model.look.pending = keys,
        Meaning::Nothing if begun.is_empty() => {}
        Meaning::Nothing => {
            let names: Vec<String> = keys.iter().map(Key::to_string).collect();
            model.say(format!("`{}` means nothing here", names.join(" ")));
        }
    }
    None
}

/// Forgets the beginning of a chord; says whether there was one.
pub fn give_up(model: &mut Model) -> bool {
    !std::mem::take(&mut model.look.pending).is_empty()
}

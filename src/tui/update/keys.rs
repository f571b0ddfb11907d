//! Key handling: single keys and chords.

use super::super::action::{Action, Scope};
use super::super::keymap::{Code, Key, KeyMeaning, latin};
use super::super::message::Effect;
use super::super::model::Model;
use super::actions;

/// Meaning of a key after the keys before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KeyEffect {
    /// An action.
    Action(Action),
    /// A part of a chord, or one that is given up.
    Chord,
    /// No effect.
    Nothing,
}

/// A key where nothing is typed and no screen is open.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    match pressed(model, key, model.focus.scope()) {
        KeyEffect::Action(action) => actions::perform(model, action),
        KeyEffect::Chord | KeyEffect::Nothing => Vec::new(),
    }
}

/// The meaning of a key in `scope`, after the keys pressed before it.
pub fn pressed(model: &mut Model, key: Key, scope: Scope) -> KeyEffect {
    if key.code == Code::Esc && give_up(model) {
        return KeyEffect::Chord;
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
    if let (KeyMeaning::Nothing, Some(latin)) = (meaning, latin(key)) {
        keys = with(latin);
        meaning = model.look.keymap.meaning(&keys, scope);
    }
    match meaning {
        KeyMeaning::Action(action) => return KeyEffect::Action(action),
        KeyMeaning::Prefix => model.look.pending = keys,
        KeyMeaning::Nothing if begun.is_empty() => return KeyEffect::Nothing,
        KeyMeaning::Nothing => {
            let names: Vec<String> = keys.iter().map(Key::to_string).collect();
            model.say(format!("`{}` means nothing here", names.join(" ")));
        }
    }
    KeyEffect::Chord
}

/// Forgets the beginning of a chord; says whether there was one.
pub fn give_up(model: &mut Model) -> bool {
    !std::mem::take(&mut model.look.pending).is_empty()
}

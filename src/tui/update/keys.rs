//! Key handling: single keys and chords.

use super::super::action::{Action, Scope};
use super::super::keymap::{Chord, Code, Key, KeyMeaning, latin};
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
        KeyEffect::Nothing => {
            if let Some(words) = model.look.keymap.moved(key) {
                model.say(words);
            }
            Vec::new()
        }
        KeyEffect::Chord => Vec::new(),
    }
}

/// The meaning of a key in `scope`, after the keys pressed before it.
pub fn pressed(model: &mut Model, key: Key, scope: Scope) -> KeyEffect {
    if key.code == Code::Esc && give_up(model) {
        return KeyEffect::Chord;
    }
    if count(model, key, scope) {
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
        KeyMeaning::Action(action) => {
            model.look.repeat = model.look.count.take();
            return KeyEffect::Action(action);
        }
        KeyMeaning::Prefix => model.look.pending = keys,
        KeyMeaning::Nothing if begun.is_empty() => {
            model.look.count = None;
            return KeyEffect::Nothing;
        }
        KeyMeaning::Nothing => {
            model.look.count = None;
            model.say(format!("{} is not bound here", Chord(keys)));
        }
    }
    KeyEffect::Chord
}

/// The highest count.
const MOST: u32 = 9999;

/// Takes a digit of a count before a motion; says whether the key was one. A digit that is bound keeps its meaning
/// unless a count has begun.
fn count(model: &mut Model, key: Key, scope: Scope) -> bool {
    let look = &mut model.look;
    let counts = !matches!(scope, Scope::Editor | Scope::Compare) && look.pending.is_empty();
    let Some(digit) = key.digit().filter(|_| counts) else {
        return false;
    };
    let free = digit > 0 && look.keymap.meaning(&[key], scope) == KeyMeaning::Nothing;
    if look.count.is_none() && !free {
        return false;
    }
    let count = look.count.unwrap_or(0) * 10 + digit;
    look.count = Some(count.min(MOST));
    true
}

/// Forgets the beginning of a chord or a count; says whether there was one.
pub fn give_up(model: &mut Model) -> bool {
    let count = model.look.count.take().is_some();
    !std::mem::take(&mut model.look.pending).is_empty() || count
}

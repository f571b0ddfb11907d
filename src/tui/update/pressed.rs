//! What a key means in a scope, after the keys before it; scrolling of panes.

use crate::action::{Action, Scope};
use crate::keymap::{Chord, Code, Key, KeyMeaning, latin};
use crate::model::{Column, Model, Pane};

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

/// The meaning of a key in `scope`, after the keys pressed before it.
pub fn pressed(model: &mut Model, key: Key, scope: Scope) -> KeyEffect {
    if key.code == Code::Esc && cancel_chord(model) {
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
const MAX_COUNT: u32 = 9999;

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
    look.count = Some(count.min(MAX_COUNT));
    true
}

/// Forgets the beginning of a chord or a count; says whether there was one.
pub fn cancel_chord(model: &mut Model) -> bool {
    let count = model.look.count.take().is_some();
    !std::mem::take(&mut model.look.pending).is_empty() || count
}

/// Scrolls a pane's text.
pub fn scroll(model: &mut Model, pane: Pane, action: Action) {
    let extent = model.drawn.extent(pane);
    let last = extent.last_top();
    let page = extent.rows.saturating_sub(1).max(1);
    let by = model.look.lines(action, page.cast_signed());
    let line = model.look.line(action).map(|line| line.min(last));
    let top = line.unwrap_or_else(|| extent.moved(by));
    match pane {
        Pane::Prompt => model.prompt.scroll = top,
        Pane::Verdict => model.answers.verdict_top = top,
        Pane::Reasoning => {
            model.note_scrolled();
            // At the end of a text that still arrives, the end is followed again.
            let running = model.answers.column().is_some_and(Column::is_running);
            let follow = running && top == last;
            model.answers.scroll = if follow { None } else { Some(top) };
        }
        _ => {}
    }
}

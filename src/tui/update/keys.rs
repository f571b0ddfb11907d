//! Keys: looked up on the main screen, in menus and on screens that are open.

use nearmiss_settings::Keys;

use crate::action::{Action, Scope};
use crate::features::{self, Screen, Step};
use crate::keymap::{Chord, Code, Key, KeyMeaning, latin};
use crate::message::{Effect, Mouse};
use crate::model::{Column, Model, Pane};
use crate::update::{actions, opened, opening};

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

//! Key hints for the footer: keys with a word or two on what they do.

use crate::action::{ACTIONS, Action, Entry, Scope};
use crate::model::Model;

/// A key, and what it does in a word or two.
pub type Hint = (String, String);

/// The key of an action, and what it does.
pub fn hint_of(model: &Model, action: Action) -> Option<Hint> {
    let entry = ACTIONS.iter().find(|e| e.action == action)?;
    let key = model.look.keymap.keys(entry).next()?;
    Some((key.to_string(), entry.short.to_string()))
}

/// The key of an action where `scope` holds, or of the same action everywhere, and what it does.
pub fn hint_in(model: &Model, action: Action, scope: Scope) -> Option<Hint> {
    let in_scope = |place: Scope| {
        let mut all = ACTIONS.iter();
        all.find(|e| e.action == action && e.scope == place)
    };
    let entry = in_scope(scope).or_else(|| in_scope(Scope::Global))?;
    let key = model.look.keymap.keys(entry).next()?;
    Some((key.to_string(), entry.short.to_string()))
}

/// The keys of an action and of its opposite where `scope` holds, with words of their own.
pub fn pair(model: &Model, scope: Scope, actions: [Action; 2], words: &str) -> Hint {
    let keys = actions.map(|action| model.look.keymap.key_in(action, scope));
    let several = keys.iter().any(|key| key.contains(' '));
    (keys.join(if several { " " } else { "" }), words.to_string())
}

/// Keys of lines that are typed into, which no keymap changes.
pub fn fixed(pairs: &[(&str, &str)]) -> Vec<Hint> {
    let owned = pairs.iter().map(|(k, w)| ((*k).into(), (*w).into()));
    owned.collect()
}

/// The keys of the footer where `scope` holds, the most important first.
pub fn entries(scope: Scope) -> Vec<&'static Entry> {
    let shown = ACTIONS.iter().filter(|e| e.scope == scope && e.footer > 0);
    let mut entries: Vec<_> = shown.collect();
    entries.sort_by_key(|e| e.footer);
    entries
}

/// The keys of a full screen, and those that leave it.
pub fn own(model: &Model, scope: Scope) -> Vec<Hint> {
    own_but(model, scope, &[])
}

/// The same without the actions that do nothing at the moment.
pub fn own_but(model: &Model, scope: Scope, idle: &[Action]) -> Vec<Hint> {
    let key = |entry: &Entry| {
        let key = model.look.keymap.keys(entry).next()?;
        Some((key.to_string(), entry.short.to_string()))
    };
    let shown = entries(scope)
        .into_iter()
        .filter(|entry| !idle.contains(&entry.action));
    let mut hints = together(shown.filter_map(key));
    hints.extend(hint_of(model, Action::Help));
    hints.push(close(model));
    hints
}

/// The key that closes what is open.
pub fn close(model: &Model) -> Hint {
    (model.look.key(Action::Cancel), "close".into())
}

/// The keys that scroll a window.
pub fn scroll(model: &Model) -> Hint {
    pair(model, Scope::Window, [Action::Up, Action::Down], "scroll")
}

/// The keys that scroll a window by a page.
pub fn page(model: &Model) -> Hint {
    let keys = [Action::PageUp, Action::PageDown]
        .map(|action| model.look.keymap.key_in(action, Scope::Window));
    (keys.join(" "), "a page".into())
}

/// The keys that go to another step.
pub fn steps(model: &Model, words: &str) -> Hint {
    let keys = [Action::StepBack, Action::StepForward];
    pair(model, Scope::Global, keys, words)
}

/// Keys that follow each other and do the same in both directions share their words.
pub fn together(hints: impl Iterator<Item = Hint>) -> Vec<Hint> {
    let mut joined: Vec<Hint> = Vec::new();
    for (key, words) in hints {
        match joined.last_mut().filter(|(_, last)| *last == words) {
            Some((keys, _)) => {
                // `Alt-↑` and `Alt-↓` are `Alt-↑↓`.
                let modifier = key.rfind('-').filter(|&at| at + 1 < key.len());
                let same = modifier.filter(|&at| keys.starts_with(&key[..=at]));
                let more = same.map_or(key.as_str(), |at| &key[at + 1..]);
                // Letters and digits stand apart, so that they are not read as one word.
                if more.starts_with(char::is_alphanumeric) {
                    keys.push(' ');
                }
                keys.push_str(more);
            }
            None => joined.push((key, words)),
        }
    }
    joined
}

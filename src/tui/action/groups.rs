//! Titles of the key menus: what a prefix leads to.

use crate::keymap::{Chord, Key};

/// A prefix with the title of its menu. Chords of the table and of keymap files that begin with it are in that menu.
const GROUPS: &[(&str, &str)] = &[
    ("space", "menu"),
    ("space l", "list"),
    ("space m", "map"),
    ("space a", "ask"),
    ("space e", "ego & planner"),
    ("space g", "generate"),
    ("space o", "open"),
    ("space p", "plots"),
    ("space t", "time"),
    ("space w", "panes"),
    ("space s", "settings"),
    ("g", "go to"),
    ("ctrl-w", "panes"),
];

/// The title of the menu behind these keys; nothing for a prefix that only a keymap file has.
#[must_use]
pub fn title_of(keys: &[Key]) -> Option<&'static str> {
    let name = Chord(keys.to_vec()).name();
    let found = GROUPS.iter().find(|(prefix, _)| *prefix == name);
    found.map(|(_, title)| *title)
}

/// The place of the menu behind these keys among all menus; others come last.
#[must_use]
pub fn order_of(keys: &[Key]) -> usize {
    let name = Chord(keys.to_vec()).name();
    let found = GROUPS.iter().position(|(prefix, _)| *prefix == name);
    found.unwrap_or(GROUPS.len())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::{ACTIONS, Scope};
    use super::*;

    #[test]
    fn every_prefix_of_the_table_has_a_title_and_every_title_a_key() {
        let all = ACTIONS.iter().flat_map(|entry| entry.keys);
        let all: Vec<Chord> = all.filter_map(|keys| Chord::parse(keys).ok()).collect();
        for chord in &all {
            for length in 1..chord.0.len() {
                assert!(title_of(&chord.0[..length]).is_some(), "{chord}");
            }
        }
        for (prefix, title) in GROUPS {
            let prefix = Chord::parse(prefix).unwrap();
            assert!(all.iter().any(|chord| prefix.begins(chord)), "{title}");
        }
    }

    #[test]
    fn every_action_takes_three_keys_at_most() {
        for entry in ACTIONS.iter().filter(|e| e.scope == Scope::Global) {
            let shortest = entry.keys.iter().map(|keys| keys.split(' ').count()).min();
            assert!(shortest.is_some_and(|n| n <= 3), "{}", entry.id);
        }
    }
}

//! Prints the keymap to the shell: as a table, or as a starter file.

use super::Keymap;
use crate::action::{ACTIONS, Entry, Scope};
use nearmiss_base::system::{KeyBinding, columns, pad_end};

/// Where, name, keys and a sentence of every action, in columns.
#[must_use]
pub fn as_table(map: &Keymap) -> String {
    let mut text = String::new();
    let shown = |entry: &Entry| {
        let keys: Vec<String> = map.keys(entry).map(super::Chord::name).collect();
        if keys.is_empty() {
            "-".to_string()
        } else {
            keys.join(", ")
        }
    };
    let widest = |of: &dyn Fn(&Entry) -> usize| ACTIONS.iter().map(of).max().unwrap_or(0);
    let id = widest(&|entry| columns(entry.id));
    let keys = widest(&|entry| columns(&shown(entry)));
    for (scope, name, _) in Scope::ALL {
        for entry in ACTIONS.iter().filter(|entry| entry.scope == scope) {
            text.push_str(&format!(
                "{name:9}  {}  {}  {}\n",
                pad_end(entry.id, id),
                pad_end(&shown(entry), keys),
                entry.doc
            ));
        }
    }
    text
}

/// Every action with its keys.
#[must_use]
pub fn as_bindings(map: &Keymap) -> Vec<KeyBinding> {
    let of = |(scope, name, _): (Scope, &'static str, _)| {
        let entries = ACTIONS.iter().filter(move |entry| entry.scope == scope);
        entries.map(move |entry| KeyBinding {
            scope: name,
            action: entry.id,
            keys: map.keys(entry).map(super::Chord::name).collect(),
            summary: entry.doc,
        })
    };
    Scope::ALL.into_iter().flat_map(of).collect()
}

/// A `keymap.toml` with all keys as they are.
#[must_use]
pub fn as_file(map: &Keymap) -> String {
    let mut text = format!(
        "# The keys of nearmiss. Lines that are left out stay as in the preset; [] takes all keys off an action.\n\
         # \"g g\" is g pressed twice, shift-g a capital; also ctrl-, alt-, space, enter, tab, up, pageup, f1 and others.\n\
         preset = {:?}\n",
        map.preset.name()
    );
    for (scope, name, words) in Scope::ALL {
        text.push_str(&format!("\n# {words}\n[{name}]\n"));
        for entry in ACTIONS.iter().filter(|entry| entry.scope == scope) {
            // The one key that no file may change.
            let keys = map
                .keys(entry)
                .map(super::Chord::name)
                .filter(|name| name != "ctrl-c");
            // As TOML writes texts.
            let keys: Vec<String> = keys
                .map(|name| toml::Value::String(name).to_string())
                .collect();
            text.push_str(&format!(
                "{} = [{}] # {}\n",
                entry.id,
                keys.join(", "),
                entry.doc
            ));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::keymap::Preset;

    #[test]
    fn what_is_printed_is_read_as_the_same() {
        for (name, preset) in Preset::ALL {
            let map = Keymap::from_preset(preset);
            let again = Keymap::parse("keymap.toml", &as_file(&map)).unwrap();
            for entry in ACTIONS {
                let keys = |map: &Keymap| -> Vec<String> {
                    let names = map.keys(entry).map(super::super::Chord::name);
                    names.filter(|name| name != "ctrl-c").collect()
                };
                assert_eq!(keys(&map), keys(&again), "{name}: {}", entry.id);
                assert!(as_table(&map).contains(entry.doc));
            }
        }
    }
}

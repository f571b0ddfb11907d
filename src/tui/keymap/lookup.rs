//! Looks keys and actions up, and prints the keymap.

use strum::{IntoStaticStr, VariantArray};

use crate::action::{ACTIONS, Action, Entry, Scope, menu_label, order_of, title_of};
use crate::keymap::{Chord, Key, file};
use nearmiss_base::system::{KeyBinding, columns, pad_end};

/// A set of keys to begin with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Preset {
    /// The keys of the table of actions.
    Default,
    /// Those, changed to what people with Vim in their fingers expect.
    Vim,
}

nearmiss_record::named!(Preset);

/// Keys that do something.
#[derive(Debug, Clone, PartialEq)]
pub struct Binding {
    /// Which, by its place in the table of actions.
    pub place: usize,
    /// The keys.
    pub keys: Chord,
    /// Byte range in the user's file; `None` for a binding of a preset.
    pub span: Option<std::ops::Range<usize>>,
}

/// The active key bindings.
#[derive(Debug, Clone, PartialEq)]
pub struct Keymap {
    /// The preset it started from.
    pub preset: Preset,
    /// In the order of the table of actions, the first key of an action first.
    pub(super) bindings: Vec<Binding>,
    /// What the user should know of the keymap file, such as a menu that its keys hide.
    pub notes: Vec<String>,
}

/// Meaning of a key sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KeyMeaning {
    /// An action.
    Action(Action),
    /// The beginning of something longer.
    Prefix,
    /// No binding.
    Nothing,
}

/// A key that can follow a prefix.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NextKey {
    /// The key.
    pub key: Key,
    /// Its effect, in a word or two, or the title of the menu behind it.
    pub label: &'static str,
    /// Whether more keys follow.
    pub leads_on: bool,
    /// The action, where no more keys follow.
    pub action: Option<Action>,
}

impl Binding {
    /// Its line in the table of actions.
    pub fn entry(&self) -> &'static Entry {
        &ACTIONS[self.place]
    }
}

impl Keymap {
    /// The keys of a preset.
    #[must_use]
    pub fn from_preset(preset: Preset) -> Self {
        let mut map = Self {
            preset,
            bindings: Vec::new(),
            notes: Vec::new(),
        };
        for (place, entry) in ACTIONS.iter().enumerate() {
            // A test reads every key of the table.
            let keys = entry.keys.iter().filter_map(|name| table_key(name));
            map.bindings.extend(keys.map(|keys| Binding {
                place,
                keys,
                span: None,
            }));
        }
        if preset == Preset::Vim {
            file::vim(&mut map);
        }
        map
    }

    /// Gives an action these keys instead of those that it has.
    pub(super) fn rebind(&mut self, place: usize, keys: Vec<Binding>) {
        self.bindings.retain(|binding| binding.place != place);
        self.bindings.extend(keys);
        self.bindings.sort_by_key(|binding| binding.place);
    }

    /// Meaning of keys in `scope`; its own bindings precede global ones.
    #[must_use]
    pub fn meaning(&self, keys: &[Key], scope: Scope) -> KeyMeaning {
        let here = |place: Scope| {
            let mut found = self.bindings.iter();
            found.find(move |b| {
                b.entry().scope == place && b.entry().holds_in(scope) && b.keys.0 == keys
            })
        };
        if let Some(binding) = here(scope).or_else(|| here(Scope::Global)) {
            return KeyMeaning::Action(binding.entry().action);
        }
        if self.beginning(keys, scope).next().is_some() {
            KeyMeaning::Prefix
        } else {
            KeyMeaning::Nothing
        }
    }

    /// Meaning of a single key in `scope`.
    #[must_use]
    pub fn action(&self, key: Key, scope: Scope) -> Option<Action> {
        match self.meaning(&[key], scope) {
            KeyMeaning::Action(action) => Some(action),
            KeyMeaning::Prefix | KeyMeaning::Nothing => None,
        }
    }

    /// Possible continuations of these keys to actions that work, in the order of the action table, then menus. An action with several keys here has the first of them.
    #[must_use]
    pub fn following(
        &self,
        keys: &[Key],
        scope: Scope,
        works: impl Fn(&Entry) -> bool,
    ) -> Vec<NextKey> {
        let mut all: Vec<NextKey> = Vec::new();
        let mut seen = Vec::new();
        for binding in self.beginning(keys, scope).filter(|b| works(b.entry())) {
            let rest = &binding.keys.0[keys.len()..];
            let ends = rest.len() == 1;
            if all.iter().any(|f| f.key == rest[0]) || (ends && seen.contains(&binding.place)) {
                continue;
            }
            if ends {
                seen.push(binding.place);
            }
            let title = title_of(&binding.keys.0[..=keys.len()]);
            all.push(NextKey {
                key: rest[0],
                label: if ends {
                    menu_label(binding.entry())
                } else {
                    title.unwrap_or("more")
                },
                leads_on: !ends,
                action: ends.then_some(binding.entry().action),
            });
        }
        let menu = |next: &NextKey| {
            let keys = [keys, &[next.key]].concat();
            (
                next.leads_on,
                if next.leads_on { order_of(&keys) } else { 0 },
            )
        };
        all.sort_by_key(menu);
        all
    }

    /// Longer chords that begin with these keys and can be pressed where `scope` holds.
    fn beginning(&self, keys: &[Key], scope: Scope) -> impl Iterator<Item = &Binding> {
        let (prefix, scope) = (Chord(keys.to_vec()), scope);
        let all = self.bindings.iter();
        all.filter(move |b| b.entry().holds_in(scope) && prefix.begins(&b.keys))
    }

    /// The keys of a line of the table, the one that is shown first.
    pub fn keys(&self, entry: &Entry) -> impl Iterator<Item = &Chord> {
        let (id, scope) = (entry.id, entry.scope);
        let all = self.bindings.iter();
        all.filter(move |b| b.entry().id == id && b.entry().scope == scope)
            .map(|b| &b.keys)
    }

    /// The key of an action where `scope` holds, for a sentence; empty where it has none there.
    #[must_use]
    pub fn key_in(&self, action: Action, scope: Scope) -> String {
        let mut all = self.bindings.iter();
        let binding = all.find(|b| b.entry().action == action && b.entry().scope == scope);
        binding.map_or(String::new(), |b| b.keys.to_string())
    }

    /// The key of an action for a sentence, such as `o` or `Ctrl-w w`; of one without keys its name in the palette.
    #[must_use]
    pub fn key_of(&self, action: Action) -> String {
        let mut all = self.bindings.iter();
        if let Some(binding) = all.find(|b| b.entry().action == action) {
            return binding.keys.to_string();
        }
        let entry = ACTIONS.iter().find(|entry| entry.action == action);
        let palette = self
            .bindings
            .iter()
            .find(|b| b.entry().action == Action::Palette);
        match (entry, palette) {
            (Some(entry), Some(palette)) => format!("{} {}", palette.keys, entry.id),
            (Some(entry), None) => entry.id.to_string(),
            (None, _) => String::new(),
        }
    }
}

/// A key of the table, which may have the one that no file may have.
fn table_key(names: &str) -> Option<Chord> {
    let keys = names
        .split(' ')
        .map(Key::parse)
        .collect::<Option<Vec<Key>>>()?;
    (!keys.is_empty()).then_some(Chord(keys))
}

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

    fn keys(names: &str) -> Vec<Key> {
        names
            .split(' ')
            .map(|name| Key::parse(name).unwrap())
            .collect()
    }

    #[test]
    fn every_key_of_the_table_has_a_meaning() {
        let map = Keymap::from_preset(Preset::Default);
        for entry in ACTIONS {
            assert_eq!(map.keys(entry).count(), entry.keys.len(), "{}", entry.id);
            for chord in map.keys(entry) {
                let meaning = map.meaning(&chord.0, entry.scope);
                assert_eq!(meaning, KeyMeaning::Action(entry.action), "{chord}");
            }
        }
    }

    #[test]
    fn no_preset_gives_a_key_two_meanings() {
        for preset in Preset::ALL {
            let map = Keymap::from_preset(preset);
            let found = file::collisions(&map);
            assert!(found.is_empty(), "{}: {found:#?}", preset.name());
            // Indispensable actions.
            for action in [Action::Quit, Action::Help, Action::Palette, Action::Cancel] {
                assert!(map.bindings.iter().any(|b| b.entry().action == action));
            }
        }
    }

    #[test]
    fn prefixes_are_told_from_keys() {
        let map = Keymap::from_preset(Preset::Default);
        let g = keys("g");
        assert_eq!(map.meaning(&g, Scope::Scenarios), KeyMeaning::Prefix);
        assert_eq!(
            map.meaning(&keys("g g"), Scope::Scenarios),
            KeyMeaning::Action(Action::Top)
        );
        assert_eq!(map.meaning(&keys("g g"), Scope::Map), KeyMeaning::Nothing);
        assert_eq!(
            map.meaning(&keys("g x"), Scope::Scenarios),
            KeyMeaning::Nothing
        );
        let after = map.following(&g, Scope::Scenarios, |_| true);
        assert!(after.iter().any(|f| f.key == g[0] && f.label == "top"));
        let there = map.following(&g, Scope::Map, |_| true);
        assert!(there.iter().all(|f| f.label != "top"));
        let menu = map.following(&keys("space"), Scope::Map, |_| true);
        let open = menu.iter().find(|f| f.key.name() == "o").unwrap();
        assert_eq!((open.label, open.leads_on), ("open", true));
        let none = map.following(&keys("space"), Scope::Map, |_| false);
        assert!(none.is_empty(), "{none:?}");
    }

    #[test]
    fn what_has_no_key_is_in_the_palette() {
        let map = Keymap::parse("keymap.toml", "[global]\nread-thresholds = []\n").unwrap();
        assert_eq!(map.key_of(Action::Help), "?");
        assert_eq!(map.key_of(Action::ReadThresholds), ": read-thresholds");
        assert_eq!(map.key_of(Action::Results), "Space o r");
    }

    #[test]
    fn what_is_printed_is_read_as_the_same() {
        for preset in Preset::ALL {
            let map = Keymap::from_preset(preset);
            let again = Keymap::parse("keymap.toml", &as_file(&map)).unwrap();
            for entry in ACTIONS {
                let keys = |map: &Keymap| -> Vec<String> {
                    let names = map.keys(entry).map(super::super::Chord::name);
                    names.filter(|name| name != "ctrl-c").collect()
                };
                assert_eq!(keys(&map), keys(&again), "{}: {}", preset.name(), entry.id);
                assert!(as_table(&map).contains(entry.doc));
            }
        }
    }
}

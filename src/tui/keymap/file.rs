//! Reads the user's keymap file: its lines, and keys that moved since.
//!
//! Keys of the version before that do something else now: pressing one says where its action went.
//!
//! The table is for one version. A key that a keymap file binds has a meaning and never gets here.

use std::path::Path;

use nearmiss_base::system::{TomlText, nearest, shown_value};
use nearmiss_settings::TextFile;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::action::{ACTIONS, Action, Scope};
use crate::keymap::lookup::Binding;
use crate::keymap::{Chord, Code, Key, Keymap, Preset, all_visible};

const VIM: &str = include_str!("vim.toml");

/// Changes the default keys to those of the preset `vim`.
pub fn vim(map: &mut Keymap) {
    let mut file = TomlText::new(VIM);
    // A test reads it.
    if let Some(table) = file.table() {
        change(&mut file, map, &table);
    }
    for binding in &mut map.bindings {
        binding.span = None;
    }
}

impl Keymap {
    /// The keymap of a file, or the default one where there is no file.
    ///
    /// # Errors
    /// Every mistake, with file, line and key.
    pub fn load(path: &Path) -> Result<Self, Vec<String>> {
        match TextFile::read_if_there(path).map_err(|error| all_visible(vec![error]))? {
            None => Ok(Self::from_preset(Preset::Default)),
            Some(own) => Self::parse(&own.file, &own.text),
        }
    }

    /// The keymap that a text says.
    ///
    /// # Errors
    /// Every mistake, with file, line and key.
    pub fn parse(name: &str, text: &str) -> Result<Self, Vec<String>> {
        let mut file = TomlText::new(text);
        let table = file.table().unwrap_or_default();
        let mut map = Self::from_preset(preset(&mut file, &table));
        change(&mut file, &mut map, &table);
        give_way(&mut map);
        map.notes.extend(skipped(&map, &table));
        for collision in collisions(&map) {
            let message = collision.message(&file);
            file.mistake(&collision.span.unwrap_or_default(), message);
        }
        file.checked(name).map_err(all_visible)?;
        Ok(map)
    }
}

/// Bindings of the preset give way to those of the file that they cannot stand beside; a note says which menus that
/// hides.
fn give_way(map: &mut Keymap) {
    let theirs = map.bindings.iter().filter(|b| b.span.is_some());
    let theirs: Vec<Binding> = theirs.cloned().collect();
    let hidden_by = |binding: &Binding| {
        let mut theirs = theirs.iter();
        let hides = |b: &&Binding| conflict(b, binding);
        (binding.span.is_none())
            .then(|| theirs.find(hides))
            .flatten()
    };
    for prefix in ["space", "g", "ctrl-w"] {
        let in_menu = |b: &&Binding| b.keys.name().starts_with(&format!("{prefix} "));
        let hides = map.bindings.iter().filter(in_menu).find_map(hidden_by);
        if let Some(by) = hides.filter(|by| by.keys.name() == prefix) {
            let entry = by.entry();
            map.notes.push(format!(
                "keymap.toml binds `{prefix}` to {}.{}, which hides the menu behind `{prefix}`; remove that line to \
                 get the menu",
                entry.scope.name(),
                entry.id
            ));
        }
    }
    let all = std::mem::take(&mut map.bindings);
    map.bindings = all.into_iter().filter(|b| hidden_by(b).is_none()).collect();
}

/// Whether a key can be pressed that would mean both.
fn conflict(a: &Binding, b: &Binding) -> bool {
    let same = a.keys == b.keys || a.keys.begins(&b.keys) || b.keys.begins(&a.keys);
    same && a.entry().meets(b.entry())
}

fn preset(file: &mut TomlText<'_>, table: &DeTable<'_>) -> Preset {
    let Some(value) = table.get("preset") else {
        return Preset::Default;
    };
    let preset = value.get_ref().as_str().and_then(Preset::parse);
    if preset.is_none() {
        let names = Preset::ALL.map(|preset| format!("{:?}", preset.name()));
        let message = format!(
            "unknown preset {}; available: {}",
            shown_value(value.get_ref()),
            names.join(", ")
        );
        file.mistake(&value.span(), message);
    }
    preset.unwrap_or(Preset::Default)
}

fn change(file: &mut TomlText<'_>, map: &mut Keymap, table: &DeTable<'_>) {
    for (key, value) in table {
        let name = key.get_ref().as_ref();
        if name == "preset" || name == REMOVED_TABLE {
            continue;
        }
        let Some((scope, ..)) = Scope::ALL.iter().find(|(_, scope, _)| *scope == name) else {
            let names = Scope::ALL.map(|(_, name, _)| format!("[{name}]"));
            let message = format!(
                "unknown table `{name}`; available: preset, {}",
                names.join(", ")
            );
            file.mistake(&key.span(), message);
            continue;
        };
        let Some(actions) = file.below(name, value) else {
            continue;
        };
        for (id, keys) in actions {
            if id.get_ref() == REMOVED_ACTION {
                continue;
            }
            let Some(place) = place(*scope, id.get_ref()) else {
                let message = format!(
                    "unknown action `{name}.{}`{}",
                    id.get_ref(),
                    near(*scope, id.get_ref())
                );
                file.mistake(&id.span(), message);
                continue;
            };
            let key = format!("{name}.{}", id.get_ref());
            let keys = bindings(file, place, &key, keys);
            map.rebind(place, keys);
        }
    }
}

/// The table and the action of the screen of two prompt versions, which is gone. Files that `nearmiss config keys --format toml` wrote
/// before have both: the other keys of these files go on to hold.
const REMOVED_TABLE: &str = "versions";
const REMOVED_ACTION: &str = "compare-versions";

/// A note on the lines for the screen that is gone, where the file has some.
fn skipped(map: &Keymap, table: &DeTable<'_>) -> Option<String> {
    let has_action = |value: &Spanned<DeValue<'_>>| {
        let actions = value.get_ref().as_table();
        actions.is_some_and(|actions| actions.contains_key(REMOVED_ACTION))
    };
    let lines = table.iter().filter_map(|(key, value)| {
        let name = key.get_ref();
        if name == REMOVED_TABLE {
            Some(format!("[{name}]"))
        } else {
            has_action(value).then(|| format!("{name}.{REMOVED_ACTION}"))
        }
    });
    let lines: Vec<String> = lines.collect();
    (!lines.is_empty()).then(|| {
        format!(
            "keymap.toml: the screen of prompt versions is gone, remove {}; {} has a row for each version",
            lines.join(", "),
            map.key_of(Action::Results)
        )
    })
}

/// Names of actions in earlier versions, with those of today.
const RENAMED: [(&str, &str); 2] = [
    ("reset-template", "discard-draft"),
    ("certificate-map", "driver-map"),
];

fn place(scope: Scope, id: &str) -> Option<usize> {
    let renamed = RENAMED.iter().find(|(old, _)| *old == id);
    let id = renamed.map_or(id, |(_, new)| *new);
    let mut all = ACTIONS.iter();
    all.position(|entry| entry.scope == scope && entry.id == id)
}

/// The keys of an action: a text or a list of texts, none for an empty list.
fn bindings(
    file: &mut TomlText<'_>,
    place: usize,
    key: &str,
    value: &Spanned<DeValue<'_>>,
) -> Vec<Binding> {
    let one = std::slice::from_ref(value);
    let values: Vec<_> = match value.get_ref().as_array() {
        Some(array) => array.iter().collect(),
        None => one.iter().collect(),
    };
    let mut found: Vec<Binding> = Vec::new();
    for value in values {
        let Some(names) = value.get_ref().as_str() else {
            let message = format!(
                "{key} = {} is not a key; keys are texts such as \"x\", \"g g\" or [\"x\", \"ctrl-x\"]",
                shown_value(value.get_ref())
            );
            file.mistake(&value.span(), message);
            continue;
        };
        match Chord::parse(names) {
            Ok(keys) if found.iter().any(|b| b.keys == keys) => {
                file.mistake(&value.span(), format!("{key} has `{}` twice", keys.name()));
            }
            Ok(keys) => found.push(Binding {
                place,
                keys,
                span: Some(value.span()),
            }),
            Err(why) => file.mistake(&value.span(), format!("{key}: {why}")),
        }
    }
    found
}

/// The action that was probably meant.
fn near(scope: Scope, id: &str) -> String {
    let elsewhere = ACTIONS.iter().filter(|entry| entry.id == id);
    let places: Vec<String> = elsewhere.map(|e| format!("[{}]", e.scope.name())).collect();
    if !places.is_empty() {
        return format!("; it belongs to {}", places.join(" and "));
    }
    let here = ACTIONS.iter().filter(|entry| entry.scope == scope);
    match nearest(id, here.map(|entry| entry.id)) {
        Some(meant) => format!("; did you mean `{meant}`?"),
        None => "; `nearmiss config keys` lists all".into(),
    }
}

/// Two bindings that cannot both be.
#[derive(Debug)]
pub struct Collision {
    /// Where the file says one of them.
    pub span: Option<std::ops::Range<usize>>,
    binding: Binding,
    other: Binding,
}

impl Collision {
    fn message(&self, file: &TomlText<'_>) -> String {
        let entry = self.binding.entry();
        let other = self.other.entry();
        let (keys, theirs) = (self.binding.keys.name(), self.other.keys.name());
        // Bindings of the preset have given way.
        let line = self.other.span.as_ref().map_or(0, |span| file.line(span));
        let whose = format!("{}.{} in line {line}", other.scope.name(), other.id);
        let what = if keys == theirs {
            format!("is also the key of {whose}")
        } else if self.binding.keys.begins(&self.other.keys) {
            format!("is the beginning of `{theirs}`, the key of {whose}")
        } else {
            format!("begins with `{theirs}`, the key of {whose}")
        };
        format!(
            "{}.{}: `{keys}` {what}; give {} other keys, or none: {} = []",
            entry.scope.name(),
            entry.id,
            other.id,
            other.id
        )
    }
}

/// Keys with two meanings in one place, and keys that are the beginning of others.
pub fn collisions(map: &Keymap) -> Vec<Collision> {
    let mut found = Vec::new();
    for (i, a) in map.bindings.iter().enumerate() {
        for b in &map.bindings[i + 1..] {
            if !conflict(a, b) {
                continue;
            }
            // Told where the file says it; of two lines of the file, at the later one.
            let start = |binding: &Binding| binding.span.as_ref().map(|span| span.start);
            let (binding, other) = if start(a) > start(b) { (a, b) } else { (b, a) };
            found.push(Collision {
                span: binding.span.clone(),
                binding: binding.clone(),
                other: other.clone(),
            });
        }
    }
    found
}

/// Writes a character, takes the last one (Backspace), the last word (Ctrl-W) or everything (Ctrl-U); says whether the
/// key was one of these.
pub fn edit_line(line: &mut String, key: Key) -> bool {
    match (key.code, key.writes()) {
        (Code::Backspace, _) => drop(line.pop()),
        (Code::Char('u'), _) if key.ctrl && !key.alt => line.clear(),
        (Code::Char('w'), _) if key.ctrl && !key.alt => without_word(line),
        (_, Some(c)) => line.push(c),
        _ => return false,
    }
    true
}

/// Characters that are pasted into a line at most.
const LINE: usize = 1000;

/// The first line of a pasted text, and no more of it than a line can hold.
#[must_use]
pub fn first_line(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    line.chars().take(LINE).collect()
}

/// Takes the last word and the spaces behind it.
fn without_word(line: &mut String) {
    let words = line.trim_end();
    let start = words
        .char_indices()
        .rev()
        .find(|(_, c)| c.is_whitespace())
        .map_or(0, |(at, space)| at + space.len_utf8());
    line.truncate(start);
}

/// The old key of an action, where no pane has it now.
const MOVED: &[(&str, Action)] = &[
    ("%", Action::Results),
    ("!", Action::Generate),
    ("@", Action::GenerateWith),
    ("&", Action::ModelAttacks),
    ("#", Action::EditTags),
    (";", Action::Loop),
    ("backspace", Action::RecordedEgo),
    ("a", Action::FitMap),
    ("b", Action::Mark),
    ("d", Action::CloseAnswer),
    ("f", Action::ToggleFrame),
    ("i", Action::About),
    ("o", Action::SavePicture),
    ("s", Action::SortScenarios),
    ("t", Action::ToggleTask),
    ("u", Action::EgoUp),
    ("v", Action::PromptView),
    ("w", Action::Follow),
    ("shift-a", Action::AskMarked),
    ("shift-b", Action::BlindMode),
    ("shift-c", Action::CompareScreen),
    ("shift-d", Action::NextDisagreement),
    ("shift-e", Action::TakeAsEgo),
    ("shift-f", Action::NextForecast),
    ("shift-h", Action::HeatStrips),
    ("shift-i", Action::Details),
    ("shift-j", Action::TaskList),
    ("shift-k", Action::VariantPanel),
    ("shift-l", Action::Layers),
    ("shift-m", Action::MinimumStep),
    ("shift-o", Action::PlotDrives),
    ("shift-p", Action::NextPaths),
    ("shift-s", Action::GroupScenarios),
    ("shift-t", Action::TakeTape),
    ("shift-u", Action::SwitchVariant),
    ("shift-v", Action::Values),
    ("shift-w", Action::DrivePlanner),
    ("shift-x", Action::Source),
    ("shift-y", Action::PlannerCycle),
];

impl Keymap {
    /// Where the action of an old key went, such as `% does nothing now: results is Space o r`.
    #[must_use]
    pub fn moved(&self, key: Key) -> Option<String> {
        let name = key.name();
        let (_, action) = MOVED.iter().find(|(old, _)| *old == name)?;
        let entry = ACTIONS.iter().find(|entry| entry.action == *action)?;
        let now = self.key_of(*action);
        Some(format!("{key} does nothing now: {} is {now}", entry.id))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::action::Scope;
    use crate::keymap::{KeyMeaning, Preset};

    fn mistakes(text: &str) -> Vec<String> {
        Keymap::parse("keymap.toml", text).unwrap_err()
    }

    #[test]
    fn keys_are_changed_taken_off_and_added() {
        let text =
            "[global]\nworst = []\npalette = \"f9\"\nquit = [\"q\", \"space q\"]\nplay = \"f5\"\n";
        let map = Keymap::parse("keymap.toml", text).unwrap();
        let means = |names: &str| map.meaning(&Chord::parse(names).unwrap().0, Scope::Map);
        assert_eq!(means("f9"), KeyMeaning::Action(Action::Palette));
        assert_eq!(means("x"), KeyMeaning::Nothing);
        assert_eq!(means(":"), KeyMeaning::Nothing);
        assert_eq!(means("space"), KeyMeaning::Prefix);
        assert_eq!(means("space q"), KeyMeaning::Action(Action::Quit));
        assert_eq!(map.key_of(Action::CollisionStep), "F9 worst");
    }

    #[test]
    fn presets_are_what_a_file_begins_with() {
        let map = Keymap::parse(
            "keymap.toml",
            "preset = \"vim\"\n[scenarios]\ntop = \"g k\"\n",
        )
        .unwrap();
        let means = |names: &str| map.meaning(&Chord::parse(names).unwrap().0, Scope::Scenarios);
        assert_eq!(means("g k"), KeyMeaning::Action(Action::Top));
        assert_eq!(means("g g"), KeyMeaning::Nothing);
        assert_eq!(
            means("shift-n"),
            KeyMeaning::Action(Action::PreviousObstacle)
        );
        // The preset's own file has no mistake.
        let vim = Keymap::parse("vim.toml", VIM).unwrap();
        assert_eq!(
            vim.bindings.len(),
            Keymap::from_preset(Preset::Vim).bindings.len()
        );
        assert_eq!(
            Keymap::parse("keymap.toml", "").unwrap(),
            Keymap::from_preset(Preset::Default)
        );
    }

    #[test]
    fn mistakes_are_named_by_line_and_key() {
        let text = "preset = \"emacs\"\nkeys = 1\n[global]\nqit = \"q\"\ntop = \"t\"\nplay = \"hyper-x\"\nhelp = 3\n[nowhere]\n";
        let found = [
            "keymap.toml:1: unknown preset \"emacs\"; available: \"default\", \"vim\"",
            "keymap.toml:2: unknown table `keys`",
            "keymap.toml:4: unknown action `global.qit`; did you mean `quit`?",
            "keymap.toml:5: unknown action `global.top`; it belongs to [scenarios] and [text]",
            "keymap.toml:6: global.play: `hyper-x` is not a key",
            "keymap.toml:7: global.help = 3 is not a key",
            "keymap.toml:8: unknown table `nowhere`",
        ];
        let mistakes = mistakes(text);
        assert_eq!(mistakes.len(), found.len(), "{mistakes:#?}");
        for (mistake, start) in mistakes.iter().zip(found) {
            assert!(mistake.starts_with(start), "{mistake}");
        }
        assert!(self::mistakes("a = \n")[0].starts_with("keymap.toml:1: "));
    }

    #[test]
    fn keys_of_the_removed_screen_are_skipped_with_a_note() {
        let text = "[global]\ncompare-versions = [\"space a b\"]\nplay = \"f5\"\n\
                    [editor]\ncompare-versions = [\"alt-c\", \"f7\"]\n\
                    [versions]\nopen-versions = [\"enter\"]\nup = [\"up\"]\n";
        let map = Keymap::parse("keymap.toml", text).unwrap();
        assert_eq!(map.key_of(Action::Play), "F5");
        let note = "keymap.toml: the screen of prompt versions is gone, remove editor.compare-versions, \
                    global.compare-versions, [versions]; Space o r has a row for each version";
        assert_eq!(map.notes, [note]);
        // Nor is what is wrong elsewhere in such a file passed over.
        let wrong = mistakes(&format!("{text}[map]\nopen-versions = \"f9\"\n"));
        assert_eq!(wrong.len(), 1, "{wrong:#?}");
        assert!(wrong[0].contains("unknown action `map.open-versions`"));
    }

    #[test]
    fn collisions_say_with_what() {
        for (text, words) in [
            (
                "[global]\nplay = \"f5\"\nworst = \"f5\"\n",
                "keymap.toml:3: global.worst: `f5` is also the key of global.play in line 2; give play other keys",
            ),
            (
                "[global]\nplay = \"f5 a\"\nworst = \"f5\"\n",
                "keymap.toml:3: global.worst: `f5` is the beginning of `f5 a`, the key of global.play in line 2",
            ),
            (
                "[global]\nplay = [\"f5\", \"f5\"]\n",
                "keymap.toml:2: global.play has `f5` twice",
            ),
            (
                "[global]\nplay = \"ctrl-c\"\n",
                "keymap.toml:2: global.play: `ctrl-c` always",
            ),
        ] {
            let mistakes = mistakes(text);
            assert!(mistakes[0].starts_with(words), "{mistakes:#?}");
        }
        // Where two places never meet, keys do not either.
        assert!(Keymap::parse("f", "[map]\npan-left = \"f6\"\n[text]\ntop = \"f6\"\n").is_ok());
    }

    #[test]
    fn keys_of_a_file_win_over_those_of_the_preset() {
        // As `nearmiss config keys --format toml` wrote them before there were menus.
        let text = "[global]\nplay = [\"space\"]\nresults = [\"%\"]\ncp = [\"1\"]\n[text]\ntop = [\"g\"]\n";
        let map = Keymap::parse("keymap.toml", text).unwrap();
        let means = |names: &str, scope| map.meaning(&Chord::parse(names).unwrap().0, scope);
        for (names, action) in [
            ("space", Action::Play),
            ("%", Action::Results),
            ("1", Action::ToggleCp),
            ("g", Action::Top),
        ] {
            let meaning = means(names, Scope::Text);
            assert_eq!(meaning, KeyMeaning::Action(action), "{names}");
        }
        assert_eq!(means("space o h", Scope::Map), KeyMeaning::Nothing);
        // An action whose chord is gone is in the palette.
        assert_eq!(map.key_of(Action::Values), ": values");
        assert_eq!(map.notes.len(), 2, "{:?}", map.notes);
        assert!(map.notes[0].contains("`space` to global.play"));
        // A key of the preset does not stand in the way of one of the file.
        let map = Keymap::parse("keymap.toml", "[global]\nplay = \"x\"\n").unwrap();
        let x = map.meaning(&Chord::parse("x").unwrap().0, Scope::Map);
        assert_eq!(x, KeyMeaning::Action(Action::Play));
        assert_eq!(map.key_of(Action::CollisionStep), "g w");
        assert!(map.notes.is_empty());
    }

    #[test]
    fn keys_write_and_take_away() {
        let mut line = String::new();
        let mut press = |names: &str| {
            for name in names.split(' ') {
                assert!(edit_line(&mut line, Key::parse(name).unwrap()), "{name}");
            }
            line.clone()
        };
        assert_eq!(press("ü b space c d"), "üb cd");
        assert_eq!(press("space space ctrl-w"), "üb ");
        assert_eq!(press("ctrl-w"), "");
        assert_eq!(press("ctrl-w backspace ctrl-u"), "");
        assert_eq!(press("a space b ctrl-u"), "");
        assert_eq!(press("a b backspace"), "a");
        for other in ["ctrl-a", "alt-u", "enter", "up", "f5"] {
            assert!(!edit_line(&mut line, Key::parse(other).unwrap()), "{other}");
        }
        assert_eq!(line, "a");
    }

    #[test]
    fn old_keys_are_free_on_the_main_screen_and_say_where_they_went() {
        let map = Keymap::from_preset(Preset::Default);
        for (old, action) in MOVED {
            let key = Key::parse(old).unwrap();
            assert_eq!(key.name(), *old);
            for scope in [Scope::Scenarios, Scope::Map, Scope::Text, Scope::Plot] {
                assert_eq!(map.meaning(&[key], scope), KeyMeaning::Nothing, "{old}");
            }
            let said = map.moved(key).unwrap();
            assert!(said.ends_with(&map.key_of(*action)), "{said}");
        }
        let percent = Key::parse("%").unwrap();
        assert_eq!(
            map.moved(percent).as_deref(),
            Some("% does nothing now: results is Space o r")
        );
        assert_eq!(map.moved(Key::parse("shift-z").unwrap()), None);
    }
}

//! Keys: terminal events translated to our own, key names, and bindings per context.
//!
//! Cyrillic and Greek keyboard layouts: the Latin character on the same physical key.
//!
//! A letter without a binding is read as the Latin letter on its key in the usual Russian, Ukrainian and Greek
//! layouts. Keys that type other ASCII characters there (such as `.` where Latin keyboards have `/`) are ambiguous and
//! stay what they type.

mod file;
mod lookup;

use nearmiss_scene::description::visible;
use std::fmt::{Display, Formatter};

use crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

pub use file::{edit_line, first_line};
pub use lookup::{KeyMeaning, Keymap, Preset, as_bindings, as_file, as_table};

/// A key with its modifiers. Shifted letters are capitals with `shift` off, unless named `shift-x`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Key {
    /// Which.
    pub code: Code,
    /// With Ctrl.
    pub ctrl: bool,
    /// With Alt.
    pub alt: bool,
    /// With Shift; never for characters, which carry it themselves.
    pub shift: bool,
}

/// The keys that have names, with ours and the terminal's codes for them.
macro_rules! codes {
    ($($code:ident $name:literal,)+) => {
        /// A key without modifiers.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[allow(missing_docs, reason = "the names of the keys")]
        pub enum Code {
            Char(char),
            Function(u8),
            $($code,)+
        }

        const KEY_NAMES: &[(&str, Code)] = &[("space", Code::Char(' ')), $(($name, Code::$code),)+];

        impl Code {
            fn of_terminal(code: KeyCode) -> Option<Self> {
                Some(match code {
                    KeyCode::Char(c) => Self::Char(c),
                    KeyCode::F(n) => Self::Function(n),
                    $(KeyCode::$code => Self::$code,)+
                    _ => return None,
                })
            }
        }
    };
}

codes! {
    Up "up",
    Down "down",
    Left "left",
    Right "right",
    Home "home",
    End "end",
    PageUp "pageup",
    PageDown "pagedown",
    Enter "enter",
    Esc "esc",
    Tab "tab",
    BackTab "backtab",
    Backspace "backspace",
    Delete "delete",
}

/// The function key of a name, `f1` to `f12`.
fn function_key(name: &str) -> Option<Code> {
    let known = (1..=12).find(|n| name == format!("f{n}"));
    known.map(Code::Function)
}

impl Key {
    /// A key without modifiers.
    #[must_use]
    pub fn plain(code: Code) -> Self {
        Self {
            code,
            ctrl: false,
            alt: false,
            shift: false,
        }
    }

    /// The key with this name, such as `a`, `shift-a`, `ctrl-p`, `pageup`.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        let (mut rest, mut key) = (name, Self::plain(Code::Esc));
        loop {
            let (modifier, after) = match rest.split_once('-') {
                Some((modifier, after)) if !after.is_empty() && !modifier.is_empty() => {
                    (modifier, after)
                }
                _ => break,
            };
            match modifier {
                "ctrl" => key.ctrl = true,
                "alt" => key.alt = true,
                "shift" => key.shift = true,
                _ => return None,
            }
            rest = after;
        }
        let named = KEY_NAMES
            .iter()
            .find(|(n, _)| *n == rest)
            .map(|(_, code)| *code);
        let mut chars = rest.chars();
        let single = chars
            .next()
            .filter(|_| chars.next().is_none())
            .map(Code::Char);
        key.code = named.or_else(|| function_key(rest)).or(single)?;
        if let Code::Char(c) = key.code
            && key.shift
        {
            key.code = Code::Char(c.to_ascii_uppercase());
            key.shift = false;
        }
        Some(key)
    }

    /// The name of the key, as [`Key::parse`] and keymap files have it.
    #[must_use]
    pub fn name(&self) -> String {
        let mut name = String::new();
        let capital = matches!(self.code, Code::Char(c) if c.is_ascii_uppercase());
        for (on, text) in [
            (self.ctrl, "ctrl-"),
            (self.alt, "alt-"),
            (self.shift || capital, "shift-"),
        ] {
            if on {
                name.push_str(text);
            }
        }
        match (
            KEY_NAMES.iter().find(|(_, code)| *code == self.code),
            self.code,
        ) {
            (Some((word, _)), _) => name.push_str(word),
            (None, Code::Char(c)) => name.push(c.to_ascii_lowercase()),
            // Every other key is named.
            (None, Code::Function(n)) => name.push_str(&format!("f{n}")),
            (None, _) => {}
        }
        name
    }

    /// The key of a terminal's event; releases and keys that mean nothing to us give none.
    #[must_use]
    pub fn of_event(event: &KeyEvent) -> Option<Self> {
        if event.kind == KeyEventKind::Release {
            return None;
        }
        let code = Code::of_terminal(event.code)?;
        let with = |modifier| event.modifiers.contains(modifier);
        let ctrl = with(KeyModifiers::CONTROL);
        // The newer protocols tell these apart; hands do not.
        let teletype = match code {
            Code::Char('i') if ctrl => Some(Code::Tab),
            Code::Char('m') if ctrl => Some(Code::Enter),
            Code::Char('[') if ctrl => Some(Code::Esc),
            _ => None,
        };
        let (code, ctrl) = teletype.map_or((code, ctrl), |code| (code, false));
        Some(Self {
            code,
            ctrl,
            alt: with(KeyModifiers::ALT),
            shift: with(KeyModifiers::SHIFT) && !matches!(code, Code::Char(_) | Code::BackTab),
        })
    }

    /// The digit that the key writes.
    #[must_use]
    pub fn digit(&self) -> Option<u32> {
        self.writes()?.to_digit(10)
    }

    /// The character that the key writes into a text, if it writes one.
    #[must_use]
    pub fn writes(&self) -> Option<char> {
        match self.code {
            Code::Char(c) if !self.ctrl && !self.alt => Some(c),
            _ => None,
        }
    }
}

impl std::fmt::Display for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let prefix = [
            (self.ctrl, "Ctrl-"),
            (self.alt, "Alt-"),
            (self.shift, "Shift-"),
        ];
        for (on, text) in prefix {
            if on {
                f.write_str(text)?;
            }
        }
        match self.code {
            Code::Char(' ') => f.write_str("Space"),
            Code::Char(c) => write!(f, "{c}"),
            Code::Function(n) => write!(f, "F{n}"),
            Code::Up => f.write_str("↑"),
            Code::Down => f.write_str("↓"),
            Code::Left => f.write_str("←"),
            Code::Right => f.write_str("→"),
            Code::PageUp => f.write_str("PgUp"),
            Code::PageDown => f.write_str("PgDn"),
            Code::BackTab => f.write_str("Shift-Tab"),
            other => write!(f, "{other:?}"),
        }
    }
}

/// The key as the template editor takes it; `None` for keys it does not know.
#[must_use]
pub fn editor_input(key: Key) -> Option<edtui::events::KeyInput> {
    let code = match key.code {
        Code::Char(c) => KeyCode::Char(c),
        Code::Up => KeyCode::Up,
        Code::Down => KeyCode::Down,
        Code::Left => KeyCode::Left,
        Code::Right => KeyCode::Right,
        Code::Home => KeyCode::Home,
        Code::End => KeyCode::End,
        Code::PageUp => KeyCode::PageUp,
        Code::PageDown => KeyCode::PageDown,
        Code::Enter => KeyCode::Enter,
        Code::Tab => KeyCode::Tab,
        Code::Backspace => KeyCode::Backspace,
        Code::Delete => KeyCode::Delete,
        Code::Esc => KeyCode::Esc,
        Code::BackTab | Code::Function(_) => return None,
    };
    let mut modifiers = KeyModifiers::NONE;
    modifiers.set(KeyModifiers::CONTROL, key.ctrl);
    modifiers.set(KeyModifiers::ALT, key.alt);
    // Its tables of keys have capitals with Shift.
    let capital = matches!(key.code, Code::Char(c) if c.is_uppercase());
    modifiers.set(KeyModifiers::SHIFT, capital);
    Some(edtui::events::KeyInput::with_modifiers(code, modifiers))
}

/// One key or a sequence, such as `g g` or `ctrl-w w`.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Chord(pub Vec<Key>);

impl Chord {
    /// The keys with these names, separated by spaces.
    ///
    /// # Errors
    /// One of them is no key, or one that no terminal sends.
    pub fn parse(names: &str) -> Result<Self, String> {
        let keys = names.split(' ').filter(|name| !name.is_empty());
        let keys: Vec<Key> = keys.map(key).collect::<Result<_, _>>()?;
        if keys.is_empty() {
            return Err("a key is missing; [] takes all keys off an action".into());
        }
        Ok(Self(keys))
    }

    /// Its names, as [`Chord::parse`] reads them.
    #[must_use]
    pub fn name(&self) -> String {
        let names: Vec<String> = self.0.iter().map(Key::name).collect();
        names.join(" ")
    }

    /// Whether `other` starts with these keys and is longer.
    #[must_use]
    pub fn begins(&self, other: &Self) -> bool {
        other.0.len() > self.0.len() && other.0.starts_with(&self.0)
    }
}

impl Display for Chord {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        for (i, key) in self.0.iter().enumerate() {
            if i > 0 {
                f.write_str(" ")?;
            }
            key.fmt(f)?;
        }
        Ok(())
    }
}

fn key(name: &str) -> Result<Key, String> {
    let Some(key) = Key::parse(name) else {
        return Err(format!(
            "`{name}` is not a key; keys are characters, space, enter, esc, tab, backtab, backspace, delete, up, down, \
             left, right, home, end, pageup, pagedown and f1 to f12, with ctrl-, alt- or shift- before them"
        ));
    };
    // Without the newer protocols these have been one and the same code since the teletype.
    let same = match (key.ctrl, key.code) {
        (true, Code::Char('i')) => Some("tab"),
        (true, Code::Char('m')) => Some("enter"),
        (true, Code::Char('[')) => Some("esc"),
        _ => None,
    };
    match same {
        Some(other) => Err(format!("`{name}` reaches the program as {other}")),
        None if key.ctrl && key.code == Code::Char('c') => {
            Err("`ctrl-c` always cancels what runs, and quits".into())
        }
        None => Ok(key),
    }
}

const LETTERS: [(&str, &str); 3] = [
    (
        "йцукенгшщзхъфывапролджэячсмитьбюё",
        "qwertyuiop[]asdfghjkl;'zxcvbnm,.`",
    ),
    ("іїєґ", "s]'\\"),
    ("ςερτυθιοπασδφγηξκλζχψωβνμ", "wertyuiopasdfghjklzxcvbnm"),
];

/// Shifted symbols of the keys that are no letters on a Latin keyboard.
const SHIFTED: [(char, char); 8] = [
    ('[', '{'),
    (']', '}'),
    (';', ':'),
    ('\'', '"'),
    (',', '<'),
    ('.', '>'),
    ('`', '~'),
    ('\\', '|'),
];

/// The same key on a Latin keyboard, for a key with a Cyrillic or Greek letter.
#[must_use]
pub fn latin(key: Key) -> Option<Key> {
    let Code::Char(typed) = key.code else {
        return None;
    };
    let lower = typed.to_lowercase().next()?;
    let there = LETTERS.iter().find_map(|(letters, keys)| {
        let mut pairs = letters.chars().zip(keys.chars());
        pairs
            .find(|(letter, _)| *letter == lower)
            .map(|(_, key)| key)
    })?;
    let shifted = || SHIFTED.iter().find(|(plain, _)| *plain == there);
    let code = if lower == typed {
        there
    } else {
        shifted().map_or(there.to_ascii_uppercase(), |(_, upper)| *upper)
    };
    Some(Key {
        code: Code::Char(code),
        ..key
    })
}

/// Mistakes that are safe to show, whatever they quote.
pub fn all_visible(mistakes: Vec<String>) -> Vec<String> {
    let shown = |mistake: String| visible(&mistake).into_owned();
    mistakes.into_iter().map(shown).collect()
}

/// The first mistake, and how many more there are.
pub fn first_mistake(mistakes: &[String]) -> String {
    match mistakes {
        [] => String::new(),
        [one] => one.clone(),
        [one, more @ ..] => format!("{one} (and {} more)", more.len()),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn names() {
        assert_eq!(Key::parse("-"), Some(Key::plain(Code::Char('-'))));
        assert_eq!(Key::parse("shift-g"), Some(Key::plain(Code::Char('G'))));
        assert_eq!(
            Key::parse("ctrl-p").map(|k| k.to_string()),
            Some("Ctrl-p".into())
        );
        assert_eq!(Key::parse("hyper-x"), None);
        for name in [
            "a",
            "shift-a",
            "ctrl-w",
            "alt-pageup",
            "shift-left",
            "-",
            "$",
            "f12",
            "space",
        ] {
            assert_eq!(
                Key::parse(name).map(|key| key.name()).as_deref(),
                Some(name)
            );
        }
    }

    #[test]
    fn releases_are_no_keys() {
        let mut event = KeyEvent::new(KeyCode::Char('a'), KeyModifiers::SHIFT);
        assert_eq!(Key::of_event(&event), Some(Key::plain(Code::Char('a'))));
        event.kind = KeyEventKind::Release;
        assert_eq!(Key::of_event(&event), None);
    }

    #[test]
    fn names_of_chords() {
        let chord = Chord::parse("ctrl-w shift-w").unwrap();
        assert_eq!(chord.to_string(), "Ctrl-w W");
        assert_eq!(chord.name(), "ctrl-w shift-w");
        assert!(Chord::parse("ctrl-w").unwrap().begins(&chord));
        assert!(!chord.begins(&chord));
        assert_eq!(Chord::parse("g  g").unwrap(), Chord::parse("g g").unwrap());
        for (wrong, why) in [
            ("", "missing"),
            ("g hyper-x", "hyper-x"),
            ("ctrl-i", "tab"),
            ("ctrl-c", "cancels"),
        ] {
            assert!(Chord::parse(wrong).unwrap_err().contains(why), "{wrong}");
        }
    }

    #[test]
    fn letters_are_where_they_are() {
        let of = |c| latin(Key::plain(Code::Char(c))).map(|key| key.name());
        for (letter, key) in [
            ('й', "q"),
            ('О', "shift-j"),
            ('Ж', ":"),
            ('і', "s"),
            ('γ', "g"),
            ('Γ', "shift-g"),
            ('μ', "m"),
        ] {
            assert_eq!(of(letter).as_deref(), Some(key), "{letter}");
        }
        assert_eq!(of('a'), None);
        assert_eq!(of('日'), None);
        for (letters, keys) in LETTERS {
            assert_eq!(letters.chars().count(), keys.chars().count());
        }
    }
}

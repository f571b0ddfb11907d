//! Keys: from the terminal's events to our own, their names, and what they mean where.

use crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use super::action::{ACTIONS, Action, Entry, Scope};

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

/// A key without modifiers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the names of the keys")]
pub enum Code {
    Char(char),
    Function(u8),
    Up,
    Down,
    Left,
    Right,
    Home,
    End,
    PageUp,
    PageDown,
    Enter,
    Esc,
    Tab,
    BackTab,
    Backspace,
    Delete,
}

const NAMED: &[(&str, Code)] = &[
    ("space", Code::Char(' ')),
    ("up", Code::Up),
    ("down", Code::Down),
    ("left", Code::Left),
    ("right", Code::Right),
    ("home", Code::Home),
    ("end", Code::End),
    ("pageup", Code::PageUp),
    ("pagedown", Code::PageDown),
    ("enter", Code::Enter),
    ("esc", Code::Esc),
    ("tab", Code::Tab),
    ("backtab", Code::BackTab),
    ("backspace", Code::Backspace),
    ("delete", Code::Delete),
    ("f1", Code::Function(1)),
];

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
        let named = NAMED
            .iter()
            .find(|(n, _)| *n == rest)
            .map(|(_, code)| *code);
        let mut chars = rest.chars();
        let single = chars
            .next()
            .filter(|_| chars.next().is_none())
            .map(Code::Char);
        key.code = named.or(single)?;
        if let Code::Char(c) = key.code
            && key.shift
        {
            key.code = Code::Char(c.to_ascii_uppercase());
            key.shift = false;
        }
        Some(key)
    }

    /// The key of a terminal's event; releases and keys that mean nothing to us give none.
    #[must_use]
    pub fn of_event(event: &KeyEvent) -> Option<Self> {
        if event.kind == KeyEventKind::Release {
            return None;
        }
        let code = match event.code {
            KeyCode::Char(c) => Code::Char(c),
            KeyCode::F(n) => Code::Function(n),
            KeyCode::Up => Code::Up,
            KeyCode::Down => Code::Down,
            KeyCode::Left => Code::Left,
            KeyCode::Right => Code::Right,
            KeyCode::Home => Code::Home,
            KeyCode::End => Code::End,
            KeyCode::PageUp => Code::PageUp,
            KeyCode::PageDown => Code::PageDown,
            KeyCode::Enter => Code::Enter,
            KeyCode::Esc => Code::Esc,
            KeyCode::Tab => Code::Tab,
            KeyCode::BackTab => Code::BackTab,
            KeyCode::Backspace => Code::Backspace,
            KeyCode::Delete => Code::Delete,
            _ => return None,
        };
        let with = |modifier| event.modifiers.contains(modifier);
        Some(Self {
            code,
            ctrl: with(KeyModifiers::CONTROL),
            alt: with(KeyModifiers::ALT),
            shift: with(KeyModifiers::SHIFT) && !matches!(code, Code::Char(_) | Code::BackTab),
        })
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
            Code::Char(' ') => f.write_str("space"),
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

/// What `key` does where `scope` holds; what holds there comes before what holds everywhere.
#[must_use]
pub fn action(key: Key, scope: Scope) -> Option<Action> {
    let bound = |scope: Scope| {
        let mut entries = ACTIONS.iter().filter(move |e| e.scope == scope);
        entries
            .find(|e| keys(e).any(|k| k == key))
            .map(|e| e.action)
    };
    bound(scope).or_else(|| bound(Scope::Global).filter(|_| scope.inherits()))
}

/// The key as the template editor takes it; nothing for keys it does not know.
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
        Code::Esc | Code::BackTab | Code::Function(_) => return None,
    };
    let mut modifiers = KeyModifiers::NONE;
    modifiers.set(KeyModifiers::CONTROL, key.ctrl);
    modifiers.set(KeyModifiers::ALT, key.alt);
    Some(edtui::events::KeyInput::with_modifiers(code, modifiers))
}

/// The keys of an action.
pub fn keys(entry: &Entry) -> impl Iterator<Item = Key> + use<> {
    entry.keys.iter().filter_map(|name| Key::parse(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_of_the_table_has_a_meaning() {
        for entry in ACTIONS {
            assert_eq!(keys(entry).count(), entry.keys.len(), "{}", entry.id);
            for key in keys(entry) {
                assert_eq!(action(key, entry.scope), Some(entry.action), "{key}");
            }
        }
    }

    #[test]
    fn names() {
        assert_eq!(Key::parse("-"), Some(Key::plain(Code::Char('-'))));
        assert_eq!(Key::parse("shift-g"), Some(Key::plain(Code::Char('G'))));
        assert_eq!(
            Key::parse("ctrl-p").map(|k| k.to_string()),
            Some("Ctrl-p".into())
        );
        assert_eq!(Key::parse("hyper-x"), None);
    }

    #[test]
    fn releases_are_no_keys() {
        let mut event = KeyEvent::new(KeyCode::Char('a'), KeyModifiers::SHIFT);
        assert_eq!(Key::of_event(&event), Some(Key::plain(Code::Char('a'))));
        event.kind = KeyEventKind::Release;
        assert_eq!(Key::of_event(&event), None);
    }
}

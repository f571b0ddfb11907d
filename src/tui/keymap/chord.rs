//! Chords: sequences of keys, most often of one.

use std::fmt::{Display, Formatter};

use super::{Code, Key};

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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

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
}

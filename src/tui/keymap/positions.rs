//! Cyrillic and Greek keyboard layouts: the Latin character on the same physical key.
//!
//! A letter without a binding is read as the Latin letter on its key in the usual Russian, Ukrainian and Greek
//! layouts. Keys that type other ASCII characters there (such as `.` where Latin keyboards have `/`) are ambiguous and
//! stay what they type.

use super::{Code, Key};

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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

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

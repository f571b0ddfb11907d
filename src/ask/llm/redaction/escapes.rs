//! Decodes escapes in a stream: `%41`, `\u0041` and the other escapes of JSON, `\x41`, `&#65;`.

/// A byte that a text means, and where in the text it is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Unit {
    pub byte: u8,
    pub start: usize,
    pub end: usize,
}

/// Whether an escape can begin with this byte.
pub(super) fn begins(byte: u8) -> bool {
    matches!(byte, b'%' | b'\\' | b'&')
}

/// Takes back one layer of escapes; what stands inside an escape of another kind needs another layer.
#[derive(Default)]
pub(super) struct Escapes {
    /// Bytes that may become an escape.
    pending: Vec<Unit>,
}

impl Escapes {
    /// Where the escape begins of which more has to come.
    pub fn begun(&self) -> Option<usize> {
        self.pending.first().map(|unit| unit.start)
    }

    /// Whether this byte comes out as it is, at once.
    pub fn passes(&self, byte: u8) -> bool {
        self.pending.is_empty() && !begins(byte)
    }

    /// Takes a unit, and gives those that are certain now.
    pub fn push(&mut self, unit: Unit, mut each: impl FnMut(Unit)) {
        self.pending.push(unit);
        while let (Some(first), Some(last)) = (self.pending.first(), self.pending.last()) {
            let bytes: Vec<u8> = self.pending.iter().map(|unit| unit.byte).collect();
            match meaning(&bytes) {
                Meaning::Unfinished => return,
                Meaning::Itself => {
                    each(*first);
                    self.pending.remove(0);
                }
                Meaning::Character(length, meant) => {
                    let end = self.pending.get(length - 1).unwrap_or(last).end;
                    let start = first.start;
                    let mut buffer = [0; 4];
                    for byte in meant.encode_utf8(&mut buffer).bytes() {
                        each(Unit { byte, start, end });
                    }
                    self.pending.drain(..length);
                }
                Meaning::Byte(length, byte) => {
                    let end = self.pending.get(length - 1).unwrap_or(last).end;
                    let start = first.start;
                    each(Unit { byte, start, end });
                    self.pending.drain(..length);
                }
            }
        }
    }
}

/// Meaning of the first of some bytes, at least one.
#[derive(Debug, PartialEq, Eq)]
enum Meaning {
    /// An escape of this length in bytes, for a character.
    Character(usize, char),
    /// The same for a byte, which may be part of a character.
    Byte(usize, u8),
    /// No escape.
    Itself,
    /// That depends on what follows.
    Unfinished,
}

fn meaning(bytes: &[u8]) -> Meaning {
    match bytes {
        [b'%'] | [b'\\'] | [b'&'] => Meaning::Unfinished,
        [b'%', b'u' | b'U', ..] => utf16(bytes, Meaning::Itself),
        [b'%', rest @ ..] => match digits(rest, 2) {
            Digits::Are(value) => Meaning::Byte(3, u8::try_from(value).unwrap_or_default()),
            Digits::Unfinished => Meaning::Unfinished,
            Digits::Not => Meaning::Itself,
        },
        [b'\\', c, rest @ ..] => backslash(bytes, *c, rest),
        [b'&', rest @ ..] => entity(rest),
        _ => Meaning::Itself,
    }
}

fn backslash(bytes: &[u8], c: u8, rest: &[u8]) -> Meaning {
    let plain = Meaning::Byte(2, c);
    match c {
        b'u' => match rest {
            [] => Meaning::Unfinished,
            [b'{', rest @ ..] => braced(rest, plain),
            _ => utf16(bytes, plain),
        },
        b'x' => match digits(rest, 2) {
            Digits::Are(value) => Meaning::Character(4, char_of(value)),
            Digits::Unfinished => Meaning::Unfinished,
            Digits::Not => plain,
        },
        b'n' => Meaning::Byte(2, b'\n'),
        b'r' => Meaning::Byte(2, b'\r'),
        b't' => Meaning::Byte(2, b'\t'),
        b'b' => Meaning::Byte(2, 8),
        b'f' => Meaning::Byte(2, 12),
        // `\/` and `\"`, but also `\s`, which is no escape of JSON, and which lenient readers take for the letter.
        _ => plain,
    }
}

/// `\u0041` or `%u0041`; two of them for a character that needs two.
fn utf16(bytes: &[u8], otherwise: Meaning) -> Meaning {
    let first = match digits(&bytes[2..], 4) {
        Digits::Are(value) => value,
        Digits::Unfinished => return Meaning::Unfinished,
        Digits::Not => return otherwise,
    };
    if !(0xD800..0xDC00).contains(&first) {
        return Meaning::Character(6, char_of(first));
    }
    let lone = Meaning::Character(6, char::REPLACEMENT_CHARACTER);
    let rest = &bytes[6..];
    let same = rest.iter().zip(&bytes[..2]).all(|(a, b)| a == b);
    match digits(rest.get(2..).unwrap_or_default(), 4) {
        _ if !same => lone,
        Digits::Are(second @ 0xDC00..0xE000) => {
            let whole = 0x10000 + ((first - 0xD800) << 10) + (second - 0xDC00);
            Meaning::Character(12, char_of(whole))
        }
        Digits::Unfinished => Meaning::Unfinished,
        Digits::Are(_) | Digits::Not => lone,
    }
}

/// Parses what follows `\u{`.
fn braced(rest: &[u8], otherwise: Meaning) -> Meaning {
    let count = rest.iter().take_while(|b| b.is_ascii_hexdigit()).count();
    match (rest.get(count), digits(rest, count)) {
        (None, _) if count <= 6 => Meaning::Unfinished,
        (Some(b'}'), Digits::Are(value)) if (1..=6).contains(&count) => {
            Meaning::Character(count + 4, char_of(value))
        }
        _ => otherwise,
    }
}

/// Parses what follows `&`.
fn entity(rest: &[u8]) -> Meaning {
    const NAMES: [(&[u8], char); 6] = [
        (b"amp;", '&'),
        (b"lt;", '<'),
        (b"gt;", '>'),
        (b"quot;", '"'),
        (b"apos;", '\''),
        (b"nbsp;", '\u{a0}'),
    ];
    if let [b'#', rest @ ..] = rest {
        return numbered(rest);
    }
    for (name, meant) in NAMES {
        if rest.starts_with(name) {
            return Meaning::Character(name.len() + 1, meant);
        }
    }
    if NAMES.iter().any(|(name, _)| name.starts_with(rest)) {
        Meaning::Unfinished
    } else {
        Meaning::Itself
    }
}

/// Parses what follows `&#`.
fn numbered(rest: &[u8]) -> Meaning {
    let (from, radix) = match rest {
        [b'x' | b'X', ..] => (1, 16),
        _ => (0, 10),
    };
    let number = rest.get(from..).unwrap_or_default();
    let digit = |b: &&u8| char::from(**b).is_digit(radix);
    let count = number.iter().take_while(digit).count();
    if count > 7 {
        return Meaning::Itself;
    }
    match number.get(count) {
        None => Meaning::Unfinished,
        Some(b';') if count > 0 => {
            let text = std::str::from_utf8(&number[..count]).unwrap_or_default();
            let value = u32::from_str_radix(text, radix).unwrap_or_default();
            Meaning::Character(from + count + 3, char_of(value))
        }
        Some(_) => Meaning::Itself,
    }
}

enum Digits {
    Are(u32),
    Not,
    Unfinished,
}

/// The value of `count` hexadecimal digits.
fn digits(bytes: &[u8], count: usize) -> Digits {
    let mut value = 0;
    for at in 0..count {
        match bytes.get(at).map(|b| char::from(*b).to_digit(16)) {
            None => return Digits::Unfinished,
            Some(None) => return Digits::Not,
            Some(Some(digit)) => value = (value << 4) | digit,
        }
    }
    Digits::Are(value)
}

fn char_of(value: u32) -> char {
    char::from_u32(value).unwrap_or(char::REPLACEMENT_CHARACTER)
}

/// The text that another one means after one layer of escapes is taken back: those that begin with one of these bytes.
pub(super) fn taken_back(text: &[u8], kinds: &[u8]) -> Vec<u8> {
    let (mut meant, mut rest) = (Vec::new(), text);
    while let [first, after @ ..] = rest {
        let meaning = if kinds.contains(first) {
            meaning(rest)
        } else {
            Meaning::Itself
        };
        rest = match meaning {
            Meaning::Itself | Meaning::Unfinished => {
                meant.push(*first);
                after
            }
            Meaning::Byte(length, byte) => {
                meant.push(byte);
                &rest[length..]
            }
            Meaning::Character(length, c) => {
                meant.extend(c.encode_utf8(&mut [0; 4]).bytes());
                &rest[length..]
            }
        };
    }
    meant
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_escape_is_taken_back() {
        for (written, meant) in [
            ("a%41%C3%a9%", "aAé%"),
            ("%zz %4", "%zz %4"),
            ("%u0041", "A"),
            (r#"\u0041\u00e9\/\"\\\n"#, "Aé/\"\\\n"),
            (r"\ud83d\ude97\ud83d!\uzz", "🚗\u{fffd}!uzz"),
            (r"\x41\u{41}\u{1F697}\s\é", "AA🚗sé"),
            ("&#65;&#x41;&amp;&lt;&am;&#;", "AA&<&am;&#;"),
            ("a & b, 5 % c", "a & b, 5 % c"),
        ] {
            let got = taken_back(written.as_bytes(), b"%\\&");
            assert_eq!(String::from_utf8_lossy(&got), meant, "{written}");
            let (mut escapes, mut units) = (Escapes::default(), Vec::new());
            for (start, byte) in written.bytes().enumerate() {
                let end = start + 1;
                escapes.push(Unit { byte, start, end }, |unit| units.push(unit.byte));
            }
            assert!(got.starts_with(&units), "{written}");
            assert_eq!(got.len(), units.len() + escapes.pending.len(), "{written}");
        }
    }

    #[test]
    fn places_are_those_of_the_whole_escape() {
        let (mut escapes, mut units) = (Escapes::default(), Vec::new());
        for (start, byte) in br"x\u00e9y".iter().copied().enumerate() {
            let end = start + 1;
            escapes.push(Unit { byte, start, end }, |unit| units.push(unit));
        }
        let places: Vec<_> = units.iter().map(|u| (u.start, u.end)).collect();
        assert_eq!(places, [(0, 1), (1, 7), (1, 7), (7, 8)]);
    }

    #[test]
    fn what_is_no_escape_is_not_held_for_long() {
        for text in [
            "%%%%%%%%%%%%",
            "&&&&&#&#1234567890",
            "\\u{00000000000000",
            "\\ud83d\\ud83d",
        ] {
            let mut escapes = Escapes::default();
            for (start, byte) in text.repeat(20).bytes().enumerate() {
                let end = start + 1;
                escapes.push(Unit { byte, start, end }, |_| ());
                assert!(escapes.pending.len() <= 12, "{text}");
            }
        }
    }
}

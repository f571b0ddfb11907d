//! The lenient reader: recursive descent without backtracking.

use std::collections::BTreeSet;

use serde_json::{Map, Number, Value};

use super::{End, MOST_DEPTH, Repair, bare_key, closing, is_blank, is_quote, window};

/// Bytes looked at for the end of a key.
const KEY_LOOKAHEAD: usize = 200;

/// Reads one piece; everything it consumes is behind it for good.
pub(super) struct Reader<'a> {
    pub(super) text: &'a str,
    pub(super) at: usize,
    pub(super) repairs: BTreeSet<Repair>,
    /// The brackets that are open, by what closes them.
    open: Vec<char>,
    end: End,
}

impl<'a> Reader<'a> {
    /// A reader that stands at a bracket.
    pub(super) fn new(text: &'a str, at: usize) -> Self {
        Self {
            text,
            at,
            repairs: BTreeSet::new(),
            open: Vec::new(),
            end: End::Whole,
        }
    }

    pub(super) fn at(&self) -> usize {
        self.at
    }

    /// What was put right, and how the piece ends.
    pub(super) fn finish(self) -> (BTreeSet<Repair>, End) {
        (self.repairs, self.end)
    }

    /// The object or list at the present place.
    pub(super) fn outermost(&mut self) -> Value {
        match self.peek() {
            Some('{') => self.object(),
            _ => self.list(),
        }
    }

    pub(super) fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    pub(super) fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    pub(super) fn note(&mut self, repair: Repair) {
        self.repairs.insert(repair);
    }

    /// The text is at its end inside the piece.
    pub(super) fn cut(&mut self) {
        if self.end == End::Whole {
            self.end = End::CutOff;
        }
    }

    fn ended(&self) -> bool {
        self.end != End::Whole
    }

    fn broken(&mut self) {
        if self.end == End::Whole {
            self.end = End::Broken;
        }
    }

    /// White space and comments.
    fn skip(&mut self) {
        loop {
            let blank = self.rest().chars().take_while(|c| is_blank(*c));
            self.at += blank.map(char::len_utf8).sum::<usize>();
            let rest = self.rest();
            let past = if rest.starts_with("//") || rest.starts_with('#') {
                rest.find('\n')
            } else if rest.starts_with("/*") {
                rest.find("*/").map(|p| p + 2)
            } else {
                return;
            };
            self.note(Repair::Comments);
            self.at += past.unwrap_or(rest.len());
        }
    }

    fn object(&mut self) -> Value {
        let mut map = Map::new();
        self.at += 1;
        let mut doubled = 0;
        self.skip();
        while self.peek() == Some('{') {
            self.at += 1;
            doubled += 1;
            self.skip();
        }
        if doubled > 0 {
            self.note(Repair::DoubledBraces);
        }
        self.open.push('}');
        let mut comma = true;
        loop {
            self.skip();
            match self.peek() {
                None => self.cut(),
                Some('}') => {
                    if comma && !map.is_empty() {
                        self.note(Repair::ExtraCommas);
                    }
                    self.at += 1;
                    while doubled > 0 && self.peek() == Some('}') {
                        self.at += 1;
                        doubled -= 1;
                    }
                    break;
                }
                Some(',' | ';') => {
                    self.comma(&mut comma);
                    continue;
                }
                Some(c @ (']' | ')')) => {
                    if self.closes_outer(c) {
                        break;
                    }
                    continue;
                }
                Some(_) => {
                    self.entry_begins(&mut comma);
                    self.entry(&mut map);
                }
            }
            if self.ended() {
                break;
            }
        }
        self.open.pop();
        Value::Object(map)
    }

    /// A key, a colon and a value.
    fn entry(&mut self, map: &mut Map<String, Value>) {
        let Some(key) = self.key() else {
            return if self.rest().is_empty() {
                self.cut();
            } else {
                self.broken();
            };
        };
        self.skip();
        if self.peek() != Some(':') {
            return if self.rest().is_empty() {
                self.cut();
            } else {
                self.broken();
            };
        }
        self.at += 1;
        let Some(value) = self.value() else {
            return;
        };
        if map.get(&key).is_some_and(|before| *before != value) {
            self.note(Repair::DoubledKeys);
        }
        map.insert(key, value);
    }

    fn key(&mut self) -> Option<String> {
        let first = self.peek()?;
        if is_quote(first) {
            let inner = &self.rest()[first.len_utf8()..];
            let near = window(inner, KEY_LOOKAHEAD);
            let line = near.split('\n').next().unwrap_or(near);
            let seen = line.len() < near.len() || near.len() == inner.len();
            if seen
                && !line.contains(closing(first))
                && let Some((key, length)) = bare_key(inner)
            {
                self.note(Repair::MissingQuotes);
                self.at += first.len_utf8() + length;
                return Some(key.to_string());
            }
            return self.string(first);
        }
        let (key, length) = bare_key(self.rest())?;
        self.note(if key.len() < self.rest()[..length].trim_end().len() {
            Repair::MissingQuotes
        } else {
            Repair::BareKeys
        });
        self.at += length;
        Some(key.to_string())
    }

    fn list(&mut self) -> Value {
        let close = if self.peek() == Some('(') {
            self.note(Repair::Brackets);
            ')'
        } else {
            ']'
        };
        self.at += 1;
        self.open.push(close);
        let mut items = Vec::new();
        let mut comma = true;
        loop {
            self.skip();
            match self.peek() {
                None => self.cut(),
                Some(c) if c == close => {
                    if comma && !items.is_empty() {
                        self.note(Repair::ExtraCommas);
                    }
                    self.at += 1;
                    break;
                }
                Some(',' | ';') => {
                    self.comma(&mut comma);
                    continue;
                }
                Some(c @ ('}' | ']' | ')')) => {
                    if self.closes_outer(c) {
                        break;
                    }
                    continue;
                }
                Some(_) => {
                    self.entry_begins(&mut comma);
                    items.extend(self.value());
                }
            }
            if self.ended() {
                break;
            }
        }
        self.open.pop();
        Value::Array(items)
    }

    /// A comma between entries, of which there may be too many.
    fn comma(&mut self, comma: &mut bool) {
        if std::mem::replace(comma, true) {
            self.note(Repair::ExtraCommas);
        }
        self.at += 1;
    }

    /// An entry begins, behind a comma if all is well.
    fn entry_begins(&mut self, comma: &mut bool) {
        if !std::mem::replace(comma, false) {
            self.note(Repair::MissingCommas);
        }
    }

    /// A bracket that closes something else: what is open ends here if that is farther out; else it is passed over.
    fn closes_outer(&mut self, bracket: char) -> bool {
        self.note(Repair::Brackets);
        let outer = self.open.contains(&bracket);
        if !outer {
            self.at += 1;
        }
        outer
    }

    /// Any value; nothing if the text ends in it, or it is too deep.
    fn value(&mut self) -> Option<Value> {
        self.skip();
        match self.peek() {
            None => {
                self.cut();
                None
            }
            Some('{' | '[' | '(') if self.open.len() >= MOST_DEPTH => {
                self.broken();
                None
            }
            Some('{') => Some(self.object()),
            Some('[' | '(') => Some(self.list()),
            Some('}' | ']' | ')' | ',') => {
                self.note(Repair::MissingValues);
                Some(Value::Null)
            }
            Some(quote) if is_quote(quote) => self.string(quote).map(Value::String),
            Some(_) => self.word(),
        }
    }

    /// What has no quotation marks: a number, a literal, or words.
    fn word(&mut self) -> Option<Value> {
        let rest = self.rest();
        let mut end = rest.len();
        let mut before = ' ';
        for (place, c) in rest.char_indices() {
            let comment = c == '#'
                || c == '/'
                    && before == ' '
                    && ["//", "/*"]
                        .iter()
                        .any(|begin| rest[place..].starts_with(begin));
            if ",;{}[]()\n\"".contains(c) || comment {
                end = place;
                break;
            }
            before = c;
        }
        let word = rest[..end].trim();
        self.at += end;
        if end == 0 {
            // A bracket or a mark that begins no value.
            self.broken();
            return None;
        }
        if self.rest().is_empty() && !matches!(word, "true" | "false" | "null") {
            self.cut();
            return None;
        }
        if let Some('"') = self.peek() {
            // The first of the two is missing.
            self.at += 1;
            self.note(Repair::MissingQuotes);
            return Some(Value::String(word.to_string()));
        }
        Some(self.meaning(word))
    }

    fn meaning(&mut self, word: &str) -> Value {
        if let Ok(number) = serde_json::from_str::<Number>(word) {
            return Value::Number(number);
        }
        let (value, repair) = match word {
            "true" => return Value::Bool(true),
            "false" => return Value::Bool(false),
            "null" => return Value::Null,
            _ => match word.to_ascii_lowercase().as_str() {
                "true" => (Value::Bool(true), Repair::Literals),
                "false" => (Value::Bool(false), Repair::Literals),
                "null" | "none" | "nil" | "undefined" => (Value::Null, Repair::Literals),
                _ => match word.parse::<f64>() {
                    Ok(number) => match Number::from_f64(number) {
                        Some(number) => (Value::Number(number), Repair::Numbers),
                        None => (Value::Null, Repair::NotANumber),
                    },
                    Err(_) => (Value::String(word.to_string()), Repair::BareWords),
                },
            },
        };
        self.note(repair);
        value
    }
}

//! Where elements, numbers and attributes stand in a text that looks like XML.

use std::ops::Range;

/// Where everything stands, in bytes.
#[derive(Default)]
pub struct Markup {
    /// From `<` of an element to `>` of its end.
    pub elements: Vec<Range<usize>>,
    /// Numbers between tags and in attributes.
    pub numbers: Vec<Range<usize>>,
    /// Values of `id`.
    pub ids: Vec<Range<usize>>,
    /// Values of `ref`.
    pub references: Vec<Range<usize>>,
}

impl Markup {
    pub fn of(text: &str) -> Self {
        let mut found = Self::default();
        let (mut at, mut open) = (0, Vec::new());
        while let Some(begin) = text[at..].find('<').map(|i| at + i) {
            let between = at..begin;
            found.number(text, between);
            let Some(end) = text[begin..].find('>').map(|i| begin + i + 1) else {
                break;
            };
            at = end;
            let tag = &text[begin..end];
            match tag.as_bytes()[1] {
                b'?' | b'!' => continue,
                b'/' => {
                    if let Some(start) = open.pop() {
                        found.elements.push(start..end);
                    }
                }
                _ if tag.ends_with("/>") => found.elements.push(begin..end),
                _ => open.push(begin),
            }
            found.attributes(text, begin..end);
        }
        found
    }

    fn number(&mut self, text: &str, place: Range<usize>) {
        let word = text[place.clone()].trim();
        if !word.is_empty() && word.parse::<f64>().is_ok() {
            let start = place.start + text[place].find(word).unwrap_or(0);
            self.numbers.push(start..start + word.len());
        }
    }

    fn attributes(&mut self, text: &str, tag: Range<usize>) {
        let mut at = tag.start;
        while let Some(open) = text[at..tag.end].find("=\"").map(|i| at + i + 2) {
            let Some(close) = text[open..tag.end].find('"').map(|i| open + i) else {
                return;
            };
            let before = &text[tag.start..open - 2];
            let name = before.rsplit(|c: char| c.is_whitespace()).next();
            match name {
                Some("id") => self.ids.push(open..close),
                Some("ref") => self.references.push(open..close),
                _ => {}
            }
            self.number(text, open..close);
            at = close + 1;
        }
    }

    /// The elements of a name.
    pub fn named(&self, text: &str, name: &str) -> Vec<Range<usize>> {
        let is = |range: &&Range<usize>| {
            let rest = text[range.start + 1..].strip_prefix(name);
            rest.is_some_and(|rest| rest.starts_with([' ', '>', '/', '\n']))
        };
        self.elements.iter().filter(is).cloned().collect()
    }
}

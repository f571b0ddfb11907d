//! What stands in a file and is not used, counted while a file is read that is kept for several scenarios.

use std::collections::BTreeMap;

use super::report::Report;
use crate::commonroad::ReadError;
use crate::commonroad::xml::{Element, Xml};

/// Kinds that are told apart.
const MOST_KINDS: usize = 200;

/// Counts by kind, with the line of the first one; 0 where the file has no lines.
#[derive(Debug, Default)]
pub struct Leftovers {
    counts: BTreeMap<String, (usize, usize)>,
    /// The name that is looked up: there are millions of attributes of few kinds.
    name: String,
}

/// Attributes that say nothing of what is described: of XML itself, and who wrote an element when.
const ABOUT: [&str; 8] = [
    "version",
    "visible",
    "changeset",
    "timestamp",
    "user",
    "uid",
    "action",
    "xmlns",
];

impl Leftovers {
    /// Counts one of a kind.
    pub fn add(&mut self, kind: &str, line: impl FnOnce() -> usize) {
        self.add_times(kind, 1, line);
    }

    /// Counts so many of a kind.
    pub fn add_times(&mut self, kind: &str, count: usize, line: impl FnOnce() -> usize) {
        if let Some((_, known)) = self.counts.get_mut(kind) {
            *known += count;
        } else if count > 0 && self.counts.len() < MOST_KINDS {
            self.counts.insert(kind.to_string(), (line(), count));
        }
    }

    /// Counts an attribute of an element.
    pub fn attribute(&mut self, element: &str, attribute: &str, line: impl FnOnce() -> usize) {
        self.part(element, '@', attribute, line);
    }

    /// Counts a field of a message.
    pub fn field(&mut self, message: &str, field: &str) {
        self.part(message, '/', field, || 0);
    }

    fn part(&mut self, whole: &str, between: char, part: &str, line: impl FnOnce() -> usize) {
        self.name.clear();
        if !whole.is_empty() {
            self.name.push_str(whole);
            self.name.push(between);
        }
        self.name.push_str(part);
        match self.counts.get_mut(&self.name) {
            Some((_, known)) => *known += 1,
            None => {
                let name = self.name.clone();
                self.add(&name, line);
            }
        }
    }

    /// Counts the attributes of an element but those that are used.
    pub fn attributes<'a>(&mut self, xml: &Xml<'a>, element: Element<'a>, used: &[&str]) {
        for (name, _) in xml.attributes(element) {
            let is_about = ABOUT.contains(&name) || name.contains(':');
            if !is_about && !used.contains(&name) {
                self.attribute(element.name, name, || xml.line(element));
            }
        }
    }

    /// Counts an element within another one, and passes over it.
    pub fn element<'a>(
        &mut self,
        xml: &mut Xml<'a>,
        within: &str,
        element: Element<'a>,
    ) -> Result<(), ReadError> {
        let name: String = element.name.chars().take(40).collect();
        self.add(&format!("{within}/{name}"), || xml.line(element));
        xml.skip()
    }

    /// Counts all elements within the innermost open one, and passes over its rest.
    pub fn rest<'a>(&mut self, xml: &mut Xml<'a>, within: &str) -> Result<(), ReadError> {
        while let Some(element) = xml.next()? {
            self.element(xml, within, element)?;
        }
        Ok(())
    }

    /// Tells them all in a scenario's report.
    pub fn tell(&self, report: &Report) {
        for (kind, (line, count)) in &self.counts {
            report.unused_times(kind.as_str(), *count, *line);
        }
    }
}

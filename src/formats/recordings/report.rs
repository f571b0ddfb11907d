//! What is said about a recording while it is read, where in it, and what stands in it unused.

use std::collections::BTreeMap;

use nearmiss_base::geometry::{Point, ShapeError};
use nearmiss_scene::scenario::{Diagnostic, Severity};

use crate::commonroad::ReadError;
use crate::commonroad::builder::{self, Diagnostics, SourceLocation};
use crate::commonroad::xml::{Element, Xml};

/// The file that is read, and what was noted about it.
pub struct Report {
    file: String,
    diagnostics: Diagnostics,
}

/// A place in a recording: its row, where it has rows, and the track, lane or field.
pub struct At<'a> {
    report: &'a Report,
    line: usize,
    element: String,
}

impl Report {
    pub fn about(file: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            diagnostics: Diagnostics::default(),
        }
    }

    /// A named part of the file; an empty name means the whole.
    pub fn at(&self, element: impl Into<String>) -> At<'_> {
        self.row(0, element)
    }

    /// The same in a row, from 1.
    pub fn row(&self, line: usize, element: impl Into<String>) -> At<'_> {
        At {
            report: self,
            line,
            element: element.into(),
        }
    }

    /// An error about the whole file.
    pub fn fail(&self, message: impl Into<String>) -> ReadError {
        self.at("").fail(message)
    }

    /// Notes something about the whole file.
    pub fn note(&self, message: impl Into<String>) {
        self.at("").note(Severity::Note, message);
    }

    /// Notes what was assumed of so many things; nothing where there are none.
    pub fn note_count(&self, count: usize, message: impl FnOnce(usize) -> String) {
        if count > 0 {
            self.note(message(count));
        }
    }

    /// Counts what stands in the file and is not used, by its kind, such as `column dhw` or `edge@type`; `line` is 0
    /// where the file has none.
    pub fn unused(&self, kind: impl Into<String>, line: usize) {
        self.unused_times(kind, 1, line);
    }

    /// The same of so many.
    pub fn unused_times(&self, kind: impl Into<String>, count: usize, line: usize) {
        self.diagnostics.unused_times(kind, count, || line);
    }

    pub fn file(&self) -> &str {
        &self.file
    }

    pub fn push(&self, severity: Severity, element: String, message: String) {
        self.diagnostics.push(severity, || (0, element), message);
    }

    pub fn into_diagnostics(self) -> Vec<Diagnostic> {
        self.diagnostics.into_list()
    }
}

impl At<'_> {
    /// A number that a scenario can have.
    pub fn number(&self, value: f64) -> Result<f64, ReadError> {
        builder::finite(self, value, || value.to_string())
    }

    /// A place on a map, metres.
    pub fn point(&self, x: f64, y: f64) -> Result<Point, ReadError> {
        let coordinate = |value| builder::coordinate(self, self.number(value)?);
        Ok(Point::new(coordinate(x)?, coordinate(y)?))
    }

    /// A length or width, metres.
    pub fn size(&self, value: f64) -> Result<f64, ReadError> {
        builder::size(self, self.number(value)?)
    }
}

impl SourceLocation for At<'_> {
    fn fail(&self, message: impl Into<String>) -> ReadError {
        ReadError {
            file: self.report.file.clone(),
            line: self.line,
            column: 0,
            element: self.element.clone(),
            message: message.into(),
        }
    }

    fn note(&self, severity: Severity, message: impl Into<String>) {
        let place = || (self.line, self.element.clone());
        self.report.diagnostics.push(severity, place, message);
    }

    fn warn_tiny(&self, _: f64) {
        // Velocities at standstill are such numbers, written by filters.
    }

    fn leave_out(&self, error: &ShapeError) -> Result<(), ReadError> {
        self.warn(format!("{error}; it was left out"));
        Ok(())
    }
}

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
    pub fn report_to(&self, report: &Report) {
        for (kind, (line, count)) in &self.counts {
            report.unused_times(kind.as_str(), *count, *line);
        }
    }
}

//! A pull parser over quick-xml tokens with names, line numbers, limits and a single error type.

mod deferred_checks;

use std::borrow::Cow;
use std::cell::Cell;

use nearmiss_base::geometry::ShapeError;
use nearmiss_scene::scenario::plausibility::MOST_PARTS;
use nearmiss_scene::scenario::{Diagnostic, Severity};
use quick_xml::Reader;
use quick_xml::errors::{Error, SyntaxError};
use quick_xml::events::Event;
use quick_xml::events::attributes::Attributes;

use super::ReadError;
use super::builder::{self, Diagnostics, TimeScale};
use crate::commonroad::encoding::BYTE_ORDER_MARK;

pub(crate) use super::encoding::{Decoded, decoded};
pub(super) use deferred_checks::{KnownAttributes, SourceLocation};

/// An opened element.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Element<'a> {
    pub name: &'a str,
    attributes: &'a str,
    /// Byte offset of its `<`.
    pub at: usize,
}

impl<'a> Element<'a> {
    /// Its attributes, as far as they can be read, unescaped.
    fn values(self) -> impl Iterator<Item = (&'a str, Cow<'a, str>)> + use<'a> {
        let found = Attributes::new(self.attributes, 0)
            .with_checks(false)
            .clone();
        found.flatten().map(|a| {
            let value = a
                .normalized_value(quick_xml::XmlVersion::Implicit1_0)
                .unwrap_or_else(|_| a.value.clone());
            (a.key.0, value)
        })
    }
}

/// The parser; every element that is opened must be read to its end by one of its functions.
pub(crate) struct Xml<'a> {
    reader: Reader<&'a [u8]>,
    text: &'a str,
    file: &'a str,
    path: Vec<Element<'a>>,
    diagnostics: Diagnostics,
    /// A byte offset and its line, from which the next one is counted on.
    counted: Cell<(usize, usize)>,
    /// How times are written.
    pub(super) times: TimeScale,
    /// The attributes that count as used, where they are counted.
    pub(super) known_attributes: Option<KnownAttributes>,
    later: deferred_checks::DeferredChecks<'a>,
}

impl<'a> Xml<'a> {
    /// A parser of a decoded file; `file` names it in errors.
    pub fn new(decoded: &'a Decoded<'_>, file: &'a str) -> Self {
        Self {
            diagnostics: decoded.doubts.clone().into(),
            ..Self::of_text(&decoded.text, file)
        }
    }

    /// A parser of a text without byte order marks.
    pub(super) fn of_text(text: &'a str, file: &'a str) -> Self {
        let mut reader = Reader::from_str(text);
        reader.config_mut().expand_empty_elements = true;
        Self {
            reader,
            text,
            file,
            path: Vec::new(),
            diagnostics: Diagnostics::default(),
            counted: Cell::new((0, 1)),
            times: TimeScale::default(),
            known_attributes: None,
            later: deferred_checks::DeferredChecks::default(),
        }
    }

    /// The next child of the innermost open element, or nothing at its end.
    pub fn next(&mut self) -> Result<Option<Element<'a>>, ReadError> {
        loop {
            let at = self.reader.buffer_position() as usize;
            match self.reader.read_event() {
                Ok(Event::Start(start)) => {
                    let name_end = at + 1 + start.name().as_ref().len();
                    let end = name_end + start.attributes_raw().len();
                    let element = Element {
                        name: &self.text[at + 1..name_end],
                        attributes: &self.text[name_end..end],
                        at,
                    };
                    self.check_bounds(element)?;
                    self.count_attributes(element);
                    self.path.push(element);
                    return Ok(Some(element));
                }
                Ok(Event::End(_)) => {
                    self.path.pop();
                    return Ok(None);
                }
                Ok(Event::Eof) => return self.end_of_file(),
                Ok(_) => {}
                Err(error) => return Err(self.malformed(&error)),
            }
        }
    }

    fn end_of_file(&self) -> Result<Option<Element<'a>>, ReadError> {
        match self.path.last().copied() {
            None => Ok(None),
            Some(open) => {
                let line = self.line_of(open.at);
                Err(self.fail(
                    self.text.len(),
                    format!(
                        "the file ends here, but <{}> of line {line} is still open; the file is truncated",
                        open.name
                    ),
                ))
            }
        }
    }

    fn malformed(&self, error: &quick_xml::Error) -> ReadError {
        let at = self.reader.error_position() as usize;
        self.fail(at, error_text(error))
    }

    /// The text of the innermost open element, trimmed, and its end; children in it are passed over.
    pub fn text(&mut self) -> Result<Cow<'a, str>, ReadError> {
        let mut whole: Cow<'a, str> = Cow::Borrowed("");
        loop {
            let piece: Cow<'a, str> = match self.reader.read_event() {
                Ok(Event::Text(text)) => text.into_inner(),
                Ok(Event::CData(text)) => text.into_inner(),
                Ok(Event::GeneralRef(reference)) => {
                    let resolved = reference.resolve_char_ref().ok().flatten();
                    let predefined = || match &*reference.borrow().into_inner() {
                        "amp" => Some('&'),
                        "lt" => Some('<'),
                        "gt" => Some('>'),
                        "quot" => Some('"'),
                        "apos" => Some('\''),
                        _ => None,
                    };
                    match resolved.or_else(predefined) {
                        Some(c) => Cow::Owned(c.to_string()),
                        None => {
                            let at = self.reader.buffer_position() as usize;
                            return Err(self.fail(
                                at,
                                "an entity not defined by XML; entities are not expanded".into(),
                            ));
                        }
                    }
                }
                Ok(Event::Start(start)) => {
                    let name = start.name();
                    self.count_unused(name.as_ref(), self.reader.buffer_position() as usize);
                    match self.reader.read_to_end(name) {
                        Ok(_) => continue,
                        Err(error) => return Err(self.malformed(&error)),
                    }
                }
                Ok(Event::End(_)) => {
                    self.path.pop();
                    let trimmed = match whole {
                        Cow::Borrowed(text) => Cow::Borrowed(text.trim()),
                        Cow::Owned(text) => Cow::Owned(text.trim().to_string()),
                    };
                    return Ok(trimmed);
                }
                Ok(Event::Eof) => return self.end_of_file().map(|_| Cow::Borrowed("")),
                Ok(_) => continue,
                Err(error) => return Err(self.malformed(&error)),
            };
            if whole.is_empty() {
                whole = piece;
            } else {
                whole.to_mut().push_str(&piece);
            }
        }
    }

    /// Passes over the rest of the innermost open element.
    pub fn skip(&mut self) -> Result<(), ReadError> {
        let depth = self.path.len();
        while self.path.len() >= depth {
            self.next()?;
        }
        Ok(())
    }

    /// The value of an attribute, unescaped.
    pub fn attribute(&self, element: Element<'a>, name: &str) -> Option<Cow<'a, str>> {
        self.attributes(element)
            .find(|(key, _)| *key == name)
            .map(|(_, value)| value)
    }

    /// All attributes that can be read.
    pub fn attributes(
        &self,
        element: Element<'a>,
    ) -> impl Iterator<Item = (&'a str, Cow<'a, str>)> + use<'a> {
        element.values()
    }

    /// An error at a byte offset, inside the open elements.
    pub fn fail(&self, at: usize, message: String) -> ReadError {
        let before = &self.text[..self.text.floor_char_boundary(at.min(self.text.len()))];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        ReadError {
            file: self.file.to_string(),
            line: self.line_of(at),
            column: before[line_start..].chars().count() + 1,
            element: self.element_path(None),
            message,
        }
    }

    /// An error about an element that was just read to its end.
    pub fn fail_in(&self, element: Element<'a>, message: String) -> ReadError {
        let path = self.element_path(Some(element));
        let mut error = self.fail(element.at, message);
        error.element = path;
        error
    }

    /// The place of an element, for what the builder says about it.
    pub fn at(&self, element: Element<'a>) -> ElementLocation<'_, 'a> {
        ElementLocation { xml: self, element }
    }

    /// Notes something assumed or skipped at `element`.
    pub fn note(&self, severity: Severity, element: Element<'a>, message: String) {
        let place = || (self.line_of(element.at), self.element_path(Some(element)));
        self.diagnostics.push(severity, place, message);
    }

    /// The path of the elements within which the text ends or stops being XML.
    pub fn path_at_end(mut self) -> String {
        loop {
            match self.next() {
                Ok(None) if self.path.is_empty() => return String::new(),
                Ok(_) => {}
                Err(error) => return error.element,
            }
        }
    }

    /// The diagnostics, in the order of the file.
    pub fn into_diagnostics(self) -> Vec<Diagnostic> {
        self.diagnostics.into_list()
    }

    /// Path of the open elements, and `last` if it is closed already.
    fn element_path(&self, last: Option<Element<'a>>) -> String {
        let closed = last.filter(|l| self.path.last().is_none_or(|p| p.at != l.at));
        path(&self.path, closed)
    }

    /// The line at which an element begins.
    pub fn line(&self, element: Element<'a>) -> usize {
        self.line_of(element.at)
    }

    /// The line of a byte offset, counted on from the last one asked for.
    pub fn line_of(&self, at: usize) -> usize {
        let at = at.min(self.text.len());
        let (from, line) = match self.counted.get() {
            (from, line) if from <= at => (from, line),
            _ => (0, 1),
        };
        let between = &self.text.as_bytes()[from..at];
        let line = line + between.iter().filter(|&&b| b == b'\n').count();
        self.counted.set((at, line));
        line
    }
}

/// An element in the file that is being read.
pub(crate) struct ElementLocation<'x, 'a> {
    xml: &'x Xml<'a>,
    element: Element<'a>,
}

impl builder::SourceLocation for ElementLocation<'_, '_> {
    fn fail(&self, message: impl Into<String>) -> ReadError {
        self.xml.fail_in(self.element, message.into())
    }

    fn note(&self, severity: Severity, message: impl Into<String>) {
        self.xml.note(severity, self.element, message.into());
    }

    fn warn_tiny(&self, value: f64) {
        self.warn(format!("`{value:e}` is implausibly close to 0; used as is"));
    }

    fn leave_out(&self, error: &ShapeError) -> Result<(), ReadError> {
        self.warn(format!("{error}; it was left out"));
        Ok(())
    }
}

/// The path of elements from the root, and one more inside them.
fn path(open: &[Element<'_>], last: Option<Element<'_>>) -> String {
    let name = |element: Element<'_>| {
        let id = element.values().find(|(key, _)| *key == "id");
        match id.filter(|(_, id)| id.len() <= 20) {
            Some((_, id)) => format!("{}#{id}", element.name),
            None => short(element.name),
        }
    };
    let mut names: Vec<String> = open.iter().copied().chain(last).map(name).collect();
    if names.len() > 6 {
        names.splice(1..names.len() - 4, ["…".to_string()]);
    }
    names.join("/")
}

/// Enough of a text to recognise it.
pub(super) fn short(text: &str) -> String {
    let mut cut: String = text.chars().take(40).collect();
    if cut.len() < text.len() {
        cut.push('…');
    }
    cut
}

/// Elements inside each other, deeper than any file needs.
const MAX_DEPTH: usize = 100;

/// No element has longer attributes, bytes.
const LONGEST_ATTRIBUTES: usize = 64 << 10;

impl<'a> Xml<'a> {
    /// # Errors
    /// An element is too deep inside others, or its attributes are too long.
    fn check_bounds(&self, element: Element<'a>) -> Result<(), ReadError> {
        let long = element.attributes.len();
        if self.path.len() >= MAX_DEPTH {
            let message = format!("elements are nested more than {MAX_DEPTH} deep");
            return Err(self.fail(element.at, message));
        }
        if long > LONGEST_ATTRIBUTES {
            let (long, most) = (long >> 10, LONGEST_ATTRIBUTES >> 10);
            let message = format!(
                "the attributes of <{}> take {long} KiB; at most {most} KiB are read",
                short(element.name)
            );
            return Err(self.fail(element.at, message));
        }
        Ok(())
    }

    /// # Errors
    /// More than a million elements of one kind.
    pub fn check_count(
        &self,
        element: Element<'a>,
        count: usize,
        what: &str,
    ) -> Result<(), ReadError> {
        if count <= MOST_PARTS {
            return Ok(());
        }
        Err(self.fail(
            element.at,
            format!("more than {MOST_PARTS} {what} in one place"),
        ))
    }
}

/// The syntax error, and a hint if the file is truncated.
fn error_text(error: &Error) -> String {
    let advice = match error {
        Error::Syntax(SyntaxError::UnclosedTag) => "; the file is truncated",
        Error::Syntax(SyntaxError::InvalidBangMarkup) => "",
        // All others of this kind are noticed at the end of the file, too.
        Error::Syntax(_) => "; the file is truncated, or this is not closed",
        _ => "",
    };
    format!("not well-formed XML: {error}{advice}")
}

impl<'a> Xml<'a> {
    /// The value of an attribute that must be a whole number.
    pub fn id_attribute(&self, element: Element<'a>, name: &str) -> Result<i64, ReadError> {
        let Some(value) = self.attribute(element, name) else {
            return Err(self.fail(
                element.at,
                format!("<{}> has no attribute `{name}`", element.name),
            ));
        };
        parse_id(&value).ok_or_else(|| {
            self.fail(
                element.at,
                format!("{name}=\"{}\" is not a whole number", short(&value)),
            )
        })
    }

    /// The text of the innermost open element as a finite number.
    pub fn number(&mut self, element: Element<'a>) -> Result<f64, ReadError> {
        let text = self.text()?;
        let value = self.parsed(element, &text)?;
        builder::finite(&self.at(element), value, || short(&text))
    }

    /// The text of the innermost open element as a number, also one that is not finite.
    pub fn any_number(&mut self, element: Element<'a>) -> Result<f64, ReadError> {
        let text = self.text()?;
        self.parsed(element, &text)
    }

    /// The text of the innermost open element as a time or a duration, steps.
    pub fn steps(&mut self, element: Element<'a>) -> Result<i64, ReadError> {
        let value = self.number(element)?;
        let step = self.times.step(value);
        step.map_err(|message| self.fail_in(element, message))
    }

    fn parsed(&self, element: Element<'a>, text: &str) -> Result<f64, ReadError> {
        if let Ok(value) = text.parse::<f64>() {
            return Ok(value);
        }
        let message = if text.is_empty() {
            "empty; expected a number".into()
        } else if text.contains(BYTE_ORDER_MARK) {
            format!(
                "`{}` is not a number: remove the byte order mark in it",
                short(&text.replace(BYTE_ORDER_MARK, "U+FEFF "))
            )
        } else {
            format!("`{}` is not a number", short(text))
        };
        Err(self.fail_in(element, message))
    }

    /// The text of the innermost open element as a coordinate, metres.
    pub fn coordinate(&mut self, element: Element<'a>) -> Result<f64, ReadError> {
        let value = self.number(element)?;
        builder::coordinate(&self.at(element), value)
    }

    /// The text of the innermost open element as a length, width or radius, metres.
    pub fn size(&mut self, element: Element<'a>) -> Result<f64, ReadError> {
        let value = self.number(element)?;
        builder::size(&self.at(element), value)
    }

    /// The text of the innermost open element as a whole number; `3.0` is one.
    pub fn integer(&mut self, element: Element<'a>) -> Result<i64, ReadError> {
        let value = self.number(element)?;
        if value.fract() == 0.0 && value.abs() < 1e15 {
            Ok(value as i64)
        } else {
            Err(self.fail_in(element, format!("`{value}` is not a whole number")))
        }
    }

    /// The text of the innermost open element as a finite number; nothing, with a diagnostic, where it is none.
    pub fn optional_number(&mut self, element: Element<'a>) -> Result<Option<f64>, ReadError> {
        let text = self.text()?;
        let value = text.parse::<f64>().ok().filter(|v| v.is_finite());
        if value.is_none() {
            let message = format!("`{}` is not a number and was left out", short(&text));
            self.note(Severity::Warning, element, message);
        }
        Ok(value)
    }
}

/// A whole number, also where it is written as `3.0`.
fn parse_id(text: &str) -> Option<i64> {
    let text = text.trim();
    text.parse().ok().or_else(|| {
        let value: f64 = text.parse().ok()?;
        (value.fract() == 0.0 && value.abs() < 1e15).then_some(value as i64)
    })
}

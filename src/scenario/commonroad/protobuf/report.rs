//! What is said while a message is read: errors and diagnostics, with the file and the path of fields.

use std::cell::RefCell;
use std::collections::HashSet;
use std::fmt;

use prost::Message;

use super::wire::{Field, NoField, Value};
use crate::scenario::commonroad::ReadError;
use crate::scenario::commonroad::xml::MOST_DIAGNOSTICS;
use crate::scenario::{Diagnostic, Severity};

/// Where a field is: the names of the fields that lead to it. Written out only where something is said about it.
#[derive(Debug, Clone, Copy)]
pub(super) struct At<'a> {
    up: Option<&'a At<'a>>,
    name: &'a str,
    index: Option<usize>,
}

impl<'a> At<'a> {
    /// The message itself; `name` may be empty.
    pub fn root(name: &'a str) -> Self {
        Self {
            up: None,
            name,
            index: None,
        }
    }

    pub fn field(&'a self, name: &'a str) -> Self {
        Self {
            up: Some(self),
            name,
            index: None,
        }
    }

    /// One of a repeated field, from 0.
    pub fn nth(&'a self, name: &'a str, index: usize) -> Self {
        Self {
            index: Some(index),
            ..self.field(name)
        }
    }
}

impl fmt::Display for At<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(up) = self.up.filter(|up| !up.name.is_empty()) {
            write!(f, "{up}/")?;
        }
        f.write_str(self.name)?;
        self.index.map_or(Ok(()), |i| write!(f, "[{i}]"))
    }
}

/// No element of a scenario is larger, bytes; a decoded message can be fifty times as large as its bytes.
const LARGEST_ELEMENT: usize = 8 << 20;

/// So many fields lead to a fault that is named.
const DEEPEST_PATH: usize = 6;

/// The file that is read, and what was noted about it.
pub(super) struct Report {
    pub file: String,
    diagnostics: Vec<Diagnostic>,
    suppressed: usize,
    ids: HashSet<i64>,
    /// The first number that is nearer to 0 than any that is measured, and how many there are.
    tiny: RefCell<Option<(String, f64, usize)>>,
}

impl Report {
    pub fn about(file: &str) -> Self {
        Self {
            file: file.to_string(),
            diagnostics: Vec::new(),
            suppressed: 0,
            ids: HashSet::new(),
            tiny: RefCell::new(None),
        }
    }

    pub fn fail(&self, at: &At<'_>, message: impl Into<String>) -> ReadError {
        ReadError {
            file: self.file.clone(),
            line: 0,
            column: 0,
            element: at.to_string(),
            message: message.into(),
        }
    }

    /// Notes something assumed or left out.
    pub fn note(&mut self, severity: Severity, at: &At<'_>, message: impl Into<String>) {
        self.note_field(severity, at.to_string(), message);
    }

    /// Notes something about the field with this path.
    pub fn note_field(&mut self, severity: Severity, field: String, message: impl Into<String>) {
        if self.diagnostics.len() >= MOST_DIAGNOSTICS {
            self.suppressed += 1;
            return;
        }
        self.diagnostics.push(Diagnostic {
            severity,
            line: 0,
            element: field,
            message: message.into(),
        });
    }

    pub fn warn(&mut self, at: &At<'_>, message: impl Into<String>) {
        self.note(Severity::Warning, at, message);
    }

    /// Remembers a number that is nearer to 0 than any that is measured.
    pub fn saw_tiny(&self, at: &At<'_>, value: f64) {
        match &mut *self.tiny.borrow_mut() {
            Some((.., count)) => *count += 1,
            first => *first = Some((at.to_string(), value, 1)),
        }
    }

    /// A field that the schema requires.
    pub fn need<T>(&self, at: &At<'_>, name: &str, value: Option<T>) -> Result<T, ReadError> {
        value.ok_or_else(|| self.fail(at, format!("the required field `{name}` is missing")))
    }

    /// Notes an id that another element has already.
    fn unique(&mut self, at: &At<'_>, id: i64) {
        if !self.ids.insert(id) {
            let message =
                format!("id {id} is used twice; the first one is meant where it is referred to");
            self.warn(at, message);
        }
    }

    /// Notes a field of the file's own message that no schema knows.
    pub fn unknown(&mut self, at: &At<'_>, field: &Field<'_>) {
        let message = format!(
            "field {} at byte {} is not known here and was left out",
            field.number, field.offset
        );
        self.note(Severity::Note, at, message);
    }

    /// A field of the file's own message, whole.
    pub fn whole<'a>(
        &self,
        at: &At<'_>,
        field: Result<Field<'a>, NoField>,
    ) -> Result<Field<'a>, ReadError> {
        match field {
            Ok(field) if field.missing == 0 => Ok(field),
            Ok(field) => Err(self.fail(
                at,
                format!(
                    "field {} at byte {} goes on for {} bytes beyond the end; the file is cut off",
                    field.number, field.offset, field.missing
                ),
            )),
            Err(NoField { offset, cut: true }) => Err(self.fail(
                at,
                format!("the file ends within the field at byte {offset}; it is cut off"),
            )),
            Err(NoField { offset, .. }) => Err(self.fail(
                at,
                format!("byte {offset} does not begin a protobuf field; the file is damaged"),
            )),
        }
    }

    /// The message in a field of the file's own message.
    pub fn decode<M: Message + Default>(
        &mut self,
        at: &At<'_>,
        field: &Field<'_>,
    ) -> Result<M, ReadError> {
        let Value::Bytes(bytes) = field.value else {
            let message = format!(
                "field {} at byte {} is no message",
                field.number, field.offset
            );
            return Err(self.fail(at, message));
        };
        if bytes.len() > LARGEST_ELEMENT {
            let message = format!(
                "{} MiB at byte {} are more than an element can have, at most {} MiB are read",
                bytes.len().div_ceil(1 << 20),
                field.offset,
                LARGEST_ELEMENT >> 20
            );
            return Err(self.fail(at, message));
        }
        let message = M::decode(bytes).map_err(|error| {
            let (path, cause) = inside(&error.to_string());
            let mut error = self.fail(at, String::new());
            error.element.push_str(&path);
            error.message = format!("damaged protobuf after byte {}: {cause}", field.offset);
            error
        })?;
        let known = message.encoded_len();
        if known < bytes.len() {
            let message = format!(
                "{} of its {} bytes are fields that are not known here, or there twice; they were left out",
                bytes.len() - known,
                bytes.len()
            );
            self.note(Severity::Note, at, message);
        }
        Ok(message)
    }

    /// One more element of a list, read by `read` from the message in a field; its id must be its own.
    pub fn element<M: Message + Default, T>(
        &mut self,
        at: &At<'_>,
        field: &Field<'_>,
        into: &mut Vec<T>,
        read: impl FnOnce(&mut Self, &At<'_>, &M) -> Result<T, ReadError>,
        id: impl FnOnce(&T) -> i64,
    ) -> Result<(), ReadError> {
        let at = At {
            index: Some(into.len()),
            ..*at
        };
        let message: M = self.decode(&at, field)?;
        let element = read(self, &at, &message)?;
        self.unique(&at, id(&element));
        into.push(element);
        Ok(())
    }

    /// The part of which there is one, read by `read` from the message in a field; a second one replaces it.
    pub fn part<M: Message + Default, T>(
        &mut self,
        at: &At<'_>,
        field: &Field<'_>,
        into: &mut Option<T>,
        read: impl FnOnce(&mut Self, &At<'_>, &M) -> Result<T, ReadError>,
    ) -> Result<(), ReadError> {
        let message: M = self.decode(at, field)?;
        let part = read(self, at, &message)?;
        if into.replace(part).is_some() {
            self.warn(at, "it is there more than once; the last one counts");
        }
        Ok(())
    }

    pub fn into_diagnostics(mut self) -> Vec<Diagnostic> {
        if let Some((field, value, count)) = self.tiny.take() {
            let more = match count {
                1 => String::new(),
                count => format!(" (and {} more)", count - 1),
            };
            let message = format!(
                "`{value:e}` is nearer to 0 than anything that is measured; taken as it is{more}"
            );
            self.note_field(Severity::Warning, field, message);
        }
        if self.suppressed > 0 {
            let message = format!("{} more like these are not listed", self.suppressed);
            self.diagnostics.push(Diagnostic {
                severity: Severity::Note,
                line: 0,
                element: String::new(),
                message,
            });
        }
        self.diagnostics
    }
}

/// The fields that lead to a fault inside a message, and the fault, of the text of an error.
///
/// The text has `Message.field` from the innermost to the outermost, and then what is wrong.
fn inside(error: &str) -> (String, String) {
    let mut rest = error
        .split_once("message: ")
        .map_or(error, |(_, rest)| rest);
    let mut fields = Vec::new();
    while let Some((step, after)) = rest.split_once(": ")
        && let Some((_, field)) = step.split_once('.').filter(|_| !step.contains(' '))
    {
        fields.push(field);
        rest = after;
    }
    let path = fields
        .iter()
        .rev()
        .take(DEEPEST_PATH)
        .map(|field| format!("/{field}"));
    (path.collect(), rest.to_string())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_inside_a_message_is_named_with_its_fields() {
        use crate::scenario::commonroad::protobuf::messages::Lanelet;
        // Lanelet 7, whose left border has a point whose x is cut off.
        let bytes = [0x08, 0x07, 0x12, 0x04, 0x0a, 0x02, 0x09, 0x01];
        let field = Field {
            number: 4,
            offset: 30,
            value: Value::Bytes(&bytes),
            missing: 0,
        };
        let mut report = Report::about("x.pb");
        let root = At::root("");
        let error = report.decode::<Lanelet>(&root.nth("lanelets", 3), &field);
        assert_eq!(
            error.unwrap_err().to_string(),
            "x.pb: in lanelets[3]/left_bound/points/x: damaged protobuf after byte 30: buffer underflow"
        );
    }

    #[test]
    fn a_path_names_every_field_on_the_way() {
        let root = At::root("");
        let obstacle = root.nth("dynamic_obstacles", 3);
        assert_eq!(
            obstacle.field("initial_state").to_string(),
            "dynamic_obstacles[3]/initial_state"
        );
        let map = At::root("map");
        assert_eq!(map.nth("lanelets", 0).to_string(), "map/lanelets[0]");
    }
}

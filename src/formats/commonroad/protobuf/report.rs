//! The position of a message in its file, and diagnostics at it.

use std::cell::{Cell, RefCell};
use std::fmt;

use prost::Message;

use super::wire::{Field, Fields, NoField, Value};
use crate::commonroad::ReadError;
use crate::commonroad::builder::{Diagnostics, SourceLocation};
use nearmiss_base::geometry::ShapeError;
use nearmiss_scene::scenario::{Diagnostic, Severity};

/// No element of a scenario is larger, bytes; a decoded message can be fifty times as large as its bytes.
const LARGEST_ELEMENT: usize = 8 << 20;

/// Longest path to a reported fault, fields.
const DEEPEST_PATH: usize = 6;

/// The file that is read, and what was noted about it and those beside it.
pub(super) struct Report {
    /// The file's name.
    pub file: RefCell<String>,
    pub diagnostics: Diagnostics,
    /// The first number that is nearer to 0 than any that is measured, and how many there are.
    tiny: RefCell<Option<(String, f64, usize)>>,
    /// Offset of the element being read, bytes.
    element: Cell<usize>,
    /// Whether it was counted that the element has fields that are not known.
    incomplete: Cell<bool>,
}

impl Report {
    pub fn about(file: &str) -> Self {
        Self {
            file: RefCell::new(file.to_string()),
            diagnostics: Diagnostics::default(),
            tiny: RefCell::default(),
            element: Cell::default(),
            incomplete: Cell::default(),
        }
    }

    pub fn into_diagnostics(self) -> Vec<Diagnostic> {
        if let Some((field, value, count)) = self.tiny.take() {
            let more = match count {
                1 => String::new(),
                count => format!(" (and {} more)", count - 1),
            };
            let message = format!("`{value:e}` is implausibly close to 0; used as is{more}");
            self.diagnostics
                .push(Severity::Warning, || (0, field), message);
        }
        self.diagnostics.into_list()
    }
}

/// Path of a field: the names of the fields that lead to it. Formatted only for diagnostics.
#[derive(Clone, Copy)]
pub(super) struct FieldPath<'a> {
    pub report: &'a Report,
    up: Option<&'a FieldPath<'a>>,
    name: &'a str,
    index: Option<usize>,
}

impl<'a> FieldPath<'a> {
    /// The message itself; `name` may be empty.
    pub fn root(report: &'a Report, name: &'a str) -> Self {
        Self {
            report,
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
            ..*self
        }
    }

    /// An element of a repeated field, from 0.
    pub fn nth(&'a self, name: &'a str, index: usize) -> Self {
        Self {
            index: Some(index),
            ..self.field(name)
        }
    }

    /// A field that the schema requires.
    pub fn need<T>(&self, name: &str, value: Option<T>) -> Result<T, ReadError> {
        value.ok_or_else(|| self.fail(format!("the required field `{name}` is missing")))
    }

    /// Counts a field of the message that is not used: a scenario cannot hold it.
    pub fn no_place_for(&self, field: &str) {
        let kind = self.field(field).kind();
        self.report.diagnostics.unused(kind, || 0);
    }

    /// The names of the fields that lead to it, without places.
    fn kind(&self) -> String {
        match self.up.filter(|up| !up.name.is_empty()) {
            Some(up) => format!("{}/{}", up.kind(), self.name),
            None => self.name.to_string(),
        }
    }

    /// Reads the fields of the file's own message one after the other, so that no more than one of its elements is in
    /// memory twice.
    pub fn each_field(
        &self,
        bytes: &[u8],
        mut read: impl FnMut(&Field<'_>) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        for field in Fields::new(bytes) {
            read(&self.complete(field)?)?;
        }
        Ok(())
    }

    /// A field of the file's own message, whole.
    fn complete<'f>(&self, field: Result<Field<'f>, NoField>) -> Result<Field<'f>, ReadError> {
        let message = match field {
            Ok(field) if field.missing == 0 => return Ok(field),
            Ok(field) => format!(
                "field {} at byte {} extends {} bytes beyond the end; the file is truncated",
                field.number, field.offset, field.missing
            ),
            Err(NoField { offset, cut: true }) => {
                format!("the file ends within the field at byte {offset}; it is truncated")
            }
            Err(NoField { offset, .. }) => {
                format!("no protobuf field starts at byte {offset}; the file is damaged")
            }
        };
        Err(self.fail(message))
    }

    /// Counts a field of the file's own message that no schema knows as not used.
    pub fn skip_unknown(&self, field: &Field<'_>) {
        let number = format!("field {}", field.number);
        self.no_place_for(&number);
    }

    /// The message in a field of the file's own message.
    pub fn element<M: Message + Default>(&self, field: &Field<'_>) -> Result<M, ReadError> {
        let Value::Bytes(bytes) = field.value else {
            let message = format!(
                "field {} at byte {} is not a message",
                field.number, field.offset
            );
            return Err(self.fail(message));
        };
        if bytes.len() > LARGEST_ELEMENT {
            let message = format!(
                "{} MiB at byte {}; at most {} MiB of an element are read",
                bytes.len().div_ceil(1 << 20),
                field.offset,
                LARGEST_ELEMENT >> 20
            );
            return Err(self.fail(message));
        }
        self.report.element.set(field.offset);
        self.report.incomplete.set(false);
        self.decode(bytes)
    }

    /// The message in some bytes of an element.
    pub fn decode<M: Message + Default>(&self, bytes: &[u8]) -> Result<M, ReadError> {
        let message = M::decode(bytes).map_err(|error| {
            let (path, cause) = inside(&error.to_string());
            let byte = self.report.element.get();
            let mut error = self.fail(format!("damaged protobuf after byte {byte}: {cause}"));
            error.element.push_str(&path);
            error
        })?;
        let known = message.encoded_len();
        // Of fields that are in no schema nothing but their bytes is known; within others they are counted once.
        if known < bytes.len() && !self.report.incomplete.replace(true) {
            self.no_place_for("unknown or repeated fields");
        }
        Ok(message)
    }

    /// The part of which there is one, read by `read` from the message in a field; a second one replaces it.
    pub fn part<M: Message + Default, T>(
        &self,
        field: &Field<'_>,
        into: &mut Option<T>,
        read: impl FnOnce(&FieldPath<'_>, &M) -> Result<T, ReadError>,
    ) -> Result<(), ReadError> {
        if into.replace(read(self, &self.element(field)?)?).is_some() {
            self.warn("given more than once; the last one is used");
        }
        Ok(())
    }
}

impl SourceLocation for FieldPath<'_> {
    fn fail(&self, message: impl Into<String>) -> ReadError {
        ReadError {
            file: self.report.file.borrow().clone(),
            line: 0,
            column: 0,
            element: self.to_string(),
            message: message.into(),
        }
    }

    fn note(&self, severity: Severity, message: impl Into<String>) {
        let place = || (0, self.to_string());
        self.report.diagnostics.push(severity, place, message);
    }

    fn warn_tiny(&self, value: f64) {
        match &mut *self.report.tiny.borrow_mut() {
            Some((.., count)) => *count += 1,
            first => *first = Some((self.to_string(), value, 1)),
        }
    }

    fn leave_out(&self, error: &ShapeError) -> Result<(), ReadError> {
        Err(self.fail(error.to_string()))
    }
}

impl fmt::Display for FieldPath<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(up) = self.up.filter(|up| !up.name.is_empty()) {
            write!(f, "{up}/")?;
        }
        f.write_str(self.name)?;
        self.index.map_or(Ok(()), |i| write!(f, "[{i}]"))
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
        use crate::commonroad::protobuf::messages::Lanelet;
        // Lanelet 7, whose left border has a point whose x is cut off.
        let bytes = [0x08, 0x07, 0x12, 0x04, 0x0a, 0x02, 0x09, 0x01];
        let field = Field {
            number: 4,
            offset: 30,
            value: Value::Bytes(&bytes),
            missing: 0,
        };
        let report = Report::about("x.pb");
        let root = FieldPath::root(&report, "");
        let error = root.nth("lanelets", 3).element::<Lanelet>(&field);
        assert_eq!(
            error.unwrap_err().to_string(),
            "x.pb: in lanelets[3]/left_bound/points/x: damaged protobuf after byte 30: buffer underflow"
        );
    }

    #[test]
    fn a_path_names_every_field_on_the_way() {
        let report = Report::about("x.pb");
        let root = FieldPath::root(&report, "");
        let obstacle = root.nth("dynamic_obstacles", 3);
        assert_eq!(
            obstacle.field("initial_state").to_string(),
            "dynamic_obstacles[3]/initial_state"
        );
        let map = FieldPath::root(&report, "map");
        assert_eq!(map.nth("lanelets", 0).to_string(), "map/lanelets[0]");
    }
}

//! What is said about a recording while it is read, and where in it.

use crate::commonroad::ReadError;
use crate::commonroad::builder::{self, Diagnostics, SourceLocation};
use nearmiss_base::geometry::{Point, ShapeError};
use nearmiss_scene::scenario::{Diagnostic, Severity};

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

//! Places of a scenario's parts in their file, and the list of diagnostics.

use std::cell::{Cell, RefCell};

use crate::formats::commonroad::ReadError;
use crate::geometry::ShapeError;
use crate::scenario::{Diagnostic, Severity};

/// A place in a file: an element of XML, a field of protobuf.
pub trait SourceLocation {
    /// An error about what is here.
    fn fail(&self, message: impl Into<String>) -> ReadError;

    /// Notes something assumed or left out here.
    fn note(&self, severity: Severity, message: impl Into<String>);

    /// Warns of something assumed or left out here.
    fn warn(&self, message: impl Into<String>) {
        self.note(Severity::Warning, message);
    }

    /// Warns of a number that is nearer to 0 than any that is measured.
    fn warn_tiny(&self, value: f64);

    /// Leaves out a shape that encloses nothing.
    ///
    /// # Errors
    /// The format does not let it be left out.
    fn leave_out(&self, error: &ShapeError) -> Result<(), ReadError>;
}

/// More diagnostics than this say nothing new.
const MOST_DIAGNOSTICS: usize = 500;

/// The diagnostics of a file, in the order in which they are found.
#[derive(Debug, Default)]
pub struct Diagnostics {
    listed: RefCell<Vec<Diagnostic>>,
    suppressed: Cell<usize>,
}

impl Diagnostics {
    /// Adds one; `place` is its line and element.
    pub fn push(
        &self,
        severity: Severity,
        place: impl FnOnce() -> (usize, String),
        message: impl Into<String>,
    ) {
        let mut listed = self.listed.borrow_mut();
        if listed.len() >= MOST_DIAGNOSTICS {
            self.suppressed.set(self.suppressed.get() + 1);
            return;
        }
        let (line, element) = place();
        listed.push(Diagnostic {
            severity,
            line,
            element,
            message: message.into(),
        });
    }

    /// All of them, and how many are not listed.
    pub fn into_list(self) -> Vec<Diagnostic> {
        let mut listed = self.listed.into_inner();
        if self.suppressed.get() > 0 {
            listed.push(Diagnostic {
                severity: Severity::Note,
                line: 0,
                element: String::new(),
                message: format!("{} more like these are not listed", self.suppressed.get()),
            });
        }
        listed
    }
}

impl From<Vec<Diagnostic>> for Diagnostics {
    fn from(listed: Vec<Diagnostic>) -> Self {
        Self {
            listed: listed.into(),
            suppressed: Cell::default(),
        }
    }
}

//! Places of a scenario's parts in their file, and the list of diagnostics.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;

use crate::commonroad::ReadError;
use nearmiss_base::geometry::ShapeError;
use nearmiss_scene::scenario::{Diagnostic, Severity};

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

/// As many kinds of unused elements are told apart; more are counted together.
const MOST_KINDS: usize = 200;

/// How often a kind of element is not used, and the line of the first one.
#[derive(Debug)]
struct Unused {
    line: usize,
    count: usize,
}

/// The diagnostics of a file, in the order in which they are found.
#[derive(Debug, Default)]
pub struct Diagnostics {
    listed: RefCell<Vec<Diagnostic>>,
    suppressed: Cell<usize>,
    unused: RefCell<BTreeMap<String, Unused>>,
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

    /// Counts what stands in the file and is not used, by its kind: a path of names without ids, such as
    /// `lanelet/userData` or `lane@direction` for an attribute. Every reader accounts so for all that it passes over.
    /// `line` is asked only of the first of a kind; 0 where the file has no lines.
    pub fn unused(&self, kind: impl Into<String>, line: impl FnOnce() -> usize) {
        self.unused_times(kind, 1, line);
    }

    /// The same of so many at once.
    pub fn unused_times(
        &self,
        kind: impl Into<String>,
        count: usize,
        line: impl FnOnce() -> usize,
    ) {
        let mut unused = self.unused.borrow_mut();
        let mut kind = kind.into();
        if unused.len() >= MOST_KINDS && !unused.contains_key(&kind) {
            kind = "other kinds".into();
        }
        match unused.get_mut(&kind) {
            Some(known) => known.count += count,
            None => {
                let line = line();
                unused.insert(kind, Unused { line, count });
            }
        }
    }

    /// All of them, how many are not listed, and what is not used, a kind each.
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
        let unused = self.unused.into_inner().into_iter();
        listed.extend(unused.map(|(element, Unused { line, count })| Diagnostic {
            severity: Severity::Unused,
            line,
            element,
            message: format!("{count} ×"),
        }));
        listed
    }
}

impl From<Vec<Diagnostic>> for Diagnostics {
    fn from(listed: Vec<Diagnostic>) -> Self {
        Self {
            listed: listed.into(),
            ..Self::default()
        }
    }
}

//! Diagnostics deferred until the whole file is read, kept with the enclosing elements.

use std::rc::Rc;

use super::{Element, Xml};
use nearmiss_scene::scenario::Severity;

/// An element and those around it, from the root.
#[derive(Debug, Clone)]
pub(crate) struct SourceLocation<'a> {
    pub element: Element<'a>,
    pub(super) around: Rc<[Element<'a>]>,
}

/// Elements kept for later diagnostics.
#[derive(Debug, Default)]
pub(super) struct DeferredChecks<'a> {
    /// References met so far.
    references: Vec<(SourceLocation<'a>, i64)>,
    /// Speed limits of version 2018b, by lanelet.
    speed_limits: Vec<(i64, f64, SourceLocation<'a>)>,
    /// States and goals since the last top-level element, for later diagnostics.
    marks: Vec<SourceLocation<'a>>,
    /// The elements around the last one, which are those around the next one more often than not.
    around: Rc<[Element<'a>]>,
}

impl<'a> Xml<'a> {
    /// Remembers a reference, to be checked at the end.
    pub fn refer(&mut self, element: Element<'a>, id: i64) {
        let place = self.place(element);
        self.later.references.push((place, id));
    }

    /// The references met so far.
    pub fn take_references(&mut self) -> Vec<(SourceLocation<'a>, i64)> {
        std::mem::take(&mut self.later.references)
    }

    /// Remembers a speed limit of a lanelet, m/s.
    pub fn limit_speed(&mut self, lanelet: i64, limit: f64, element: Element<'a>) {
        let place = self.place(element);
        self.later.speed_limits.push((lanelet, limit, place));
    }

    /// The speed limits met so far, in the file's order.
    pub fn take_speed_limits(&mut self) -> Vec<(i64, f64, SourceLocation<'a>)> {
        std::mem::take(&mut self.later.speed_limits)
    }

    /// Notes something assumed or skipped at a place that was left long ago.
    pub fn note_at(&self, severity: Severity, place: &SourceLocation<'a>, message: String) {
        let element = place.element;
        let at = || {
            (
                self.line_of(element.at),
                super::path(&place.around, Some(element)),
            )
        };
        self.diagnostics.push(severity, at, message);
    }

    /// Remembers where a state or a goal is.
    pub fn mark(&mut self, element: Element<'a>) {
        let place = self.place(element);
        self.later.marks.push(place);
    }

    /// The elements remembered since the last call.
    pub fn take_marks(&mut self) -> Vec<SourceLocation<'a>> {
        std::mem::take(&mut self.later.marks)
    }

    /// An element and those around it.
    pub fn place(&mut self, element: Element<'a>) -> SourceLocation<'a> {
        let open = match self.path.split_last() {
            Some((last, around)) if last.at == element.at => around,
            _ => &self.path,
        };
        let known = &self.later.around;
        let same =
            known.len() == open.len() && known.last().map(|e| e.at) == open.last().map(|e| e.at);
        if !same {
            self.later.around = open.into();
        }
        SourceLocation {
            element,
            around: self.later.around.clone(),
        }
    }
}

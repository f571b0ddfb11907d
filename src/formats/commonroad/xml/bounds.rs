//! Limits on input: nesting depth, attributes, and counts of elements.

use super::{Element, Xml, short};
use crate::commonroad::error::ReadError;
use nearmiss_scene::scenario::plausibility::limits::MOST_PARTS;

/// Elements inside each other, deeper than any file needs.
const DEEPEST: usize = 100;

/// No element has longer attributes, bytes.
const LONGEST_ATTRIBUTES: usize = 64 << 10;

impl<'a> Xml<'a> {
    /// # Errors
    /// An element is too deep inside others, or its attributes are too long.
    pub(super) fn check_bounds(&self, element: Element<'a>) -> Result<(), ReadError> {
        let long = element.attributes.len();
        if self.path.len() >= DEEPEST {
            let message = format!("elements are nested more than {DEEPEST} deep");
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

//! Repeated elements of a file's top-level message.

use prost::Message;

use super::report::FieldPath;
use super::wire::Field;
use crate::commonroad::ReadError;
use crate::commonroad::builder::ScenarioBuilder;

/// The repeated elements of a file's own message, which are added to a scenario.
pub(super) struct Elements<'a> {
    pub root: &'a FieldPath<'a>,
    pub builder: &'a mut ScenarioBuilder,
    /// The numbers of fields, and how many of each there were.
    counts: Vec<(u32, usize)>,
}

impl<'a> Elements<'a> {
    pub fn new(root: &'a FieldPath<'a>, builder: &'a mut ScenarioBuilder) -> Self {
        Self {
            root,
            builder,
            counts: Vec::new(),
        }
    }

    /// Adds the element in a field with this name.
    pub fn add<M: Message + Default>(
        &mut self,
        name: &str,
        field: &Field<'_>,
        read: impl FnOnce(&mut ScenarioBuilder, &FieldPath<'_>, &M) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        let at = self.root.nth(name, self.count(field.number));
        read(self.builder, &at, &at.element(field)?)
    }

    /// How many fields with a number there were before.
    fn count(&mut self, number: u32) -> usize {
        let known = self.counts.iter().position(|(n, _)| *n == number);
        let place = known.unwrap_or_else(|| {
            self.counts.push((number, 0));
            self.counts.len() - 1
        });
        self.counts[place].1 += 1;
        self.counts[place].1 - 1
    }
}

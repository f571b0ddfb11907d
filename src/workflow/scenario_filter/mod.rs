//! The filter of the scenario list: fuzzy words, and terms such as `tag:cut_in` or `risk<3`; for list and experiments.

mod countries;
mod facts;
mod filter;
mod index_terms;
#[cfg(test)]
mod index_tests;
mod selector;
mod terms;

pub use facts::{Facts, Tally, Verdicts, country_of, nearest};
pub use filter::{Filter, Matching, WordMatch};
pub use index_terms::window_values;
pub use selector::Selector;
pub use terms::{HEADLINE, Number, Property, TERMS};

use std::sync::Arc;

use nearmiss_formats::Entry;
use nearmiss_scene::corpus::{CellWindows, InIndex};

/// Agreement of a scenario's stored answers with the built-in judge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Agreement {
    /// One or more of them differ.
    Differ,
    /// All of them agree.
    Agree,
    /// There are none.
    Nothing,
}

/// A scenario as a filter sees it; what is not known yet is `None`.
pub trait Filterable {
    /// The scenario.
    fn entry(&self) -> &Entry;
    /// Its tags.
    fn tags(&self) -> impl Iterator<Item = &str>;
    /// Three letters for its country; may be empty.
    fn country(&self) -> &str;
    /// Whether it has something.
    fn has(&self, property: Property) -> Option<bool>;
    /// The verdicts of stored answers.
    fn agreement(&self) -> Option<Agreement>;
    /// A number of it.
    fn number(&self, number: Number) -> Option<f64>;
    /// What an index of a corpus says of it.
    fn indexed(&self) -> &Indexed;
}

/// What an index of a corpus says of a scenario.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Indexed {
    /// Not known: there is no index, or the scenario was not read yet.
    #[default]
    Unknown,
    /// The index has windows of these contents.
    Windows(Arc<[CellWindows]>),
    /// The index has other contents under this name.
    Changed,
    /// The index does not have it.
    Missing,
}

impl Indexed {
    /// Its windows, where the index has it.
    #[must_use]
    pub fn windows(&self) -> Option<&[CellWindows]> {
        match self {
            Self::Windows(windows) => Some(windows),
            _ => None,
        }
    }
}

impl From<InIndex<'_>> for Indexed {
    fn from(found: InIndex<'_>) -> Self {
        match found {
            InIndex::Same(scenario) => Self::Windows(Arc::clone(&scenario.windows)),
            InIndex::Changed => Self::Changed,
            InIndex::Missing => Self::Missing,
        }
    }
}

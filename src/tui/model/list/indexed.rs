//! The index of a corpus that the list is filtered by.

use std::sync::Arc;

use super::{CorpusIndex, Filter, List};
use nearmiss_workflow::Indexed;

/// The index behind terms such as `road:urban`.
#[derive(Debug, Clone, Default)]
pub enum ListIndex {
    /// None was chosen.
    #[default]
    None,
    /// It is being read.
    Reading,
    /// It cannot be read.
    Failed,
    /// It was read.
    Ready(Arc<CorpusIndex>),
}

impl ListIndex {
    /// The index, once it was read.
    #[must_use]
    pub fn ready(&self) -> Option<&Arc<CorpusIndex>> {
        match self {
            Self::Ready(index) => Some(index),
            _ => None,
        }
    }

    /// Why a term that needs an index is an error.
    fn refusal(&self) -> Option<&'static str> {
        match self {
            Self::Ready(_) => None,
            Self::None => Some(
                "needs an index: choose one with `:index FOLDER` or `nearmiss --index FOLDER`; \
                 `nearmiss corpus index PATH… -o FOLDER` makes one",
            ),
            Self::Reading => Some("waits for the index, which is being read"),
            Self::Failed => {
                Some("needs an index, and this one cannot be read; `:index` chooses another")
            }
        }
    }
}

/// How many scenarios of the list an index has.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct IndexShare {
    /// The same contents, under any name.
    pub same: usize,
    /// Other contents under the same name.
    pub changed: usize,
    /// Neither.
    pub missing: usize,
    /// Not read yet.
    pub unknown: usize,
}

impl IndexShare {
    /// What is missing, in words; nothing where the index has every scenario.
    #[must_use]
    pub fn words(&self) -> String {
        let counts = [
            (self.changed, "changed since"),
            (self.missing, "not in the index"),
            (self.unknown, "not read yet"),
        ];
        let said = counts.into_iter().filter(|(count, _)| *count > 0);
        let said: Vec<String> = said
            .map(|(count, words)| format!("{count} {words}"))
            .collect();
        said.join(", ")
    }
}

impl List {
    /// Filters by another index, or by none.
    pub fn set_index(&mut self, index: ListIndex) {
        self.index = index;
        for row in &mut self.rows {
            row.look_up(self.index.ready().map(Arc::as_ref));
        }
        self.read_filter();
        self.arrange(true);
    }

    /// The index.
    #[must_use]
    pub fn index(&self) -> &ListIndex {
        &self.index
    }

    /// How many scenarios the index has.
    #[must_use]
    pub fn index_share(&self) -> IndexShare {
        let mut share = IndexShare::default();
        for row in &self.rows {
            *match row.indexed {
                Indexed::Windows(_) => &mut share.same,
                Indexed::Changed => &mut share.changed,
                Indexed::Missing => &mut share.missing,
                Indexed::Unknown => &mut share.unknown,
            } += 1;
        }
        share
    }

    /// Reads the filter as it is typed.
    pub(super) fn read_filter(&mut self) {
        self.read = Filter::read(&self.filter, self.measure());
        if let Some(why) = self.index.refusal() {
            self.read.refuse_index_terms(why);
        }
    }
}

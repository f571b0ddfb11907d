//! A sentence such as `cut-ins under 1.5 s TTC on motorways` becomes a filter of the list and of an index.
//!
//! Phrases of a fixed vocabulary ([`phrases`]) are recognised in any order, the longest first; numbers take the measure
//! beside them. A word that is not understood is named, never dropped.

mod lexicon;
mod quantity;
mod reading;
#[cfg(test)]
mod tests;
mod words;

pub use lexicon::documented as phrases;

/// A sentence that was read.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Sentence {
    /// The filter; empty where nothing was understood.
    pub filter: String,
    /// Parts of the sentence that have no term, in its order.
    pub not_understood: Vec<String>,
}

impl Sentence {
    /// Reads a sentence.
    #[must_use]
    pub fn read(sentence: &str) -> Self {
        reading::read(sentence)
    }
}

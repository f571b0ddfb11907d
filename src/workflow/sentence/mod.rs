//! A sentence such as `cut-ins under 1.5 s TTC on motorways` becomes a filter of the list and of an index.
//!
//! Phrases of a fixed vocabulary are recognised in any order, the longest first; numbers take the measure beside them.
//! What is not understood, or has no term in the filter language, is named, never dropped.

mod items;
mod levels;
mod lexicon;
mod phrases;
mod quantity;
mod reading;
#[cfg(test)]
mod tests;
mod words;

/// A sentence that was read.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Sentence {
    /// The filter; empty where nothing was understood.
    pub filter: String,
    /// Parts of the sentence that have no term, in its order.
    pub not_understood: Vec<NotUnderstood>,
}

/// Part of a sentence that has no term.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NotUnderstood {
    /// Its words.
    pub words: String,
    /// The word of the vocabulary that is probably meant.
    pub alike: Option<&'static str>,
}

impl Sentence {
    /// Reads a sentence.
    #[must_use]
    pub fn read(sentence: &str) -> Self {
        reading::read(sentence)
    }

    /// What is left out, in words; nothing where all was understood. `shown` makes text of the user's harmless.
    #[must_use]
    pub fn left_out(&self, shown: impl Fn(&str) -> String) -> Option<String> {
        let parts = self.not_understood.iter().map(|part| match part.alike {
            Some(alike) => format!("{} (did you mean `{alike}`?)", shown(&part.words)),
            None => shown(&part.words),
        });
        let parts: Vec<String> = parts.collect();
        (!parts.is_empty()).then(|| format!("not understood, left out: {}", parts.join(", ")))
    }
}

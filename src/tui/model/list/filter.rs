//! The list filter: fuzzy words, and terms such as `tag:cut_in` or `risk<3`.

use crate::tui::model::Place;
use nucleo_matcher::pattern::{CaseMatching, Normalization, Pattern};
use nucleo_matcher::{Config, Matcher, Utf32Str};

use super::Row;
use super::terms::{Term, term};
use crate::metrics::Measure;

/// The filter while it is typed.
#[derive(Debug, Clone)]
pub struct Filtering {
    /// Whether the whole text is selected: the first character that is typed replaces it.
    pub selected: bool,
    /// The text before.
    pub before: String,
    /// The selected line before.
    pub line: usize,
    /// The scenario and step that were open before.
    pub place: Option<Place>,
}

/// A filter that was read; empty, it lets everything through.
#[derive(Debug, Clone, Default)]
pub struct Filter {
    words: Pattern,
    terms: Vec<Term>,
    /// Errors in terms, one sentence each; a wrong term filters nothing.
    pub wrong: Vec<String>,
}

impl Filter {
    /// Reads a filter; `sorted` is the measure whose values are known because the list is sorted by it.
    #[must_use]
    pub fn read(text: &str, sorted: Option<&'static Measure>) -> Self {
        let mut filter = Self::default();
        let mut words = Vec::new();
        for word in text.split_whitespace() {
            match term(word, sorted) {
                None => words.push(word),
                Some(Ok(term)) => filter.terms.extend(term),
                Some(Err(why)) => filter.wrong.push(why),
            }
        }
        let (case, form) = (CaseMatching::Smart, Normalization::Smart);
        filter.words = Pattern::parse(&words.join(" "), case, form);
        filter
    }

    /// Whether there are words, by whose match scenarios are ordered.
    #[must_use]
    pub fn has_words(&self) -> bool {
        !self.words.atoms.is_empty()
    }

    /// Whether it needs facts known only after a scenario was read.
    #[must_use]
    pub fn needs_facts(&self) -> bool {
        self.terms.iter().any(|term| term.test.needs_facts())
    }

    /// How well a scenario matches; `None` if it is held back.
    pub fn score(&self, row: &Row, matching: &mut Matching) -> Option<u32> {
        let lets_through = |term: &Term| term.test.holds(row) != term.negated;
        if !self.terms.iter().all(lets_through) {
            return None;
        }
        if !self.has_words() {
            return Some(0);
        }
        let text = [row.entry.name.as_str(), " ", row.entry.group.as_str()].concat();
        let text = Utf32Str::new(&text, &mut matching.buffer);
        self.words.score(text, &mut matching.matcher)
    }

    /// Which graphemes of a name match, in order.
    pub fn matched(&self, name: &str, matching: &mut Matching) -> Vec<usize> {
        let mut places = Vec::new();
        let text = Utf32Str::new(name, &mut matching.buffer);
        for atom in self.words.atoms.iter().filter(|atom| !atom.negative) {
            // A word may match the folder alone: then it marks nothing of the name.
            let before = places.len();
            if atom
                .indices(text, &mut matching.matcher, &mut places)
                .is_none()
            {
                places.truncate(before);
            }
        }
        places.sort_unstable();
        places.dedup();
        let places = places.into_iter();
        places.filter_map(|at| usize::try_from(at).ok()).collect()
    }
}

/// Reusable state of the fuzzy matcher.
#[derive(Debug)]
pub struct Matching {
    matcher: Matcher,
    buffer: Vec<char>,
}

impl Default for Matching {
    fn default() -> Self {
        Self {
            matcher: Matcher::new(Config::DEFAULT.match_paths()),
            buffer: Vec::new(),
        }
    }
}

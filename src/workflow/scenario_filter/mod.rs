//! The filter of the scenario list: fuzzy words, and terms such as `tag:cut_in` or `risk<3`; for list and experiments.

pub(crate) mod event_terms;
mod facts;
mod index_terms;
pub(crate) mod selector;
mod terms;

use std::sync::Arc;

use nearmiss_formats::Entry;
use nearmiss_scene::corpus::{CellWindows, InIndex};
use nearmiss_scene::metrics::Measure;
use nucleo_matcher::pattern::{CaseMatching, Normalization, Pattern};
use nucleo_matcher::{Config, Matcher, Utf32Str};

use facts::country_codes;
use index_terms::{WindowTest, some_window_holds, window_test, windows_hold};
use terms::{Measures, Term, Test, term};

pub use facts::{Facts, Tally, Verdicts, country_code, nearest};
pub use index_terms::window_values;
pub use selector::Selector;
pub use terms::{HEADLINE, Number, Property, TERMS};

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

/// A filter that was read; empty, it lets everything through.
#[derive(Debug, Clone, Default)]
pub struct Filter {
    words: Words,
    /// Words that name a country: each matches its scenarios, or like other words.
    countries: Vec<(Vec<&'static str>, Words)>,
    terms: Vec<Term>,
    /// Terms about windows of an index, and whether they are negated.
    windows: Vec<(WindowTest, bool)>,
    /// Errors in terms, one sentence each; a wrong term filters nothing.
    pub wrong: Vec<String>,
    /// Whether the value of a term is still missing; such a term filters nothing.
    pub incomplete: bool,
}

/// How words match a scenario.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WordMatch {
    /// As parts of its name or folder or as the start of a word of a tag, capitals or not.
    #[default]
    Part,
    /// By their letters in this order, which is tried where no scenario has them as parts.
    Fuzzy,
}

/// Words, ready for both ways of matching.
#[derive(Debug, Clone, Default)]
struct Words {
    parts: Pattern,
    fuzzy: Pattern,
    /// In small letters, without operators.
    plain: Vec<String>,
    /// How many have no operator.
    bare: usize,
}

/// A word in small letters, without the operators around it.
fn plain_word(word: &str) -> String {
    word.trim_start_matches(['!', '^', '\'', '\\'])
        .trim_end_matches('$')
        .to_lowercase()
}

impl Words {
    fn parse(words: &[&str]) -> Self {
        let (case, form) = (CaseMatching::Ignore, Normalization::Smart);
        // A leading `'` asks for a part; `^`, `!` and a `$` at the end say already how to match.
        let plain = |word: &str| !word.starts_with(['\'', '^', '!', '\\']) && !word.ends_with('$');
        let parts = words.iter().map(|word| {
            if plain(word) {
                format!("'{word}")
            } else {
                (*word).to_string()
            }
        });
        let parts: Vec<String> = parts.collect();
        Self {
            parts: Pattern::parse(&parts.join(" "), case, form),
            fuzzy: Pattern::parse(&words.join(" "), case, form),
            plain: words.iter().map(|word| plain_word(word)).collect(),
            bare: words.iter().filter(|word| plain(word)).count(),
        }
    }

    /// Whether one of them begins a word of a tag: `merge` is no part of `emergency_braking`.
    fn begin_in(&self, tag: &str) -> bool {
        let tag = tag.to_lowercase();
        let begins = |at: usize| self.plain.iter().any(|word| tag[at..].starts_with(word));
        let after = tag.match_indices(|c: char| !c.is_alphanumeric());
        begins(0) || after.into_iter().any(|(at, sign)| begins(at + sign.len()))
    }

    fn pattern(&self, how: WordMatch) -> &Pattern {
        match how {
            WordMatch::Part => &self.parts,
            WordMatch::Fuzzy => &self.fuzzy,
        }
    }
}

impl Filter {
    /// Reads a filter; `sorted` is the measure whose values are known because the list is sorted by it.
    #[must_use]
    pub fn read(text: &str, sorted: Option<&'static Measure>) -> Self {
        Self::read_with(text, Measures::Sorted(sorted))
    }

    /// Reads a filter that may compare every measure.
    #[must_use]
    pub fn read_of_all(text: &str) -> Self {
        let mut filter = Self::read_with(text, Measures::All);
        let has_terms = !filter.terms.is_empty() || !filter.windows.is_empty();
        let is_joint = |word: &&str| has_terms && JOINTS.contains(&word.to_lowercase().as_str());
        let joints = text.split_whitespace().filter(is_joint);
        let wrong = joints.map(|joint| {
            format!("`{joint}`: terms stand side by side, and all hold: ttc<1.5 obstacles>20")
        });
        filter.wrong.extend(wrong);
        filter
    }

    fn read_with(text: &str, measures: Measures) -> Self {
        let mut filter = Self::default();
        let mut words = Vec::new();
        let text = without_spaces(text);
        for word in text.split_whitespace() {
            match term(word, measures) {
                None => match (country_codes(word.trim_start_matches('!')), word) {
                    (codes, _) if codes.is_empty() => words.push(word),
                    (codes, word) if word.starts_with('!') => filter.terms.push(Term {
                        test: Test::Country(vec![(word.to_uppercase(), codes)]),
                        negated: true,
                    }),
                    (codes, _) => {
                        filter.countries.push((codes, Words::parse(&[word])));
                    }
                },
                Some(Ok(None)) => filter.incomplete = true,
                Some(Ok(Some(term))) => match window_test(&term.test) {
                    Some(test) => filter.windows.push((test, term.negated)),
                    None => filter.terms.push(term),
                },
                Some(Err(why)) => filter.wrong.push(why),
            }
        }
        filter.words = Words::parse(&words);
        filter
    }

    /// Whether there are words, by whose match scenarios are ordered.
    #[must_use]
    pub fn has_words(&self) -> bool {
        !self.words.fuzzy.atoms.is_empty() || !self.countries.is_empty()
    }

    /// Whether it has several words that are no terms, as a sentence has.
    #[must_use]
    pub fn is_sentence(&self) -> bool {
        self.words.bare > 1
    }

    /// Whether anything of it filters.
    #[must_use]
    pub fn filters(&self) -> bool {
        self.has_words() || !self.terms.is_empty() || !self.windows.is_empty()
    }

    /// Whether its terms need facts known only after a scenario was read.
    #[must_use]
    pub fn needs_facts(&self) -> bool {
        !self.windows.is_empty() || self.terms.iter().any(|term| term.test.needs_facts())
    }

    /// The measures that it compares.
    pub fn measures(&self) -> impl Iterator<Item = &'static Measure> + '_ {
        self.terms.iter().filter_map(|term| match &term.test {
            Test::Number(Number::Of(measure), ..) => Some(*measure),
            _ => None,
        })
    }

    /// Whether a window, whose measures have these values, satisfies the terms about windows and their measures.
    pub fn holds_of_window(
        &self,
        window: &CellWindows,
        value: impl Fn(&Measure) -> Option<f64>,
    ) -> bool {
        let measured = self.terms.iter().all(|term| match &term.test {
            Test::Number(Number::Of(measure), how, limit) => {
                let holds = value(measure).is_some_and(|value| how.holds(value, *limit));
                holds != term.negated
            }
            _ => true,
        });
        measured && self.is_of_kind(window)
    }

    /// Whether a window satisfies the terms about windows, whatever its measures are.
    pub fn is_of_kind(&self, window: &CellWindows) -> bool {
        some_window_holds(&self.windows, std::slice::from_ref(window))
    }

    /// Whether it has terms or words that ask for more than [`Self::holds_of_window`].
    #[must_use]
    pub fn asks_of_scenarios(&self) -> bool {
        let of_window = |term: &Term| matches!(term.test, Test::Number(Number::Of(_), ..));
        self.has_words() || !self.terms.iter().all(of_window)
    }

    /// The first term about the answers or tags of one user; `None` where every store gives the same scenarios.
    #[must_use]
    pub fn personal(&self) -> Option<&'static str> {
        self.terms.iter().find_map(|term| term.test.personal())
    }

    /// The first term that needs an index; `None` where there is none.
    #[must_use]
    pub fn index_term(&self) -> Option<&'static str> {
        let windows = self.windows.iter().map(|(test, _)| test.key());
        let others = self.terms.iter().filter_map(|term| term.test.of_index());
        windows.chain(others).next()
    }

    /// Makes the terms that need an index errors, and says why there is none.
    pub fn refuse_index_terms(&mut self, why: &str) {
        if let Some(term) = self.index_term() {
            self.wrong.push(format!("`{term}` {why}"));
            self.windows.clear();
            self.terms.retain(|term| term.test.of_index().is_none());
        }
    }

    /// How well a scenario matches; `None` if it is held back.
    pub fn score(
        &self,
        row: &impl Filterable,
        how: WordMatch,
        matching: &mut Matching,
    ) -> Option<u32> {
        let lets_through = |term: &Term| term.test.holds(row) != term.negated;
        if !self.terms.iter().all(lets_through) || !windows_hold(&self.windows, row) {
            return None;
        }
        if !self.has_words() {
            return Some(0);
        }
        let mut text = [row.entry().name.as_str(), " ", row.entry().group.as_str()].concat();
        if how == WordMatch::Part {
            let countries = self.countries.iter().map(|(_, word)| word);
            let words: Vec<&Words> = std::iter::once(&self.words).chain(countries).collect();
            for tag in row.tags() {
                if words.iter().any(|words| words.begin_in(tag)) {
                    text.extend([" ", tag]);
                }
            }
        }
        let text = Utf32Str::new(&text, &mut matching.buffer);
        let words = self.words.pattern(how);
        let mut score = words.score(text, &mut matching.matcher)?;
        for (codes, word) in &self.countries {
            score += if codes.contains(&row.country()) {
                OF_COUNTRY
            } else {
                word.pattern(how).score(text, &mut matching.matcher)?
            };
        }
        Some(score)
    }

    /// Which graphemes of a name match, in order.
    pub fn matched(&self, name: &str, how: WordMatch, matching: &mut Matching) -> Vec<usize> {
        let mut places = Vec::new();
        let text = Utf32Str::new(name, &mut matching.buffer);
        let countries = self.countries.iter().map(|(_, word)| word);
        let words = std::iter::once(&self.words).chain(countries);
        let atoms = words.flat_map(|word| &word.pattern(how).atoms);
        for atom in atoms.filter(|atom| !atom.negative) {
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

/// The same terms without the spaces around their comparisons: `ttc < 1.5` is `ttc<1.5`.
fn without_spaces(text: &str) -> String {
    let signs = ['<', '>', '='];
    // With a unit it is a wrong number.
    let is_number = |word: &str| word.starts_with(|c: char| c.is_ascii_digit() || "-.".contains(c));
    let mut joined = String::with_capacity(text.len());
    for word in text.split_whitespace() {
        let value = word.trim_start_matches(signs);
        let is_comparison = value != word && (value.is_empty() || is_number(value));
        let is_value = joined.ends_with(signs) && is_number(word);
        if !(joined.is_empty() || is_comparison || is_value) {
            joined.push(' ');
        }
        joined.push_str(word);
    }
    joined
}

/// Words between terms in other languages of filters.
const JOINTS: [&str; 6] = ["and", "&&", "&", "or", "||", "|"];

/// Score of a country that is named: no match of letters is better.
const OF_COUNTRY: u32 = 1000;

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

#[cfg(test)]
mod index_tests;

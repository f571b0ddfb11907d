//! What phrases mean, and which phrase the words of a sentence begin with.

use std::sync::LazyLock;

use super::phrases::PHRASES;
use super::words::{Token, stem};
use nearmiss_base::system::mistyped;
use nearmiss_scene::metrics::measure;

/// What a phrase means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Meaning {
    /// A term `key:value`; values of one key are joined.
    Term(&'static str, &'static str),
    /// Two terms at once: who stands where.
    Terms(&'static [(&'static str, &'static str)]),
    /// A whole term.
    Whole(&'static str),
    /// A name of a risk score, which needs a word such as risk beside it: its score.
    Level(u8),
    /// Risk: what levels and scores are of.
    Risk,
    /// A measure or another number, with the unit of its values.
    Measure(&'static str, Unit),
    /// How a number compares: sign, and the measure that is meant where none is named.
    Compare(&'static str, Option<&'static str>),
    /// The least or greatest value, before a measure or a number.
    Extreme(Bound),
    /// Worse than a level.
    Worse,
    /// Behind a number or level: it is included, and so is what is beyond it in this direction.
    OrMore,
    /// The same for what is below it.
    OrLess,
    /// Behind a level: and what is worse.
    OrWorse,
    /// From a number to another.
    Between,
    /// A unit: how much of the base unit it is.
    Unit(Unit, f64),
    /// Not what follows.
    Not,
    /// Joins two things.
    And,
    /// Joins alternatives.
    Or,
    /// The other is ahead of the ego: it is followed, if nothing else is said of it.
    Ahead,
    /// A quantity without a term: numbers beside it are of it.
    Foreign,
    /// Words that would be something else by themselves, without a term.
    NoTerm,
    /// The same, with what comes next: it hides another.
    NoTermOf,
    /// A key whose value is the next word.
    Key(&'static str),
    /// Nothing that narrows down.
    Filler,
}

impl Meaning {
    /// Whether it is part of a filter by itself.
    fn narrows(&self) -> bool {
        matches!(
            self,
            Self::Term(..) | Self::Terms(_) | Self::Whole(_) | Self::Measure(..)
        )
    }
}

/// Base units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Seconds.
    Seconds,
    /// Metres.
    Metres,
    /// m/s².
    Acceleration,
    /// m/s.
    Speed,
    /// Of nothing that is measured.
    Other,
    /// Without unit.
    None,
}

/// Which value of a window a measure is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// The least.
    Least,
    /// The greatest.
    Most,
    /// The most dangerous.
    Worst,
}

/// A phrase, ready to be compared.
struct Phrase {
    words: Vec<Word>,
    meaning: Meaning,
}

enum Word {
    Exact(String),
    Stem(String),
}

impl Word {
    fn is(&self, token: &Token) -> bool {
        match self {
            Self::Exact(word) => token.small == *word,
            Self::Stem(word) => token.stem == *word,
        }
    }
}

static LEXICON: LazyLock<Vec<Phrase>> = LazyLock::new(|| {
    let mut all = Vec::new();
    for (forms, meaning) in PHRASES {
        for form in forms.split('|') {
            let words = form.split(' ').map(|word| match word.strip_prefix('=') {
                Some(exact) if !exact.is_empty() => Word::Exact(exact.to_string()),
                _ => Word::Stem(stem(word)),
            });
            all.push(Phrase {
                words: words.collect(),
                meaning: *meaning,
            });
        }
    }
    all
});

/// The longest phrase at the beginning of these words, exact forms first: how many words it has and what it means.
#[must_use]
pub fn phrase(tokens: &[Token]) -> Option<(usize, Meaning)> {
    let fits = |phrase: &&Phrase| {
        phrase.words.len() <= tokens.len()
            && phrase
                .words
                .iter()
                .zip(tokens)
                .all(|(word, token)| word.is(token))
    };
    let exact = |phrase: &Phrase| phrase.words.iter().any(|w| matches!(w, Word::Exact(_)));
    let found = LEXICON.iter().filter(fits);
    // Of equal ones the first in the table.
    let best = found
        .rev()
        .max_by_key(|phrase| (phrase.words.len(), exact(phrase)))?;
    Some((best.words.len(), best.meaning))
}

/// The measure with this id, with the unit of its values.
#[must_use]
pub fn measure_of(id: &str) -> Option<Meaning> {
    let measure = measure(id)?;
    let unit = match measure.unit {
        "s" => Unit::Seconds,
        "m" => Unit::Metres,
        "m/s" => Unit::Speed,
        "m/s²" => Unit::Acceleration,
        _ => Unit::None,
    };
    Some(Meaning::Measure(measure.id, unit))
}

/// The word of the vocabulary that a mistyped one means.
#[must_use]
pub fn alike(word: &str) -> Option<&'static str> {
    let word = word.to_lowercase();
    let stem = stem(&word);
    let is_word = |known: &Word| matches!(known, Word::Stem(known) if *known == stem);
    let is_known = LEXICON
        .iter()
        .any(|phrase| phrase.words.iter().any(is_word));
    if is_known || word.chars().count() < SHORTEST {
        return None;
    }
    let known = PHRASES
        .iter()
        .filter(|(_, meaning)| meaning.narrows())
        .flat_map(|(forms, _)| forms.split('|'));
    let known: Vec<&str> = known.filter(|known| known.len() >= SHORTEST).collect();
    mistyped(&word, known)
}

/// Letters of a word that is compared with others: `rain` is no train.
const SHORTEST: usize = 5;

/// The phrases for each meaning that narrows down: words, and what they give.
#[cfg(test)]
pub fn documented() -> Vec<(String, String)> {
    let shown = PHRASES.iter().filter_map(|(forms, meaning)| {
        let gives = match meaning {
            Meaning::Term(key, value) => format!("{key}:{value}"),
            Meaning::Terms(terms) => {
                let all: Vec<String> = terms.iter().map(|(k, v)| format!("{k}:{v}")).collect();
                all.join(" ")
            }
            Meaning::Whole(term) => (*term).to_string(),
            _ => return None,
        };
        Some((forms.replace('=', "").replace('|', ", "), gives))
    });
    shown.collect()
}

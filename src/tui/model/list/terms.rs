//! Filter terms: names, conditions on a scenario, and errors.

use super::Row;
use super::group::Agreement;
use crate::metrics::{MEASURES, Measure};

/// Filter terms for help: term and meaning.
pub const TERMS: &[(&str, &str)] = &[
    (
        "tag:cut_in",
        "a tag of the file, or one of yours; a part of it is enough",
    ),
    ("country:DEU", "the country of the benchmark id"),
    ("folder:highway", "part of the folder's name"),
    (
        "has:collision",
        "also ego, answers, tags (yours), error; opposite: no:ego",
    ),
    (
        "verdict:differ",
        "stored answers against the judge: agree, differ, none",
    ),
    (
        "risk<3",
        "risk, distance (m), ttc (s), obstacles, duration (s), answers, the measure sorted by; also <= > >= =",
    ),
    ("!tag:urban", "the opposite of a term, or of a word"),
];

/// A term.
#[derive(Debug, Clone)]
pub struct Term {
    /// Its condition.
    pub test: Test,
    /// Whether the answer has to be no.
    pub negated: bool,
}

/// A condition on a scenario.
#[derive(Debug, Clone)]
pub enum Test {
    /// Whether a tag has this part, in small letters.
    Tag(String),
    /// Whether the country begins so, in capitals.
    Country(String),
    /// Whether the folder has this part, in small letters.
    Folder(String),
    /// Whether something is there (or, with `false`, known not to be).
    Has(Property, bool),
    /// Verdicts of stored answers.
    Verdict(Agreement),
    /// How a number compares.
    Number(Number, Comparison, f64),
}

/// A property that a scenario may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Property {
    /// A contact of the ego.
    Collision,
    /// An ego.
    Ego,
    /// Stored answers with a yes or no.
    Answers,
    /// Tags of the user's.
    Tags,
    /// A reason why it cannot be read.
    Error,
}

const PROPERTIES: [(&str, Property); 5] = [
    ("collision", Property::Collision),
    ("ego", Property::Ego),
    ("answers", Property::Answers),
    ("tags", Property::Tags),
    ("error", Property::Error),
];

/// A number of a scenario.
#[derive(Debug, Clone, Copy)]
pub enum Number {
    /// The most dangerous value of a measure.
    Of(&'static Measure),
    /// How many obstacles.
    Obstacles,
    /// Seconds.
    Duration,
    /// How many stored answers.
    Answers,
}

/// Comparison operators.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Comparison {
    Less,
    AtMost,
    More,
    AtLeast,
    Equal,
}

/// Longer signs first, so that `<=` is not read as `<`.
const COMPARISONS: [(&str, Comparison); 5] = [
    ("<=", Comparison::AtMost),
    (">=", Comparison::AtLeast),
    ("<", Comparison::Less),
    (">", Comparison::More),
    ("=", Comparison::Equal),
];

/// Measures that are known of every scenario that was read.
pub const HEADLINE: [&str; 3] = ["risk", "distance", "ttc"];

/// Reads a word as a term: nothing if it is none, `Ok(None)` while its value is still to be typed.
pub fn term(word: &str, sorted: Option<&'static Measure>) -> Option<Result<Option<Term>, String>> {
    let (negated, bare) = match word.strip_prefix('!') {
        Some(rest) => (true, rest),
        None => (false, word),
    };
    let test = match (bare.split_once(':'), compared(bare)) {
        (Some((key, value)), _) if !key.is_empty() => named(key, value),
        (_, Some((key, how, value))) if !key.is_empty() => number(key, how, value, sorted),
        _ => return None,
    };
    Some(test.map(|test| test.map(|test| Term { test, negated })))
}

fn compared(word: &str) -> Option<(&str, Comparison, &str)> {
    let at = word.find(['<', '>', '='])?;
    let (key, rest) = word.split_at(at);
    let mut signs = COMPARISONS.iter();
    signs.find_map(|(sign, how)| Some((key, *how, rest.strip_prefix(sign)?)))
}

fn named(key: &str, value: &str) -> Result<Option<Test>, String> {
    let small = value.to_lowercase();
    let thing = |there: bool| match PROPERTIES.iter().find(|(name, _)| *name == small) {
        Some((_, thing)) => Ok(Some(Test::Has(*thing, there))),
        // Still being typed.
        None if PROPERTIES.iter().any(|(name, _)| name.starts_with(&small)) => Ok(None),
        None => Err(unknown(
            key,
            value,
            PROPERTIES.iter().map(|(name, _)| *name),
        )),
    };
    match key {
        "tag" => Ok((!small.is_empty()).then_some(Test::Tag(small))),
        "country" => Ok((!small.is_empty()).then(|| Test::Country(value.to_uppercase()))),
        "folder" => Ok((!small.is_empty()).then_some(Test::Folder(small))),
        "has" => thing(true),
        "no" => thing(false),
        "verdict" => match small.as_str() {
            "agree" => Ok(Some(Test::Verdict(Agreement::Agree))),
            "differ" | "disagree" => Ok(Some(Test::Verdict(Agreement::Differ))),
            "none" => Ok(Some(Test::Verdict(Agreement::Nothing))),
            part if VERDICTS.iter().any(|word| word.starts_with(part)) => Ok(None),
            _ => Err(unknown(key, value, VERDICTS.into_iter())),
        },
        _ => Err(format!(
            "`{key}:` is no term; there are tag: country: folder: has: no: verdict:"
        )),
    }
}

const VERDICTS: [&str; 4] = ["agree", "differ", "disagree", "none"];

fn unknown<'a>(key: &str, value: &str, known: impl Iterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.collect();
    format!("`{key}:` knows no `{value}`, but {}", known.join(", "))
}

fn number(
    key: &str,
    how: Comparison,
    value: &str,
    sorted: Option<&'static Measure>,
) -> Result<Option<Test>, String> {
    let measure = MEASURES.iter().find(|m| m.id == key);
    let number = match (key, measure) {
        ("obstacles", _) => Number::Obstacles,
        ("duration", _) => Number::Duration,
        ("answers", _) => Number::Answers,
        (_, Some(m)) if HEADLINE.contains(&key) || sorted.is_some_and(|s| s.id == key) => {
            Number::Of(m)
        }
        (_, Some(_)) => {
            return Err(format!(
                "`{key}` is known only while the list is sorted by it: s sorts"
            ));
        }
        (_, None) => {
            return Err(format!(
                "`{key}` is no number of a scenario; there are risk, distance, ttc, obstacles, duration, answers"
            ));
        }
    };
    if value.is_empty() || value == "-" {
        return Ok(None);
    }
    match value.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(Some(Test::Number(number, how, value))),
        _ => Err(format!("`{value}` is no number to compare {key} with")),
    }
}

impl Test {
    /// Whether it needs facts known only after a scenario was read.
    pub fn needs_facts(&self) -> bool {
        !matches!(self, Self::Folder(_) | Self::Has(Property::Tags, _))
    }

    /// Whether a scenario is so; what is not known yet is not.
    pub fn holds(&self, row: &Row) -> bool {
        match self {
            Self::Tag(part) => row.tags().any(|tag| tag.to_lowercase().contains(part)),
            Self::Country(start) => row.country().starts_with(start.as_str()),
            Self::Folder(part) => row.entry.group.to_lowercase().contains(part),
            Self::Has(thing, there) => has(row, *thing) == Some(*there),
            Self::Verdict(wanted) => row.agreement() == Some(*wanted),
            Self::Number(number, how, value) => match (number.of(row), how) {
                (None, _) => false,
                (Some(x), Comparison::Less) => x < *value,
                (Some(x), Comparison::AtMost) => x <= *value,
                (Some(x), Comparison::More) => x > *value,
                (Some(x), Comparison::AtLeast) => x >= *value,
                (Some(x), Comparison::Equal) => x == *value,
            },
        }
    }
}

/// Whether a scenario has it; `None` while that is not known.
fn has(row: &Row, thing: Property) -> Option<bool> {
    match thing {
        Property::Tags => Some(!row.own_tags.is_empty()),
        Property::Error => Some(row.facts.as_ref()?.is_err()),
        Property::Answers => Some(row.facts()?.tally().count() > 0),
        Property::Ego => Some(row.facts()?.headline.is_some()),
        Property::Collision => Some(row.facts()?.headline.as_ref().is_some_and(|h| h.collides())),
    }
}

impl Number {
    fn of(self, row: &Row) -> Option<f64> {
        match self {
            Self::Of(measure) => row.value_of(measure).flatten(),
            Self::Obstacles => Some(row.facts()?.obstacles as f64),
            Self::Duration => Some(row.facts()?.seconds),
            Self::Answers => Some(f64::from(row.facts()?.tally().count())),
        }
    }
}

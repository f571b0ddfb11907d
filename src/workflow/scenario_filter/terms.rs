//! Filter terms: names, conditions on a scenario, and errors.

use super::facts::country_codes;
use super::index_terms::WindowTest;
use super::{Agreement, Filterable};
use nearmiss_scene::metrics::{Measure, measure};

/// Filter terms for help: term and meaning.
pub const TERMS: &[(&str, &str)] = &[
    (
        "tag:cut_in",
        "a tag of the file, or one of yours; a part of it is enough",
    ),
    (
        "country:DEU,USA",
        "country of the benchmark id, or its name; also just germany",
    ),
    ("folder:highway", "part of the folder's name"),
    (
        "has:collision",
        "also ego, answers, tags (yours), error, index; opposite: no:ego",
    ),
    (
        "verdict:differ",
        "stored answers against the judge: agree, differ, none",
    ),
    (
        "risk<3",
        "risk, distance (m), ttc (s), obstacles, duration (s), answers, the measure sorted by; also <= > >= =",
    ),
    (
        "road:urban",
        "windows of an index: also manoeuvre:cut_in,merging, actor:truck, severity<=1; one window fits all",
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
    /// Whether the country begins so, in capitals, or is one of these; one of several such conditions holds.
    Country(Vec<(String, Vec<&'static str>)>),
    /// Whether the folder has this part, in small letters.
    Folder(String),
    /// Whether something is there (or, with `false`, known not to be).
    Has(Property, bool),
    /// Verdicts of stored answers.
    Verdict(Agreement),
    /// What a window of an index is.
    Window(WindowTest),
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
    /// Windows in the index.
    Index,
}

const PROPERTIES: [(&str, Property); 6] = [
    ("collision", Property::Collision),
    ("ego", Property::Ego),
    ("answers", Property::Answers),
    ("tags", Property::Tags),
    ("error", Property::Error),
    ("index", Property::Index),
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

/// The measures whose values are known, beside [`HEADLINE`].
#[derive(Debug, Clone, Copy)]
pub enum Measures {
    /// The one that the list is sorted by.
    Sorted(Option<&'static Measure>),
    /// Every one, as far as an index has it.
    All,
}

impl Measures {
    fn has(self, measure: &Measure) -> bool {
        match self {
            Self::Sorted(sorted) => sorted.is_some_and(|s| s.id == measure.id),
            Self::All => true,
        }
    }
}

/// Reads a word as a term: nothing if it is none, `Ok(None)` while its value is still to be typed.
pub fn term(word: &str, measures: Measures) -> Option<Result<Option<Term>, String>> {
    let (negated, bare) = match word.strip_prefix('!') {
        Some(rest) => (true, rest),
        None => (false, word),
    };
    let test = match (bare.split_once(':'), compared(bare)) {
        (Some((key, value)), _) if !key.is_empty() => named(key, value),
        (_, Some((key, how, value))) if !key.is_empty() => number(key, how, value, measures),
        _ => return None,
    };
    Some(test.map(|test| test.map(|test| Term { test, negated })))
}

pub(super) fn compared(word: &str) -> Option<(&str, Comparison, &str)> {
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
        "country" => {
            let named = value
                .split(',')
                .filter(|name| !name.is_empty())
                .map(|name| (name.to_uppercase(), country_codes(name)));
            let test = || Test::Country(named.collect());
            Ok((!small.is_empty()).then(test))
        }
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
        _ => match WindowTest::read(key, value) {
            Some(test) => test.map(|test| test.map(Test::Window)),
            None => Err(format!(
                "unknown filter `{key}:`; available: tag: country: folder: has: no: verdict: manoeuvre: actor: road: severity:"
            )),
        },
    }
}

const VERDICTS: [&str; 4] = ["agree", "differ", "disagree", "none"];

fn unknown<'a>(key: &str, value: &str, known: impl Iterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.collect();
    format!(
        "unknown value `{value}` of `{key}:`; available: {}",
        known.join(", ")
    )
}

fn number(
    key: &str,
    how: Comparison,
    value: &str,
    measures: Measures,
) -> Result<Option<Test>, String> {
    if key == "severity" {
        let test = |score| Test::Window(WindowTest::Compared(how, score));
        return Ok(number_in(key, value)?.map(test));
    }
    let number = match (key, measure(key)) {
        ("obstacles", _) => Number::Obstacles,
        ("duration", _) => Number::Duration,
        ("answers", _) => Number::Answers,
        (_, Some(m)) if HEADLINE.contains(&key) || measures.has(m) => Number::Of(m),
        (_, Some(_)) => {
            return Err(format!("filtering by `{key}` needs the list sorted by it"));
        }
        (_, None) => {
            let first = ["risk", "distance", "ttc"];
            let known = ["obstacles", "duration", "answers", "severity"];
            let all = nearmiss_scene::metrics::measures().map(|m| m.id);
            let others = all.filter(move |id| !first.contains(id));
            let all = first.into_iter().chain(known).chain(others);
            return Err(nearmiss_base::system::unknown("number", key, all));
        }
    };
    Ok(number_in(key, value)?.map(|value| Test::Number(number, how, value)))
}

/// The number behind a comparison; nothing while it is still to be typed.
pub(super) fn number_in(key: &str, value: &str) -> Result<Option<f64>, String> {
    if value.is_empty() || value == "-" {
        return Ok(None);
    }
    match value.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(Some(value)),
        _ if key == "severity" => Err(format!(
            "`{value}` is not a number; write severity:{value} or severity<3"
        )),
        _ => Err(format!("`{value}` is not a number; write {key}<3")),
    }
}

impl Comparison {
    /// Whether a number compares so.
    pub fn holds(self, number: f64, value: f64) -> bool {
        match self {
            Self::Less => number < value,
            Self::AtMost => number <= value,
            Self::More => number > value,
            Self::AtLeast => number >= value,
            Self::Equal => number == value,
        }
    }
}

impl Test {
    /// Whether it needs facts known only after a scenario was read.
    pub fn needs_facts(&self) -> bool {
        !matches!(self, Self::Folder(_) | Self::Has(Property::Tags, _))
    }

    /// The word for it where it is about the answers or tags of one user.
    pub fn personal(&self) -> Option<&'static str> {
        match self {
            Self::Verdict(_) => Some("verdict:"),
            Self::Has(Property::Answers, _) => Some("has:answers"),
            Self::Has(Property::Tags, _) => Some("has:tags"),
            Self::Number(Number::Answers, ..) => Some("answers"),
            _ => None,
        }
    }

    /// The word for it where an index is needed.
    pub fn of_index(&self) -> Option<&'static str> {
        match self {
            Self::Window(test) => Some(test.key()),
            Self::Has(Property::Index, true) => Some("has:index"),
            Self::Has(Property::Index, false) => Some("no:index"),
            _ => None,
        }
    }

    /// Whether a scenario is so; what is not known yet is not.
    pub fn holds(&self, row: &impl Filterable) -> bool {
        match self {
            Self::Tag(part) => row.tags().any(|tag| tag.to_lowercase().contains(part)),
            Self::Country(named) => {
                let country = row.country();
                named.iter().any(|(start, codes)| {
                    country.starts_with(start.as_str()) || codes.contains(&country)
                })
            }
            Self::Folder(part) => row.entry().group.to_lowercase().contains(part),
            Self::Has(thing, there) => row.has(*thing) == Some(*there),
            Self::Verdict(wanted) => row.agreement() == Some(*wanted),
            Self::Number(number, how, value) => {
                let number = row.number(*number);
                number.is_some_and(|number| how.holds(number, *value))
            }
            // All of these are held against one window together.
            Self::Window(_) => true,
        }
    }
}

//! Filter terms about the windows that an index of a corpus has of a scenario.

use super::Filterable;
use super::terms::{Comparison, Test};
use nearmiss_scene::corpus::{CellWindows, Manoeuvre, RoadType};
use nearmiss_scene::metrics::SEVERITY_NAMES;
use nearmiss_scene::scenario::ObstacleType;

/// The word for the most severe ones: contact, conflict and near miss.
const CRITICAL_WORD: &str = "critical";

/// How many these are.
const CRITICAL: usize = 3;

/// Places in a list of words: several are meant where a term names several.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AnyOf(u32);

impl AnyOf {
    pub(super) fn one(place: usize) -> Self {
        Self(1 << place)
    }

    pub(super) fn has(self, place: usize) -> bool {
        self.0 & (1 << place) != 0
    }
}

/// A condition on a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WindowTest {
    /// What the obstacle does: one of these.
    Manoeuvre(AnyOf),
    /// The obstacle's type.
    Actor(AnyOf),
    /// The road under the ego.
    Road(AnyOf),
    /// The severity.
    Severity(AnyOf),
    /// How the severity compares.
    Compared(Comparison, f64),
}

/// The word of a type of obstacle in filters: `priority_vehicle`.
#[must_use]
fn actor_word(kind: ObstacleType) -> String {
    let mut word = String::new();
    for letter in kind.name().chars() {
        if letter.is_ascii_uppercase() {
            word.push('_');
        }
        word.push(letter.to_ascii_lowercase());
    }
    word
}

fn actor_words() -> Vec<String> {
    ObstacleType::ALL.iter().map(|k| actor_word(*k)).collect()
}

fn severity_words() -> [String; SEVERITY_NAMES.len()] {
    SEVERITY_NAMES.map(|name| name.replace(' ', "_"))
}

/// The terms about windows, and their values.
pub fn window_values() -> [(&'static str, Vec<String>); 4] {
    let owned = |word: &str| word.to_string();
    [
        ("manoeuvre:", Manoeuvre::ALL.map(|m| owned(m.name())).into()),
        ("actor:", actor_words()),
        ("road:", RoadType::ALL.map(|r| owned(r.name())).into()),
        (
            "severity:",
            severity_words()
                .into_iter()
                .chain([owned(CRITICAL_WORD)])
                .collect(),
        ),
    ]
}

/// A word and the places that it means.
pub(super) type Known<'a> = (&'a str, AnyOf);

impl WindowTest {
    /// Reads a term such as `road:urban` or `manoeuvre:cut_in,merging`: `None` for another key, `Ok(None)` while its
    /// value is still to be typed.
    pub fn read(key: &str, value: &str) -> Option<Result<Option<Self>, String>> {
        Some(match key {
            "manoeuvre" | "maneuver" => {
                let words = Manoeuvre::ALL.map(Manoeuvre::name);
                parse_value(key, value, &in_order(&words)).map(|any| any.map(Self::Manoeuvre))
            }
            "actor" => {
                let words = actor_words();
                let words: Vec<&str> = words.iter().map(String::as_str).collect();
                parse_value(key, value, &in_order(&words)).map(|any| any.map(Self::Actor))
            }
            "road" => {
                let words = RoadType::ALL.map(RoadType::name);
                parse_value(key, value, &in_order(&words)).map(|any| any.map(Self::Road))
            }
            "severity" => {
                let names = severity_words();
                let digits: Vec<String> = (0..names.len()).map(|n| n.to_string()).collect();
                let words = names.iter().chain(&digits).map(String::as_str);
                let places = (0..names.len()).chain(0..names.len()).map(AnyOf::one);
                let critical = (CRITICAL_WORD, AnyOf((1 << CRITICAL) - 1));
                let known: Vec<Known<'_>> = words.zip(places).chain([critical]).collect();
                parse_value(key, value, &known).map(|any| any.map(Self::Severity))
            }
            _ => return None,
        })
    }

    /// The key of the term.
    pub fn key(self) -> &'static str {
        match self {
            Self::Manoeuvre(_) => "manoeuvre:",
            Self::Actor(_) => "actor:",
            Self::Road(_) => "road:",
            Self::Severity(_) | Self::Compared(..) => "severity",
        }
    }

    /// Whether a window is so.
    pub fn holds(self, window: &CellWindows) -> bool {
        match self {
            Self::Manoeuvre(any) => any.has(place(&Manoeuvre::ALL, &window.manoeuvre)),
            Self::Actor(any) => any.has(place(&ObstacleType::ALL, &window.actor)),
            Self::Road(any) => any.has(place(&RoadType::ALL, &window.road)),
            Self::Severity(any) => any.has(usize::from(window.severity)),
            Self::Compared(how, score) => how.holds(f64::from(window.severity), score),
        }
    }
}

pub(super) fn place<T: PartialEq>(all: &[T], one: &T) -> usize {
    all.iter().position(|known| known == one).unwrap_or(0)
}

pub(super) fn in_order<'a>(words: &[&'a str]) -> Vec<Known<'a>> {
    let places = words.iter().enumerate();
    places.map(|(at, word)| (*word, AnyOf::one(at))).collect()
}

/// What the words of a value mean, which are separated by commas; the last may be half typed.
pub(super) fn parse_value(
    key: &str,
    value: &str,
    known: &[Known<'_>],
) -> Result<Option<AnyOf>, String> {
    let mut all = AnyOf(0);
    let mut waits = false;
    for part in value.split(',') {
        let small = part.to_lowercase().replace('-', "_");
        let found = known.iter().find(|(word, _)| *word == small);
        match found {
            Some((_, any)) => all.0 |= any.0,
            None if known.iter().any(|(word, _)| word.starts_with(&small)) => waits = true,
            None => {
                let words = known.iter().map(|(word, _)| *word);
                let words: Vec<&str> = words.filter(|w| w.len() > 1).collect();
                return Err(format!(
                    "unknown value `{part}` of `{key}:`; available: {}",
                    words.join(", ")
                ));
            }
        }
    }
    Ok((!waits).then_some(all))
}

/// Whether the windows of a scenario are as the terms want: one of them satisfies all plain terms, and none satisfies a
/// negated one. A scenario that the index does not have is held back.
pub fn windows_hold(tests: &[(WindowTest, bool)], row: &impl Filterable) -> bool {
    if tests.is_empty() {
        return true;
    }
    let Some(windows) = row.indexed().windows() else {
        return false;
    };
    some_window_holds(tests, windows)
}

/// The same of these windows.
pub fn some_window_holds(tests: &[(WindowTest, bool)], windows: &[CellWindows]) -> bool {
    let of = |negated: bool| tests.iter().filter(move |(_, no)| *no == negated);
    let any_unwanted = windows
        .iter()
        .any(|window| of(true).any(|(test, _)| test.holds(window)));
    let plain = of(false).count();
    let has_wanted = windows
        .iter()
        .any(|window| of(false).all(|(test, _)| test.holds(window)));
    !any_unwanted && (plain == 0 || has_wanted)
}

/// The test about windows in a term, if it is one.
pub fn window_test(test: &Test) -> Option<WindowTest> {
    match test {
        Test::Window(test) => Some(*test),
        _ => None,
    }
}

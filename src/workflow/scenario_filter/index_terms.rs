//! Filter terms about the windows that an index of a corpus has of a scenario.

use super::Filterable;
use super::terms::{Comparison, Test};
use crate::corpus::{CellWindows, Manoeuvre, RoadType};
use crate::metrics::RISK_LEVELS;

/// Most severe risk scores that `severity:critical` means: collision and extreme.
const CRITICAL: f64 = 1.0;

/// A condition on a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WindowTest {
    /// What the obstacle does.
    Manoeuvre(Manoeuvre),
    /// The road under the ego.
    Road(RoadType),
    /// How the worst risk score compares.
    Severity(Comparison, f64),
}

impl WindowTest {
    /// Reads a term such as `road:urban`: `None` for another key, `Ok(None)` while its value is still to be typed.
    pub fn read(key: &str, value: &str) -> Option<Result<Option<Self>, String>> {
        Some(match key {
            "manoeuvre" | "maneuver" => {
                let known = Manoeuvre::ALL.map(|one| (one.name(), Self::Manoeuvre(one)));
                value_of(key, value, &known)
            }
            "road" => {
                let known = RoadType::ALL.map(|one| (one.name(), Self::Road(one)));
                value_of(key, value, &known)
            }
            "severity" => {
                let levels = RISK_LEVELS.levels.iter();
                let levels = levels.map(|level| {
                    let score = Self::Severity(Comparison::Equal, f64::from(level.score));
                    (level.name.as_str(), score)
                });
                let critical = Self::Severity(Comparison::AtMost, CRITICAL);
                let mut known: Vec<_> = levels.collect();
                known.push(("critical", critical));
                match value.parse::<u8>() {
                    Ok(score) if RISK_LEVELS.level(score).is_some() => {
                        Ok(Some(Self::Severity(Comparison::Equal, f64::from(score))))
                    }
                    _ => value_of(key, value, &known),
                }
            }
            _ => return None,
        })
    }

    /// The key of the term.
    pub fn key(self) -> &'static str {
        match self {
            Self::Manoeuvre(_) => "manoeuvre:",
            Self::Road(_) => "road:",
            Self::Severity(..) => "severity",
        }
    }

    fn holds(self, window: &CellWindows) -> bool {
        match self {
            Self::Manoeuvre(wanted) => window.manoeuvre == wanted,
            Self::Road(wanted) => window.road == wanted,
            Self::Severity(how, score) => how.holds(f64::from(window.severity), score),
        }
    }
}

/// The test of a word, which may be half typed.
fn value_of(
    key: &str,
    value: &str,
    known: &[(&str, WindowTest)],
) -> Result<Option<WindowTest>, String> {
    let small = value.to_lowercase().replace('-', "_");
    if let Some((_, test)) = known.iter().find(|(word, _)| *word == small) {
        return Ok(Some(*test));
    }
    if known.iter().any(|(word, _)| word.starts_with(&small)) {
        return Ok(None);
    }
    let words: Vec<&str> = known.iter().map(|(word, _)| *word).collect();
    Err(format!(
        "unknown value `{value}` of `{key}:`; available: {}",
        words.join(", ")
    ))
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

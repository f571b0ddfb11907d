//! The unit of intervals and comparisons: a scenario, or a map with all its scenarios.

use std::fmt;
use std::str::FromStr;

use nearmiss_scene::scenario::identity;

/// What is drawn, and what differs, as a whole: answers about one are not independent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Cluster {
    /// A scenario with all its windows and samples.
    #[default]
    Scenario,
    /// A map, or a long recording, with all its scenarios: the unit of [`Split`](super::batch::Split), too.
    Map,
}

impl Cluster {
    /// The unit that a scenario is of.
    #[must_use]
    pub fn of(self, scenario: &str) -> &str {
        match self {
            Self::Scenario => scenario,
            Self::Map => identity::family(scenario),
        }
    }
}

/// `scenario` or `map`.
impl FromStr for Cluster {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let found = [Self::Scenario, Self::Map]
            .into_iter()
            .find(|one| one.to_string() == word);
        found.ok_or_else(|| "expected scenario or map".into())
    }
}

/// The same words.
impl fmt::Display for Cluster {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Scenario => "scenario",
            Self::Map => "map",
        })
    }
}

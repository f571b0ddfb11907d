//! One scenario of the list, with its facts.

use super::group::Agreement;
use super::terms::HEADLINE;
use crate::formats::Entry;
use crate::metrics::{Headline, Measure, Nearest};
use crate::tui::loaded::{Facts, country_of};

/// A scenario in the list.
#[derive(Debug)]
pub struct Row {
    /// The scenario.
    pub entry: Entry,
    /// Its facts, once known.
    pub facts: Option<Result<Facts, String>>,
    /// The most dangerous value of the measure by which the list is sorted; the outer one is whether it is known.
    pub value: Option<Option<f64>>,
    /// The user's own tags.
    pub own_tags: Vec<String>,
    /// Its place in the list as it was found.
    pub rank: usize,
}

impl Row {
    /// A scenario of which nothing is known yet.
    #[must_use]
    pub fn new(entry: Entry, rank: usize) -> Self {
        Self {
            entry,
            facts: None,
            value: None,
            own_tags: Vec::new(),
            rank,
        }
    }

    /// Its facts, if it could be read.
    #[must_use]
    pub fn facts(&self) -> Option<&Facts> {
        self.facts.as_ref()?.as_ref().ok()
    }

    /// Its tags: the file's, then the user's.
    pub fn tags(&self) -> impl Iterator<Item = &str> {
        let of_file = self.facts().into_iter().flat_map(|facts| &facts.tags);
        of_file.chain(&self.own_tags).map(String::as_str)
    }

    /// Three letters for its country: by its benchmark id, before it was read by its name; may be empty.
    #[must_use]
    pub fn country(&self) -> &str {
        match self.facts() {
            Some(facts) if !facts.country.is_empty() => &facts.country,
            _ => country_of(&self.entry.name),
        }
    }

    /// The verdicts of stored answers; `None` until they are read.
    #[must_use]
    pub fn agreement(&self) -> Option<Agreement> {
        let tally = match self.facts.as_ref()? {
            Ok(facts) => facts.tally(),
            Err(_) => return Some(Agreement::Nothing),
        };
        Some(match (tally.differ, tally.agree) {
            (0, 0) => Agreement::Nothing,
            (0, _) => Agreement::Agree,
            _ => Agreement::Differ,
        })
    }

    /// The most dangerous value of a measure; the outer one is whether it is known.
    #[must_use]
    pub fn value_of(&self, measure: &Measure) -> Option<Option<f64>> {
        if !HEADLINE.contains(&measure.id) {
            return self.value;
        }
        let Ok(facts) = self.facts.as_ref()? else {
            return Some(None);
        };
        let headline = facts.headline.as_ref();
        let nearest = headline.and_then(|headline| nearest(headline, measure));
        Some(nearest.map(|n| n.value))
    }
}

/// The most dangerous value of one of the measures [`HEADLINE`].
#[must_use]
pub fn nearest(headline: &Headline, measure: &Measure) -> Option<Nearest> {
    match measure.id {
        "risk" => headline.risk,
        "distance" => headline.distance,
        _ => headline.ttc,
    }
}

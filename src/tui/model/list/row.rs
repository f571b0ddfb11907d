//! One scenario of the list, with its facts.

use crate::loaded::{Facts, country_code};
use nearmiss_formats::Entry;
use nearmiss_scene::corpus::CorpusIndex;
use nearmiss_scene::metrics::Measure;
use nearmiss_workflow::{Agreement, Filterable, HEADLINE, Indexed, Number, Property, nearest};

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
    /// What the index says of it.
    pub indexed: Indexed,
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
            indexed: Indexed::Unknown,
            rank,
        }
    }

    /// Looks it up in an index, once it was read.
    pub fn look_up(&mut self, index: Option<&CorpusIndex>) {
        self.indexed = match (index, &self.facts) {
            (Some(index), Some(Ok(facts))) => index.find(&facts.hash, &self.entry.name).into(),
            (Some(_), Some(Err(_))) => Indexed::Missing,
            (None, _) | (_, None) => Indexed::Unknown,
        };
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
            _ => country_code(&self.entry.name),
        }
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

impl Filterable for Row {
    fn entry(&self) -> &Entry {
        &self.entry
    }

    fn tags(&self) -> impl Iterator<Item = &str> {
        Self::tags(self)
    }

    fn country(&self) -> &str {
        Self::country(self)
    }

    fn has(&self, property: Property) -> Option<bool> {
        match property {
            Property::Tags => Some(!self.own_tags.is_empty()),
            Property::Error => Some(self.facts.as_ref()?.is_err()),
            Property::Index => match self.indexed {
                Indexed::Unknown => None,
                Indexed::Windows(_) => Some(true),
                Indexed::Changed | Indexed::Missing => Some(false),
            },
            property => self.facts()?.has(property),
        }
    }

    fn agreement(&self) -> Option<Agreement> {
        match self.facts.as_ref()? {
            Ok(facts) => Some(facts.agreement()),
            Err(_) => Some(Agreement::Nothing),
        }
    }

    fn number(&self, number: Number) -> Option<f64> {
        match number {
            Number::Of(measure) => self.value_of(measure).flatten(),
            number => self.facts()?.number(number),
        }
    }

    fn indexed(&self) -> &Indexed {
        &self.indexed
    }
}

//! Selects the scenarios of an experiment with a filter, the same ones on every machine.

use rayon::prelude::*;

use super::country_of;
use super::{
    Agreement, Facts, Filter, Filterable, Indexed, Matching, Number, Property, Verdicts, WordMatch,
};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::metrics::Thresholds;

/// A filter that selects the same scenarios for every user: stored answers and tags of users do not count.
#[derive(Debug, Clone)]
pub struct Selector(Filter);

/// A scenario with its facts, where the filter needs them.
struct Candidate<'a> {
    entry: &'a Entry,
    facts: Option<Result<Facts, String>>,
}

impl Selector {
    /// Reads a filter of the list.
    ///
    /// # Errors
    /// A term is wrong or incomplete, or depends on stored answers, on the user's own tags or on an index.
    pub fn read(text: &str) -> Result<Self, String> {
        let filter = Filter::read(text, None);
        if let Some(why) = filter.wrong.first() {
            return Err(why.clone());
        }
        if filter.incomplete {
            return Err(format!("`{text}`: a term has no value"));
        }
        if let Some(term) = filter.index_term() {
            return Err(format!(
                "`{term}` depends on an index on this machine, so others would ask about other scenarios; \
                 `nearmiss corpus sample INDEX --format toml` writes scenarios of an index into an experiment file"
            ));
        }
        if let Some(term) = filter.personal() {
            return Err(format!(
                "`{term}` depends on your stored answers or tags, so others would ask about other scenarios"
            ));
        }
        if filter.filters() {
            Ok(Self(filter))
        } else {
            Err("expected a filter such as tag:cut_in".into())
        }
    }

    /// The scenarios that the filter lets through, in their order. Words have to be parts of names, folders or tags.
    ///
    /// # Errors
    /// None is left.
    pub fn select(
        &self,
        entries: Vec<Entry>,
        thresholds: &Thresholds,
    ) -> Result<Vec<Entry>, String> {
        let verdicts = Verdicts::default();
        let is_selected = |matching: &mut Matching, entry: &Entry| {
            let facts = self.0.needs_facts() || self.0.has_words();
            let facts =
                facts.then(|| Facts::read(entry, &EgoSelection::Beside, thresholds, &verdicts));
            let candidate = Candidate { entry, facts };
            self.0
                .score(&candidate, WordMatch::Part, matching)
                .is_some()
        };
        let selected: Vec<bool> = entries
            .par_iter()
            .map_init(Matching::default, is_selected)
            .collect();
        let all = entries.len();
        let kept = entries.into_iter().zip(selected);
        let kept: Vec<Entry> = kept
            .filter_map(|(entry, selected)| selected.then_some(entry))
            .collect();
        if kept.is_empty() {
            Err(format!("the filter lets none of {all} scenarios through"))
        } else {
            Ok(kept)
        }
    }
}

impl Candidate<'_> {
    fn known(&self) -> Option<&Facts> {
        self.facts.as_ref()?.as_ref().ok()
    }
}

impl Filterable for Candidate<'_> {
    fn entry(&self) -> &Entry {
        self.entry
    }

    fn tags(&self) -> impl Iterator<Item = &str> {
        let tags = self.known().into_iter().flat_map(|facts| &facts.tags);
        tags.map(String::as_str)
    }

    fn country(&self) -> &str {
        match self.known() {
            Some(facts) if !facts.country.is_empty() => &facts.country,
            _ => country_of(&self.entry.name),
        }
    }

    fn has(&self, property: Property) -> Option<bool> {
        match property {
            Property::Error => Some(self.facts.as_ref()?.is_err()),
            property => self.known()?.has(property),
        }
    }

    fn agreement(&self) -> Option<Agreement> {
        None
    }

    fn number(&self, number: Number) -> Option<f64> {
        self.known()?.number(number)
    }

    fn indexed(&self) -> &Indexed {
        // Terms that would look are refused.
        &Indexed::Unknown
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_formats::bundled;

    fn names(filter: &str) -> Result<Vec<String>, String> {
        let selected = Selector::read(filter)?.select(bundled(), Thresholds::shipped())?;
        Ok(selected.into_iter().map(|entry| entry.name).collect())
    }

    #[test]
    fn a_filter_selects_what_the_list_would_show() {
        let all = bundled().len();
        assert_eq!(names("CutIn").unwrap(), ["ZAM_CutIn-1_1_T-1"]);
        assert_eq!(names("country:ZAM").unwrap().len(), all);
        let (hit, free) = (
            names("has:collision").unwrap(),
            names("no:collision").unwrap(),
        );
        assert_eq!(hit.len() + free.len(), all);
        assert!(!hit.is_empty() && !free.is_empty());
        assert_eq!(
            names("risk<1").unwrap(),
            names("has:collision risk<1").unwrap()
        );
        assert!(names("zzz").unwrap_err().contains("none of"));
    }

    #[test]
    fn what_depends_on_the_user_is_refused() {
        for (filter, why) in [
            ("verdict:differ", "verdict:"),
            ("has:answers", "has:answers"),
            ("!has:tags", "has:tags"),
            ("answers>3", "answers"),
            ("tga:cut_in", "unknown filter"),
            ("manoeuvre:cut_in", "depends on an index"),
            ("!severity<=1", "sample INDEX --format toml"),
            ("no:index", "no:index"),
            ("risk<", "no value"),
            (" ", "expected a filter"),
        ] {
            let said = Selector::read(filter).unwrap_err();
            assert!(said.contains(why), "{filter}: {said}");
        }
    }
}

//! Selects the scenarios of an experiment with a filter, the same ones on every machine; a model may write its terms.

use std::path::Path;

use nearmiss_ask::llm::{Message, Request, Role};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::corpus::IndexError;
use nearmiss_scene::metrics::{Measure, Thresholds};
use nearmiss_store::{Store, StoreError};
use nearmiss_study::evaluation::ModelJudge;
use rayon::prelude::*;

use super::{
    Agreement, Facts, Filter, Filterable, Indexed, Matching, Number, Property, TERMS, Verdicts,
    WordMatch, country_code, window_values,
};
use crate::ask::{TextError, TextQuestion};
use crate::listing::{checked_filter, index_measures};

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
            _ => country_code(&self.entry.name),
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

/// A sentence, and who writes its terms.
#[derive(Debug)]
pub struct FilterRequest<'a> {
    /// What is looked for, in words.
    pub sentence: &'a str,
    /// Folder of the index whose measures there are.
    pub index: &'a Path,
    /// The model.
    pub model: &'a ModelJudge,
    /// The store for its answer, also searched for an existing one.
    pub store: &'a Store,
}

/// The terms of a sentence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenFilter {
    /// The filter, checked.
    pub filter: String,
    /// What of the sentence has no term, as the model says.
    pub left_out: Option<String>,
}

/// Why a sentence has no terms.
#[derive(Debug, thiserror::Error)]
pub enum FilterError {
    /// The index cannot be read.
    #[error(transparent)]
    Index(#[from] IndexError),
    /// The model was not asked, or did not answer.
    #[error("{0}")]
    NoAnswer(String),
    /// It wrote something else.
    #[error("{model} wrote no filter: {why}; its answer: {answer}")]
    NoFilter {
        /// The model.
        model: String,
        /// What is wrong with it.
        why: String,
        /// What it wrote, unfiltered.
        answer: String,
    },
    /// The store refused.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// Asks for the terms of a sentence, once; terms that the store has of the same sentence, model and measures cost nothing.
///
/// # Errors
/// See [`FilterError`].
pub async fn write_filter(request: FilterRequest<'_>) -> Result<WrittenFilter, FilterError> {
    let FilterRequest {
        sentence,
        index,
        model,
        store,
    } = request;
    let question = Request {
        model: model.name.clone(),
        messages: vec![
            Message::new(Role::System, instructions(&index_measures(index)?)),
            Message::new(Role::User, sentence),
        ],
        parameters: model.parameters,
        schema: None,
        tools: None,
    };
    let question = TextQuestion::new(model, question, 0);
    // An answer that is no filter is not worth keeping to.
    if let Some(Ok(text)) = question.stored(store)?
        && let Ok(found) = written(&text)
    {
        return Ok(found);
    }
    let (text, _) = question.ask(store).await.map_err(|error| match error {
        TextError::Stopped(why) => FilterError::NoAnswer(why),
        TextError::Failed(why) => FilterError::NoAnswer(format!("{}: {why}", model.id)),
        TextError::Store(error) => FilterError::Store(error),
    })?;
    let text = text.map_err(|why| FilterError::NoAnswer(format!("{}: {why}", model.id)))?;
    written(&text).map_err(|why| FilterError::NoFilter {
        model: model.id.clone(),
        why,
        answer: text.trim().to_string(),
    })
}

/// What the line of what has no term begins with.
const LEFT_OUT: &str = "left out:";

/// What the model is told.
fn instructions(measures: &[&Measure]) -> String {
    let terms = TERMS.iter();
    let terms: String = terms
        .map(|(term, meaning)| format!("- {term} — {meaning}\n"))
        .collect();
    let values: String = window_values()
        .map(|(key, values)| format!("- {key} {}\n", values.join(", ")))
        .concat();
    let measures: String = measures
        .iter()
        .map(|measure| match measure.unit {
            "" => format!("- {}: {}\n", measure.id, measure.name),
            unit => format!("- {}: {}, {unit}\n", measure.id, measure.name),
        })
        .collect();
    format!(
        "You translate a sentence about driving into a filter. It selects windows of about 2 s of an ego and another road \
         user. A filter is a list of terms, separated by spaces; a window has to fit all of them. Within a term, values \
         separated by commas are alternatives. The terms are\n\n{terms}\n\
         The values of the terms about windows, of the other road user (following: the ego follows it, followed: it follows \
         the ego), of the road under the ego, and of the most severe step:\n\n{values}\n\
         The measures, each compared like risk in risk<3; a window has the most dangerous value of each:\n\n{measures}\n\
         Convert numbers to these units. Answer with the filter on one line and nothing else. If a part of the sentence has \
         no term, add a second line `{LEFT_OUT}` with the words of that part. An example:\n\n\
         manoeuvre:cut_in,merging ttc<1.5 road:highway\n{LEFT_OUT} in the rain"
    )
}

/// The filter that an answer is.
fn written(answer: &str) -> Result<WrittenFilter, String> {
    let mut terms = Vec::new();
    let mut left_out = Vec::new();
    for line in answer.lines().filter(|line| !line.starts_with("```")) {
        let line = line.trim().trim_matches('`').trim();
        match line.strip_prefix(LEFT_OUT) {
            Some(words) if !words.trim().is_empty() => left_out.push(words.trim()),
            Some(_) => {}
            None => terms.extend(line.split_whitespace()),
        }
    }
    let filter = terms.join(" ");
    checked_filter(&filter)?;
    Ok(WrittenFilter {
        filter,
        left_out: (!left_out.is_empty()).then(|| left_out.join(", ")),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_formats::bundled;
    use nearmiss_scene::metrics::MEASURES;

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

    #[test]
    fn the_instructions_name_every_term_value_and_measure() {
        let measures: Vec<&Measure> = MEASURES.iter().collect();
        let text = instructions(&measures);
        for words in [
            "turning_across",
            "priority_vehicle",
            "off_road",
            "near_miss",
            "has:collision",
            "- ttc: time to collision, s\n",
        ] {
            assert!(text.contains(words), "{words}\n{text}");
        }
        for measure in MEASURES {
            assert!(
                text.contains(&format!("- {}: ", measure.id)),
                "{}",
                measure.id
            );
        }
    }

    #[test]
    fn an_answer_is_a_filter_or_says_why_not() {
        let read = |answer: &str| written(answer).map(|found| (found.filter, found.left_out));
        let filter = || "manoeuvre:cut_in ttc<1.5".to_string();
        for (answer, left_out) in [
            ("manoeuvre:cut_in ttc<1.5", None),
            ("`manoeuvre:cut_in ttc<1.5`\n", None),
            ("```\nmanoeuvre:cut_in\nttc<1.5\n```\nleft out:\n", None),
            (
                "manoeuvre:cut_in ttc<1.5\nleft out: in fog\nleft out: at dawn",
                Some("in fog, at dawn".to_string()),
            ),
        ] {
            assert_eq!(read(answer), Ok((filter(), left_out)), "{answer}");
        }
        for (answer, says) in [
            ("", "expected terms"),
            ("left out: everything", "expected terms"),
            ("I cannot do this.", "reads as a sentence"),
            ("The filter is: ttc<1", "unknown filter `is:`"),
            ("manoeuvre:cutting_in", "available: cut_in"),
            ("ttc<", "no value"),
        ] {
            let why = written(answer).unwrap_err();
            assert!(why.contains(says), "{answer}: {why}");
        }
    }
}

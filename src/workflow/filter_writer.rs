//! A model writes the terms that a sentence means; they are checked like those that a user writes.

use std::path::Path;

use super::index_search::{checked_filter, index_measures};
use super::scenario_filter::{TERMS, window_values};
use super::text_question::{TextError, TextQuestion};
use nearmiss_ask::llm::{Message, Request, Role};
use nearmiss_scene::corpus::IndexError;
use nearmiss_scene::metrics::Measure;
use nearmiss_store::{Store, StoreError};
use nearmiss_study::evaluation::ModelJudge;

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
    let text = question.ask(store).await.map_err(|error| match error {
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
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use nearmiss_scene::metrics::MEASURES;

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

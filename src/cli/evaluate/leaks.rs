//! `nearmiss evaluate --dry-run=leaks`: what the surface of the questions gives away.

use schemars::JsonSchema;
use serde::Serialize;

use crate::{Failure, Outcome, json, output};
use nearmiss_record::{columns, rows, text_table};
use nearmiss_store::NewItem;
use nearmiss_study::evaluation::{Leak, SURFACE, leaks};

/// What the questions give away, for programs.
#[derive(Serialize, JsonSchema)]
pub struct LeaksDocument {
    /// Areas under the ROC curve by task, frame, techniques and lead.
    leaks: Vec<Leak>,
}

impl json::Output for LeaksDocument {
    const NAME: &'static str = "evaluate-leaks";
    const TITLE: &'static str =
        "`evaluate --dry-run=leaks --format json`: what the surface of the questions tells";
}

/// Writes how well each part of the surface tells dangerous from safe windows.
pub fn write(items: &[NewItem], json: bool) -> Outcome {
    let leaks = leaks(items);
    if json {
        return output::document(&LeaksDocument { leaks });
    }
    let mut text = String::from(
        "areas under the ROC curve: 0.5 tells nothing, 0 and 1 tell dangerous from safe without fail; all, by regression: a\n\
         logistic regression on all five, tested on scenarios that it was not fitted to; below 0.5 it has learned only noise\n",
    );
    for (name, words) in SURFACE {
        text += &format!("{name}: {words}\n");
    }
    let rows = rows(&leaks).map_err(Failure::input)?;
    output::text(&format!(
        "{text}\n{}",
        text_table(&columns::<Leak>(), &rows)
    ))
}

//! The answers of a report for its HTML page: texts and claims from the store, pictures from the scenarios at hand.

use super::claims::known_files;
use crate::progress::LateProgress;
use crate::{Failure, output};
use nearmiss_formats::Entry;
use nearmiss_store::Store;
use nearmiss_study::evaluation::{AnswerCase, AnswerPage};
use nearmiss_workflow::answer_page;

/// The page of these answers; their scenarios are looked for in `files`, in the batches and among the bundled ones.
pub fn page(
    store: &Store,
    cases: &[AnswerCase<'_>],
    mut files: Vec<Entry>,
) -> Result<AnswerPage, Failure> {
    files.extend(known_files(store)?);
    let progress = LateProgress::new("scenes");
    let shown = |_, of| progress.step(of);
    let page = answer_page(store, cases, &files, &shown).map_err(Failure::input)?;
    let left_out = page.pictures_left_out();
    if left_out > 0 {
        output::say(&format!(
            "nearmiss: the page has no pictures of {}: they would make it too large",
            output::counted(left_out, "question")
        ));
    }
    let left_out = page.sent_left_out();
    if left_out > 0 {
        output::say(&format!(
            "nearmiss: the page has no {} that models were sent: they would make it too large; `runs picture` writes one",
            output::counted(left_out, "picture")
        ));
    }
    Ok(page)
}

//! The table of what the questions of a batch give away.

use super::super::windows::{CLEAR, MATCHED_ON};
use super::super::{Leak, SURFACE};
use super::contents::rows_of;
use nearmiss_record::{CaptionedTable, columns};

/// The table; `None` where nothing is known of the questions.
pub(super) fn table(leaks: &[Leak]) -> Option<CaptionedTable> {
    let caption = "What the questions give away: how well each part of their surface alone tells dangerous from safe windows";
    let columns = columns::<Leak>();
    let table = CaptionedTable::new(caption, "nearmiss-leaks", &columns, &rows_of(leaks));
    table.with_notes([methods()]).filled()
}

/// What the numbers are.
pub(super) fn methods() -> String {
    let surface = SURFACE.map(|(name, words)| format!("{name}: {words}"));
    format!(
        "Windows: each dangerous one is matched to a safe one by {MATCHED_ON}, of all recordings and times at once so that the \
         sum of squared differences is least; nothing is touched in a safe window, within the horizon after it and for {CLEAR} s \
         more. Leaks are areas under the ROC curve, 0.5 where a value says nothing about the answer ({}); the last one is of a \
         logistic regression on all of them, on scenarios that it was not fitted to.",
        surface.join("; ")
    )
}

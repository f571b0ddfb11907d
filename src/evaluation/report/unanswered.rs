//! Who left out much: answers without a verdict, said before every table.

use super::{Cell, Report, names};

/// From this share without a verdict on, a report begins with it.
const MANY: f64 = 0.05;

impl Report {
    /// Who left out much, which notes begin with.
    pub(super) fn unanswered(&self) -> Option<String> {
        let many = |cell: &&Cell| cell.without_verdict().is_some_and(|share| share >= MANY);
        let who = self.whole().filter(many).map(|cell| {
            let without = cell.asked - cell.confusion.answered();
            let share = 100.0 * f64::from(without) / f64::from(cell.asked);
            let way = names::way(&cell.way);
            format!("{way} of {without} of {} ({share:.0} %)", cell.asked)
        });
        let who: Vec<String> = who.collect();
        (!who.is_empty()).then(|| {
            format!(
                "No verdict could be read: {}. That counts as not right; precision, recall, specificity, accuracy and F1 \
                 are of the verdicts alone and flatter who leaves out what is hard.",
                who.join("; ")
            )
        })
    }
}

//! Said before every table: who left out much, and whose verdicts are doubtful by themselves.

use super::{Cell, DataHalf, Report, names, ways};
use crate::evaluation::Scored;

/// From this share without a verdict on, a report begins with it.
const MANY: f64 = 0.05;

impl Report {
    /// What is said before every table.
    pub(super) fn warnings(&self) -> impl Iterator<Item = String> + use<> {
        self.unanswered().into_iter().chain(self.doubtful())
    }

    /// The same of answers that have no report.
    pub(super) fn warnings_of<'a>(
        scored: impl IntoIterator<Item = &'a Scored>,
    ) -> impl Iterator<Item = String> {
        let cells = ways(scored)
            .into_iter()
            .map(|(way, of_way)| Cell::count(way, DataHalf::All, &of_way));
        let report = Self {
            cells: cells.collect(),
            ..Self::default()
        };
        report.warnings()
    }

    /// Whose verdicts contradict themselves, or name obstacles twice or that are not there.
    fn doubtful(&self) -> Option<String> {
        let who = self.whole().filter_map(|cell| {
            let flagged = cell.flagged;
            let counts = [
                (flagged.contradictory, "contradictory"),
                (
                    flagged.unknown,
                    "with an obstacle that the scene does not have",
                ),
                (flagged.twice, "with an obstacle named twice"),
            ]
            .into_iter()
            .filter(|(count, _)| *count > 0);
            let counts: Vec<String> = counts.map(|(n, what)| format!("{n} {what}")).collect();
            let of = cell.confusion.answered() + cell.unlabelled;
            let way = names::way(&cell.way);
            (!counts.is_empty()).then(|| format!("{way}, of {of}: {}", counts.join(", ")))
        });
        let who: Vec<String> = who.collect();
        (!who.is_empty()).then(|| {
            format!(
                "Doubtful verdicts, which count as they say: {}.",
                who.join("; ")
            )
        })
    }

    /// Who left out much, which notes begin with.
    fn unanswered(&self) -> Option<String> {
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

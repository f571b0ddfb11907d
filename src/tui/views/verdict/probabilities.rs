//! Probabilities of verdicts: rows of the table, and those of critical obstacles.

use ratatui::style::Style;
use ratatui::text::Line;

use super::table::{Row, Table};
use crate::model::Column;
use nearmiss_scene::verdict::Verdict;

/// Whether a verdict states a probability, and whether one has log probabilities.
pub fn known<'a>(verdicts: impl Iterator<Item = &'a Verdict>) -> (bool, bool) {
    verdicts.fold((false, false), |(stated, tokens), verdict| {
        (
            stated || verdict.probability.is_some(),
            tokens || verdict.token_probability.is_some(),
        )
    })
}

/// The verdicts of answers.
pub fn verdicts(columns: &[Column]) -> impl Iterator<Item = &Verdict> {
    columns.iter().filter_map(|c| c.answer()?.verdict())
}

impl Table<'_> {
    /// The probabilities of a yes; a dash where one is not known, nothing of answers that are yet to come.
    pub fn probabilities(&mut self, verdict: Option<&Verdict>, style: Style) {
        let words = |p: Option<f64>| p.map_or("–".to_string(), two);
        let stated = words(verdict.and_then(|v| v.probability));
        let tokens = words(verdict.and_then(|v| v.token_probability));
        self.cell(Row::Probability, &stated, style);
        self.cell(Row::TokenProbability, &tokens, style);
    }
}

/// The critical obstacles with their probabilities: `critical: 301 (0.90), 305 (0.20)`; nothing where none has one.
pub fn critical(verdict: &Verdict, style: Style) -> Option<Line<'static>> {
    let all = verdict.critical.as_ref()?;
    all.iter().find_map(|one| one.probability)?;
    let each = all.iter().map(|one| match one.probability {
        Some(p) => format!("{} ({})", one.id, two(p)),
        None => one.id.to_string(),
    });
    let words = format!("critical: {}", each.collect::<Vec<_>>().join(", "));
    Some(Line::styled(words, style))
}

/// A probability with two decimals.
pub fn two(probability: f64) -> String {
    format!("{probability:.2}")
}

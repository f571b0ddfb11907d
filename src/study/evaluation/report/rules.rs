//! The table of trivial rules on the questions of a batch.

use serde_json::{Value, json};

use super::super::{Confusion, RuleScore};
use super::document::Table;
use super::json::counts;
use super::names::number;
use nearmiss_scene::verdict::Task;

/// The table of a task; `None` where nothing is known of the questions.
pub(super) fn table(task: Task, rules: &[RuleScore]) -> Option<Table> {
    let titles = [
        "<Rule",
        "n",
        "Right of all",
        "TP",
        "FP",
        "FN",
        "TN",
        "Precision",
        "Recall",
        "F1",
    ];
    let caption = format!("Trivial rules on the same questions, {} task", task.name());
    let name = format!("nearmiss-{}-rules", task.name());
    let mut table = Table::new(caption, name, &titles);
    table.notes.push(methods(rules));
    for score in rules.iter().filter(|score| score.task == task) {
        let c = &score.counts;
        let mut row = vec![score.rule.to_string(), c.answered().to_string()];
        row.push(number(c.accuracy(), 2));
        row.extend(c.counts().map(|n| n.to_string()));
        row.extend([c.precision(), c.recall(), c.f1()].map(|share| number(share, 2)));
        table.rows.push(row);
    }
    (!table.rows.is_empty()).then_some(table)
}

/// What the rules are.
fn methods(rules: &[RuleScore]) -> String {
    let chosen = if rules.iter().any(|rule| rule.is_fitted) {
        "the best ones of the dev part"
    } else {
        "the usual ones, as the batch has no split"
    };
    format!(
        "Rules see the measures of the window and no model: a distance of 0.00 is written in the ego and metrics frames where \
         bodies touch, so the collision task can be solved there by looking for it; TTC at the end of the window; the nearest \
         obstacle at any of its steps. Thresholds are {chosen}. A model that is no better than these reads a table."
    )
}

/// The same as JSON.
pub fn row(score: &RuleScore) -> Value {
    let c: &Confusion = &score.counts;
    let mut row = json!({
        "task": score.task.name(),
        "rule": score.rule.to_string(),
        "fitted_on_dev": score.is_fitted,
        "n": c.answered(),
        "right_of_all": c.accuracy(),
        "precision": c.precision(),
        "recall": c.recall(),
        "f1": c.f1(),
    });
    if let Some(row) = row.as_object_mut() {
        row.extend(counts(c));
    }
    row
}

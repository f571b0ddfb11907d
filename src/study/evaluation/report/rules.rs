//! The table of trivial rules on the questions of a batch.

use schemars::JsonSchema;
use serde::Serialize;

use super::super::{Confusion, RuleScore};
use super::contents::{columns_of_task, rows_of};
use nearmiss_record::{CaptionedTable, Record};
use nearmiss_scene::verdict::Task;

/// What a trivial rule comes to, as tables and documents have it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RuleRow {
    /// The task.
    pub task: &'static str,
    /// What the rule says yes to.
    #[schemars(title = "Rule")]
    pub rule: String,
    /// Whether its threshold is the best one of the dev part.
    pub fitted_on_dev: bool,
    /// Questions.
    #[schemars(title = "n")]
    pub n: u32,
    /// The share that it is right about.
    #[schemars(title = "Right of all", extend("decimals" = 2))]
    pub right_of_all: Option<f64>,
    /// Its answers beside the truth.
    #[serde(flatten)]
    pub counts: Confusion,
    /// tp / (tp + fp).
    #[schemars(title = "Precision", extend("decimals" = 2))]
    pub precision: Option<f64>,
    /// tp / (tp + fn).
    #[schemars(title = "Recall", extend("decimals" = 2))]
    pub recall: Option<f64>,
    /// Harmonic mean of precision and recall.
    #[schemars(title = "F1", extend("decimals" = 2))]
    pub f1: Option<f64>,
}

impl Record for RuleRow {
    const NAME: &'static str = "rule";
    const TITLE: &'static str = "What a trivial rule comes to";
}

impl From<&RuleScore> for RuleRow {
    fn from(score: &RuleScore) -> Self {
        let c = &score.counts;
        Self {
            task: score.task.name(),
            rule: score.rule.to_string(),
            fitted_on_dev: score.is_fitted,
            n: c.answered(),
            right_of_all: c.accuracy(),
            counts: *c,
            precision: c.precision(),
            recall: c.recall(),
            f1: c.f1(),
        }
    }
}

/// The table of a task; `None` where nothing is known of the questions.
pub(super) fn table(task: Task, rules: &[RuleScore]) -> Option<CaptionedTable> {
    let of_task = rules.iter().filter(|score| score.task == task);
    let rows: Vec<RuleRow> = of_task.map(RuleRow::from).collect();
    let caption = format!("Trivial rules on the same questions, {} task", task.name());
    let name = format!("nearmiss-{}-rules", task.name());
    let columns = columns_of_task::<RuleRow>("accuracy");
    let table = CaptionedTable::new(caption, name, &columns, &rows_of(&rows));
    table.with_notes([methods(rules)]).filled()
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

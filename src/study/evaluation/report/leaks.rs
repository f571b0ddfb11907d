//! The table of what the questions of a batch give away.

use serde_json::{Map, Value, json};

use super::super::windows::{CLEAR, MATCHED_ON};
use super::super::{Leak, SURFACE};
use super::document::Table;
use super::names::{NONE, number};

/// The table; `None` where nothing is known of the questions.
pub(super) fn table(leaks: &[Leak]) -> Option<Table> {
    let mut titles = vec![
        "<Task",
        "<Frame",
        "<Techniques",
        "Lead",
        "Dangerous",
        "Safe",
    ];
    titles.extend(SURFACE.map(|(name, _)| name));
    titles.push("all, by regression");
    let caption = "What the questions give away: how well each part of their surface alone tells dangerous from safe windows";
    let mut table = Table::new(caption, "nearmiss-leaks", &titles);
    table.notes.push(methods());
    for leak in leaks {
        let of = |word: &Option<String>| word.clone().unwrap_or_else(|| NONE.into());
        let lead = leak.lead.clone().unwrap_or_else(|| "all".into());
        let mut row = vec![
            leak.task.name().into(),
            of(&leak.frame),
            of(&leak.techniques),
            lead,
        ];
        row.extend([leak.dangerous, leak.safe].map(|n| n.to_string()));
        row.extend(leak.auc.map(|auc| number(auc, 2)));
        row.push(number(leak.model_auc, 2));
        table.rows.push(row);
    }
    (!table.rows.is_empty()).then_some(table)
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

/// The same as JSON.
pub fn row(leak: &Leak) -> Value {
    let auc = SURFACE.iter().zip(leak.auc);
    let auc: Map<String, Value> = auc
        .map(|((name, _), auc)| (name.replace(' ', "_"), json!(auc)))
        .collect();
    json!({
        "task": leak.task.name(),
        "frame": leak.frame,
        "techniques": leak.techniques,
        "lead": leak.lead,
        "dangerous": leak.dangerous,
        "safe": leak.safe,
        "auc": auc,
        "model_auc": leak.model_auc,
    })
}

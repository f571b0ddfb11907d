//! `nearmiss evaluate --dry-run=leaks`: what the surface of the questions gives away.

use serde_json::json;

use crate::{Outcome, output};
use nearmiss_store::NewItem;
use nearmiss_study::evaluation::report::leak_row;
use nearmiss_study::evaluation::{SURFACE, leaks};

/// Writes how well each part of the surface tells dangerous from safe windows.
pub fn write(items: &[NewItem], json: bool) -> Outcome {
    let leaks = leaks(items);
    if json {
        return output::json(&json!({ "leaks": leaks.iter().map(leak_row).collect::<Vec<_>>() }));
    }
    let mut text = String::from(
        "areas under the ROC curve: 0.5 tells nothing, 0 and 1 tell dangerous from safe without fail; model: a logistic\n\
         regression on all five, tested on scenarios that it was not fitted to; below 0.5 it has learned only noise\n",
    );
    for (name, words) in SURFACE {
        text.push_str(&format!("{name}: {words}\n"));
    }
    let head = SURFACE.map(|(name, _)| format!("{name:>10}")).concat();
    text.push_str(&format!(
        "\n{:<36}{:>6}{:>10}{:>6}{head}{:>8}\n",
        "questions", "lead", "dangerous", "safe", "model"
    ));
    for leak in &leaks {
        let how = [
            Some(leak.task.name()),
            leak.frame.as_deref(),
            leak.techniques.as_deref(),
        ];
        let how: Vec<&str> = how.into_iter().flatten().collect();
        let cells = leak
            .auc
            .map(|auc| format!("{:>10}", super::share(auc)))
            .concat();
        text.push_str(&format!(
            "{:<36}{:>6}{:>10}{:>6}{cells}{:>8}\n",
            how.join(" · "),
            leak.lead.as_deref().unwrap_or("all"),
            leak.dangerous,
            leak.safe,
            super::share(leak.model_auc),
        ));
    }
    output::text(&text)
}

//! What a tune would ask, before anything is sent.

use super::document::TuneDryRunDocument;
use super::words::parts;
use crate::{Outcome, output};
use nearmiss_workflow::tune::{TuneEstimate, TunePlan};

/// Writes what would be asked at most.
pub fn write(
    estimate: &TuneEstimate,
    about: (&TunePlan, usize, &str),
    budget: f64,
    as_json: bool,
) -> Outcome {
    if as_json {
        return output::document(&TuneDryRunDocument::new(about, estimate, budget));
    }
    let (plan, test_scenarios, reflect) = about;
    let mut text = format!(
        "template       {} ({}…)\nmodel          {}\nproposals by   {reflect}\n",
        plan.file,
        &plan.hash[..plan.hash.len().min(12)],
        plan.configuration.model
    );
    for line in parts(plan, test_scenarios) {
        text += &format!("{:15}{line}\n", "");
    }
    let base = &estimate.base;
    text += &format!(
        "base           {} of both parts not in the store, {}\n",
        output::counted(base.requests as usize, "answer"),
        base.price()
    );
    text += &format!(
        "at most        {} and {}\n",
        output::counted(estimate.answers, "answer"),
        output::counted(estimate.reflections, "proposal")
    );
    text += &match estimate.most_usd {
        Some(usd) if usd <= budget => format!("cost           at most ${usd:.4}, within the budget of ${budget:.4}\n"),
        Some(usd) => format!(
            "cost           at most ${usd:.4}; the tune ends when the budget of ${budget:.4} does not cover the next request\n"
        ),
        None => "cost           unknown, so nothing is sent: set a price of the model and `max_tokens`\n".into(),
    };
    output::text(&output::visible(&text))
}

//! A model's choice and attacks for one scenario, as JSON.

use serde_json::{Value, json};

use super::Authored;
use crate::description::visible;
use crate::generation::{Attack, refusal};

impl Authored {
    /// Its choice and its reasons, what it wrote about the attack that was taken, if one was, and what all of it took.
    #[must_use]
    pub fn document(&self, taken: Option<&Attack>) -> Value {
        let (choice, spent) = (&self.choice, &self.spent);
        let taken = taken.and_then(|attack| self.source_of(attack));
        let proposal = choice.proposal.as_ref();
        let refused = proposal.and_then(|p| p.refused.as_ref());
        json!({
            "attacker_by": choice.by.name(),
            "proposal": proposal.and_then(|p| p.said.as_ref()),
            "proposal_refused": refused.map(refusal),
            "proposal_reasoning": proposal.map(|p| visible(&p.reasoning)),
            "justification": taken.map(|t| visible(&t.justification)),
            "reasoning": taken.map(|t| visible(&t.reasoning)),
            "run": taken.and_then(|t| t.source.run).map(|run| run.to_string()),
            "repaired_by": taken.and_then(|t| t.admitted.repair.as_ref()).map(|r| r.moved),
            "requests": spent.requests,
            "answers": spent.answers,
            "from_store": spent.stored,
            "input_tokens": spent.input_tokens,
            "output_tokens": spent.output_tokens,
            "cost_usd": spent.usd,
            "cost_usd_paid_before": spent.usd_before,
            "unpriced": spent.unpriced,
            "stopped": self.stopped.as_deref().map(visible),
        })
    }
}

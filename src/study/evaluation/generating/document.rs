//! A model's choice and attacks for one scenario, as JSON.

use serde_json::{Value, json};

use super::{Authored, AuthoredAttack, Proposal, Source, nearest};
use nearmiss_drive::generation::{Attack, Effect, refusal};
use nearmiss_drive::planner::Road;
use nearmiss_scene::description::visible;

impl Authored {
    /// Its choice and its reasons, what it wrote about the attack that was taken, if one was, and what all of it took.
    #[must_use]
    pub fn document(&self, taken: Option<&Attack>) -> Value {
        let (choice, spent) = (&self.choice, &self.spent);
        let taken = taken.and_then(|attack| self.source_of(attack));
        let proposal = choice.proposal.as_ref();
        let refused = proposal.and_then(|p| p.refused.as_ref());
        let vote = |vote: &Proposal| {
            json!({
                "run": vote.run.map(|run| run.to_string()),
                "attacker": vote.said.as_ref().and_then(|said| said.attacker),
                "rejected": vote.refused.as_ref().map(refusal),
            })
        };
        let tally = choice.tally().into_iter();
        json!({
            "attacker_by": choice.by.name(),
            "within": choice.within,
            "not_asked": choice.not_asked(),
            "votes": choice.votes.iter().map(vote).collect::<Vec<_>>(),
            "tally": tally.map(|(id, votes)| json!({ "attacker": id, "votes": votes })).collect::<Vec<_>>(),
            "tied_with": choice.tied,
            "proposal": proposal.and_then(|p| p.said.as_ref()),
            "proposal_refused": refused.map(refusal),
            "proposal_reasoning": proposal.map(|p| visible(&p.reasoning)),
            "justification": taken.map(|t| visible(&t.justification)),
            "reasoning": taken.map(|t| visible(&t.reasoning)),
            "run": taken.and_then(|t| t.source.run).map(|run| run.to_string()),
            "repaired_by": taken.and_then(|t| t.admitted.repair.as_ref()).map(|r| r.moved),
            "motions": self.in_order().iter().map(|one| motion(one, taken)).collect::<Vec<_>>(),
            "tries": self.tries(),
            "ranked_by": self.ranked_by().name(),
            "agreement": self.agreement().map(|agreement| json!({
                "agrees": agreement.agrees,
                "of": agreement.of,
                "by_chance": agreement.by_chance,
                "by_model": place(agreement.model),
                "exact": place(agreement.exact),
            })),
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

    /// The attacks in the order in which they were written.
    fn in_order(&self) -> Vec<&AuthoredAttack> {
        let mut all: Vec<&AuthoredAttack> = self.attacks.iter().collect();
        all.sort_by_key(|one| (one.source.sample, one.source.retry));
        all
    }
}

/// Which conversation and which answer in it, both from 0.
fn place(source: Source) -> Value {
    json!({ "sample": source.sample, "retry": source.retry })
}

/// A motion that passed the gate: what came of it, and the model's grade.
fn motion(one: &AuthoredAttack, taken: Option<&AuthoredAttack>) -> Value {
    let attack = &one.admitted.attack;
    let effect = attack.effect.as_ref();
    let near = effect.and_then(|effect| {
        let (track, body) = (effect.drive.track(), Road::body_of(&effect.drive.limits));
        nearest(
            &effect.scenario,
            effect.main().obstacle,
            (&body, &track),
            effect.from,
        )
    });
    let grade = one.grade.as_ref();
    json!({
        "sample": one.source.sample,
        "retry": one.source.retry,
        "run": one.source.run.map(|run| run.to_string()),
        "manoeuvre": attack.asked[0].name(),
        "outcome": effect.map(|effect| effect.consequence.name()),
        "survivable": attack.survivable,
        "min_distance": effect.and_then(Effect::distance),
        "min_distance_step": near.map(|near| near.step),
        "min_risk": effect.and_then(|effect| effect.lowest_after()),
        "sent_back": one.told.is_some(),
        "grade": grade.and_then(|grade| grade.score),
        "grade_run": grade.and_then(|grade| grade.run).map(|run| run.to_string()),
        "grade_problem": grade.and_then(|grade| grade.problem.as_deref()).map(visible),
        "taken": taken.is_some_and(|taken| taken.source == one.source),
    })
}

//! A model's choice and attacks for one scenario, for programs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Authored, AuthoredAttack, Proposal, Source, Tries, nearest};
use nearmiss_drive::generation::{Attack, Effect, RefusalRecord};
use nearmiss_drive::planner::Road;
use nearmiss_scene::description::visible;
use nearmiss_scene::verdict::AttackerChoice;

/// A model's choice and its reasons, what it wrote about the attack that was taken, and what all of it took.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AuthoredRecord {
    /// Who chose the attacker: user, model, reference or no_attacker.
    pub attacker_by: String,
    /// The model was told of obstacles within this distance, metres.
    pub within: Option<f64>,
    /// Why the model was not asked who attacks.
    pub not_asked: Option<String>,
    /// Each answer about the attacker.
    pub votes: Vec<Vote>,
    /// Votes by obstacle.
    pub tally: Vec<Tally>,
    /// Obstacles with as many votes.
    pub tied_with: Vec<i64>,
    /// The answer that counts.
    pub proposal: Option<AttackerChoice>,
    /// Why its choice cannot be taken.
    pub proposal_refused: Option<RefusalRecord>,
    /// Its reasoning.
    pub proposal_reasoning: Option<String>,
    /// Why the attack that was taken endangers the ego, as the model says.
    pub justification: Option<String>,
    /// The reasoning about it.
    pub reasoning: Option<String>,
    /// Its run.
    pub run: Option<String>,
    /// How far the motion was moved at most to be drivable, metres.
    pub repaired_by: Option<f64>,
    /// Motions that passed the gate.
    pub motions: Vec<WrittenMotion>,
    /// How its conversations fared.
    pub tries: Tries,
    /// What decided between them: exact or model.
    pub ranked_by: String,
    /// Whether its grades and the exact ranking prefer the same motion; null where there was nothing to compare.
    pub agreement: Option<AgreementRecord>,
    /// Questions.
    pub requests: u32,
    /// Answers.
    pub answers: u32,
    /// Of these, answers from the store.
    pub from_store: u32,
    /// Tokens of all questions.
    pub input_tokens: u64,
    /// Tokens of all answers.
    pub output_tokens: u64,
    /// Cost of answers with a known price, US dollars.
    pub cost_usd: f64,
    /// Of this, what had been paid before.
    pub cost_usd_paid_before: f64,
    /// Answers without a known price.
    pub unpriced: u32,
    /// Why it did not get to the end, where it did not.
    pub stopped: Option<String>,
}

/// An answer about the attacker.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Vote {
    run: Option<String>,
    attacker: Option<i64>,
    rejected: Option<RefusalRecord>,
}

/// The votes for an obstacle.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Tally {
    attacker: i64,
    votes: usize,
}

/// A motion that passed the gate: what came of it, and the model's grade.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WrittenMotion {
    sample: u32,
    retry: u32,
    run: Option<String>,
    manoeuvre: String,
    outcome: Option<String>,
    survivable: Option<bool>,
    min_distance: Option<f64>,
    min_distance_step: Option<i64>,
    min_risk: Option<u8>,
    sent_back: bool,
    grade: Option<u8>,
    grade_run: Option<String>,
    grade_problem: Option<String>,
    taken: bool,
}

/// Whether the model's grades and the exact ranking prefer the same motion.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AgreementRecord {
    /// Whether.
    pub agrees: bool,
    /// How many different motions were compared.
    pub of: usize,
    /// How probable it is by chance.
    pub by_chance: f64,
    /// The motion with the best grade.
    pub by_model: Place,
    /// The best motion by the exact ranking.
    pub exact: Place,
}

/// Which conversation and which answer in it, both from 0.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Place {
    /// Which conversation.
    pub sample: u32,
    /// Which answer in it.
    pub retry: u32,
}

impl From<Source> for Place {
    fn from(source: Source) -> Self {
        Self {
            sample: source.sample,
            retry: source.retry,
        }
    }
}

impl Authored {
    /// What it did; `taken` is the attack that was taken, if one was.
    #[must_use]
    pub fn record(&self, taken: Option<&Attack>) -> AuthoredRecord {
        let (choice, spent) = (&self.choice, &self.spent);
        let taken = taken.and_then(|attack| self.source_of(attack));
        let proposal = choice.proposal.as_ref();
        let text = |text: &str| visible(text).into_owned();
        let tally = choice.tally().into_iter();
        let agreement = self.agreement().map(|agreement| AgreementRecord {
            agrees: agreement.agrees,
            of: agreement.of,
            by_chance: agreement.by_chance,
            by_model: agreement.model.into(),
            exact: agreement.exact.into(),
        });
        AuthoredRecord {
            attacker_by: choice.by.name().into(),
            within: choice.within,
            not_asked: choice.not_asked(),
            votes: choice.votes.iter().map(Vote::from).collect(),
            tally: tally
                .map(|(attacker, votes)| Tally { attacker, votes })
                .collect(),
            tied_with: choice.tied.clone(),
            proposal: proposal.and_then(|p| p.said.clone()),
            proposal_refused: { proposal.and_then(|p| p.refused.as_ref()) }
                .map(RefusalRecord::from),
            proposal_reasoning: proposal.map(|p| text(&p.reasoning)),
            justification: taken.map(|t| text(&t.justification)),
            reasoning: taken.map(|t| text(&t.reasoning)),
            run: taken.and_then(|t| t.source.run).map(|run| run.to_string()),
            repaired_by: taken
                .and_then(|t| t.admitted.repair.as_ref())
                .map(|r| r.moved),
            motions: { self.in_order().into_iter() }
                .map(|one| WrittenMotion::new(one, taken))
                .collect(),
            tries: self.tries(),
            ranked_by: self.ranked_by().name().into(),
            agreement,
            requests: spent.requests,
            answers: spent.answers,
            from_store: spent.stored,
            input_tokens: spent.input_tokens,
            output_tokens: spent.output_tokens,
            cost_usd: spent.usd,
            cost_usd_paid_before: spent.usd_before,
            unpriced: spent.unpriced,
            stopped: self.stopped.as_deref().map(text),
        }
    }

    /// The attacks in the order in which they were written.
    fn in_order(&self) -> Vec<&AuthoredAttack> {
        let mut all: Vec<&AuthoredAttack> = self.attacks.iter().collect();
        all.sort_by_key(|one| (one.source.sample, one.source.retry));
        all
    }
}

impl From<&Proposal> for Vote {
    fn from(vote: &Proposal) -> Self {
        Self {
            run: vote.run.map(|run| run.to_string()),
            attacker: vote.said.as_ref().and_then(|said| said.attacker),
            rejected: vote.refused.as_ref().map(RefusalRecord::from),
        }
    }
}

impl WrittenMotion {
    fn new(one: &AuthoredAttack, taken: Option<&AuthoredAttack>) -> Self {
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
        Self {
            sample: one.source.sample,
            retry: one.source.retry,
            run: one.source.run.map(|run| run.to_string()),
            manoeuvre: attack.asked[0].name().into(),
            outcome: effect.map(|effect| effect.consequence.name().into()),
            survivable: attack.survivable,
            min_distance: effect.and_then(Effect::distance),
            min_distance_step: near.map(|near| near.step),
            min_risk: effect.and_then(|effect| effect.lowest_after()),
            sent_back: one.told.is_some(),
            grade: grade.and_then(|grade| grade.score),
            grade_run: grade.and_then(|grade| grade.run).map(|run| run.to_string()),
            grade_problem: { grade.and_then(|grade| grade.problem.as_deref()) }
                .map(|problem| visible(problem).into_owned()),
            taken: taken.is_some_and(|taken| taken.source == one.source),
        }
    }
}

//! An author's output: attacks that passed the gate, refused answers, consumption; the same for programs.

use nearmiss_drive::generation::{
    AdmittedAttack, Attack, AttackSetup, Effect, Refusal, RefusalRecord, SearchResult, Selection,
    choose,
};
use nearmiss_drive::planner::Road;
use nearmiss_scene::description::visible;
use nearmiss_scene::verdict::{AttackerChoice, NewMotion};
use nearmiss_store::{Consumed, RunId};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::super::answer::Answer;
use super::feedback::is_wanted;
use super::{Choice, Grade, Proposal, Ranking, nearest};

/// A model's complete output for one scenario.
#[derive(Debug, Clone)]
pub struct Authored {
    /// The choice of attacker.
    pub choice: Choice,
    /// Attacks, which all pass the gate; in the order of the conversations until all are driven. One conversation may
    /// have several, where the first ones were not what was wanted.
    pub attacks: Vec<AuthoredAttack>,
    /// Answers that are none, with all reasons; also those that were mended later.
    pub declined: Vec<RefusedAnswer>,
    /// Total consumption, the choice included.
    pub spent: AuthoringUsage,
    /// What decides between the attacks.
    pub rank: Ranking,
    /// Why the work ended before all conversations, where it did.
    pub stopped: Option<String>,
}

/// An attack and where it comes from.
#[derive(Debug, Clone)]
pub struct AuthoredAttack {
    /// The attack, and what was repaired.
    pub admitted: AdmittedAttack,
    /// Which answer it is from.
    pub source: Source,
    /// Why it endangers the ego, as the model says.
    pub justification: String,
    /// The model's reasoning, where that came apart from the answer.
    pub reasoning: String,
    /// What was told to the model about the drive against it, where it went back.
    pub feedback: Option<String>,
    /// How the model grades it, where it was asked.
    pub grade: Option<Grade>,
}

/// One answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Source {
    /// Which conversation, from 0.
    pub sample: u32,
    /// Which answer in it, 0 for the first.
    pub retry: u32,
    /// Its run in the store.
    pub run: Option<RunId>,
}

/// An answer that became no attack.
#[derive(Debug, Clone)]
pub struct RefusedAnswer {
    /// Which answer.
    pub source: Source,
    /// Whether there is an answer: where the server failed, no motion was tried.
    pub arrived: bool,
    /// The parsed motion, if it could be read.
    pub motion: Option<NewMotion>,
    /// All that is wrong with it, never nothing; see [`nearmiss_drive::generation::summarize`] for few words.
    pub refusals: Vec<Refusal>,
}

impl Authored {
    pub(super) fn new(choice: Choice, spent: AuthoringUsage, rank: Ranking) -> Self {
        Self {
            choice,
            attacks: Vec::new(),
            declined: Vec::new(),
            spent,
            rank,
            stopped: None,
        }
    }

    /// How many motions were answered, refused or not.
    #[must_use]
    pub fn candidates(&self) -> usize {
        self.attacks.len() + self.answered().count()
    }

    /// Refused answers that arrived.
    fn answered(&self) -> impl Iterator<Item = &RefusedAnswer> {
        self.declined.iter().filter(|declined| declined.arrived)
    }

    /// Drives the ego against every attack that it was not driven against yet, looks whether an ideal driver survives
    /// those that have an effect with a reaction time of `delay` seconds, and puts the best one first. Before each
    /// attack `watch` hears how many were driven against, and says whether to go on. False where it said no: the attacks stay in their order then.
    pub fn drive_watched(
        &mut self,
        ground: &AttackSetup<'_>,
        delay: f64,
        watch: &mut dyn FnMut(usize) -> bool,
    ) -> bool {
        for (driven, one) in self.attacks.iter_mut().enumerate() {
            if !watch(driven) {
                return false;
            }
            let attack = &mut one.admitted.attack;
            if attack.effect.is_none() {
                ground.drive(attack);
            }
            if attack.has_effect() && attack.survivable.is_none() {
                ground.survive(attack, delay);
            }
        }
        let cost = |one: &AuthoredAttack| one.admitted.attack.cost();
        self.attacks.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        true
    }

    /// What decided between the motions: without a grade that can be read, the exact ranking.
    #[must_use]
    pub fn ranked_by(&self) -> Ranking {
        match self.by_model() {
            Some(_) => self.rank,
            None => Ranking::Exact,
        }
    }

    /// Of attacks that were driven against, the most dangerous one that an ideal driver survives: what a search gives,
    /// too; or with [`Ranking::Model`] the one that the model grades lowest, if it graded any. Of each refused answer it has the first reason; [`Authored::refusals`] are all.
    #[must_use]
    pub fn taken(&self, ground: &AttackSetup<'_>, delay: f64) -> Selection {
        let all = self.attacks.iter();
        let attacks: Vec<Attack> = all.map(|a| a.admitted.attack.clone()).collect();
        let preferred = match self.rank {
            Ranking::Exact => None,
            Ranking::Model => self.by_model(),
        };
        let chosen = match preferred {
            Some(one) => {
                let only = std::slice::from_ref(&one.admitted.attack);
                choose(ground.closed_loop, only, delay, false)
            }
            None => choose(ground.closed_loop, &attacks, delay, false),
        };
        let first = |declined: &RefusedAnswer| declined.refusals.first().cloned();
        let found = SearchResult {
            attacks,
            refused: self.answered().filter_map(first).collect(),
            candidates: self.candidates(),
            work: 0,
        };
        Selection { found, chosen }
    }

    /// Where an attack of [`Authored::taken`] comes from.
    #[must_use]
    pub fn find_source(&self, attack: &Attack) -> Option<&AuthoredAttack> {
        self.attacks.iter().find(|a| {
            a.admitted.attack.change == attack.change && a.admitted.attack.asked == attack.asked
        })
    }

    /// All refusals of all answers, those of votes for the attacker first.
    #[must_use]
    pub fn refusals(&self) -> Vec<Refusal> {
        let votes = self.choice.votes.iter();
        let choice = votes.filter_map(|vote| vote.refused.clone());
        let declined = self.declined.iter().flat_map(|d| d.refusals.clone());
        choice.chain(declined).collect()
    }

    /// How the first answers of all conversations fared, and what the conversations came to.
    #[must_use]
    pub fn tries(&self) -> Tries {
        let mut tries = Tries::default();
        let first = |source: &Source| source.retry == 0;
        let declined = self.answered().filter(|d| first(&d.source)).count();
        let mut effective = std::collections::BTreeSet::new();
        for one in &self.attacks {
            let wanted = is_wanted(&one.admitted.attack);
            if first(&one.source) {
                tries.first_admitted += 1;
                tries.first_effective += usize::from(wanted);
            }
            if wanted {
                effective.insert(one.source.sample);
            }
        }
        tries.conversations = tries.first_admitted + declined;
        tries.effective = effective.len();
        tries
    }
}

/// How a model's conversations about a motion fared.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    serde::Serialize,
    serde::Deserialize,
    schemars::JsonSchema,
)]
pub struct Tries {
    /// Conversations that had an answer.
    pub conversations: usize,
    /// Of these, those whose first answer passed the gate.
    pub first_admitted: usize,
    /// Those whose first answer also had an effect that an ideal driver survives.
    pub first_effective: usize,
    /// Those that came to such an effect in the end.
    pub effective: usize,
}

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
        let taken = taken.and_then(|attack| self.find_source(attack));
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
            proposal: proposal.and_then(|p| p.choice.clone()),
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
            attacker: vote.choice.as_ref().and_then(|choice| choice.attacker),
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
            sent_back: one.feedback.is_some(),
            grade: grade.and_then(|grade| grade.score),
            grade_run: grade.and_then(|grade| grade.run).map(|run| run.to_string()),
            grade_problem: { grade.and_then(|grade| grade.problem.as_deref()) }
                .map(|problem| visible(problem).into_owned()),
            taken: taken.is_some_and(|taken| taken.source == one.source),
        }
    }
}

/// Requests, answers, tokens and cost.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AuthoringUsage {
    /// Questions, those that the store had an answer to among them.
    pub requests: u32,
    /// How many of them were answered.
    pub answers: u32,
    /// Answers that were in the store before; nothing was sent for them now.
    pub stored: u32,
    /// Tokens of all questions, as far as known.
    pub input_tokens: u64,
    /// Tokens of all answers, reasoning included, as far as known.
    pub output_tokens: u64,
    /// US dollars of all answers whose cost is known.
    pub usd: f64,
    /// Of these, dollars that had been paid before.
    pub usd_before: f64,
    /// Answers whose cost is not known.
    pub unpriced: u32,
}

impl AuthoringUsage {
    /// Adds an answer.
    pub fn add(&mut self, answer: &Answer) {
        let Consumed {
            input_tokens,
            output_tokens,
            cost_usd,
            ..
        } = answer.consumed;
        self.requests += 1;
        self.answers += u32::from(answer.arrived());
        self.stored += u32::from(answer.past.is_some());
        self.input_tokens = self.input_tokens.saturating_add(input_tokens.unwrap_or(0));
        self.output_tokens = self
            .output_tokens
            .saturating_add(output_tokens.unwrap_or(0));
        match cost_usd {
            Some(usd) => {
                self.usd += usd;
                if answer.past.is_some() {
                    self.usd_before += usd;
                }
            }
            None => self.unpriced += u32::from(answer.arrived()),
        }
    }

    /// Adds what others consumed.
    pub fn join(&mut self, other: &Self) {
        self.requests += other.requests;
        self.answers += other.answers;
        self.stored += other.stored;
        self.input_tokens = self.input_tokens.saturating_add(other.input_tokens);
        self.output_tokens = self.output_tokens.saturating_add(other.output_tokens);
        self.usd += other.usd;
        self.usd_before += other.usd_before;
        self.unpriced += other.unpriced;
    }
}

//! An author's output: attacks that passed the gate, and refused answers.

use super::feedback::is_wanted;
use super::{AuthoringUsage, Choice, Grade, Ranking};
use nearmiss_drive::generation::{
    AdmittedAttack, Attack, AttackSetup, Refusal, SearchResult, Selection, choose,
};
use nearmiss_scene::verdict::NewMotion;
use nearmiss_store::RunId;

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
    pub told: Option<String>,
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
    pub said: Option<NewMotion>,
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

    /// Drives the ego against every attack that it was not driven against yet, looks whether a good driver survives
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

    /// Of attacks that were driven against, the most dangerous one that a good driver survives: what a search gives,
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
                choose(ground.closed_loop, only, delay)
            }
            None => choose(ground.closed_loop, &attacks, delay),
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
    pub fn source_of(&self, attack: &Attack) -> Option<&AuthoredAttack> {
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
    /// Those whose first answer also had an effect that a good driver survives.
    pub first_effective: usize,
    /// Those that came to such an effect in the end.
    pub effective: usize,
}

//! An author's output: attacks that passed the gate, and refused answers.

use super::{AuthoringUsage, Choice};
use crate::generation::{
    AdmittedAttack, Attack, AttackSetup, Refusal, SearchResult, Selection, choose,
};
use crate::store::RunId;
use crate::verdict::NewMotion;

/// A model's complete output for one scenario.
#[derive(Debug, Clone)]
pub struct Authored {
    /// The choice of attacker.
    pub choice: Choice,
    /// Attacks, which all pass the gate; in the order of the conversations until they are driven.
    pub attacks: Vec<AuthoredAttack>,
    /// Answers that are none, with all reasons; also those that were mended later.
    pub declined: Vec<RefusedAnswer>,
    /// Total consumption, the choice included.
    pub spent: AuthoringUsage,
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
    /// The parsed motion, if it could be read.
    pub said: Option<NewMotion>,
    /// All that is wrong with it, never nothing; see [`crate::generation::summarize`] for few words.
    pub refusals: Vec<Refusal>,
}

impl Authored {
    pub(super) fn new(choice: Choice, spent: AuthoringUsage) -> Self {
        Self {
            choice,
            attacks: Vec::new(),
            declined: Vec::new(),
            spent,
            stopped: None,
        }
    }

    /// How many motions were answered, refused or not.
    #[must_use]
    pub fn candidates(&self) -> usize {
        self.attacks.len() + self.declined.len()
    }

    /// Drives the ego against every attack, looks whether a good driver survives those that have an effect with a
    /// reaction time of `delay` seconds, and puts the best one first. Before each attack `watch` hears how many were
    /// driven against, and says whether to go on. False where it said no: the attacks stay in their order then.
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
            ground.drive(attack);
            if attack.has_effect() {
                ground.survive(attack, delay);
            }
        }
        let cost = |one: &AuthoredAttack| one.admitted.attack.cost();
        self.attacks.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        true
    }

    /// Of attacks that were driven against, the most dangerous one that a good driver survives: what a search gives,
    /// too. Of each refused answer it has the first reason; [`Authored::refusals`] are all.
    #[must_use]
    pub fn taken(&self, ground: &AttackSetup<'_>, delay: f64) -> Selection {
        let all = self.attacks.iter();
        let attacks: Vec<Attack> = all.map(|a| a.admitted.attack.clone()).collect();
        let chosen = choose(ground.closed_loop, &attacks, delay);
        let first = |declined: &RefusedAnswer| declined.refusals.first().cloned();
        let found = SearchResult {
            attacks,
            refused: self.declined.iter().filter_map(first).collect(),
            candidates: self.candidates(),
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

    /// All refusals of all answers, those of a choice of the attacker first.
    #[must_use]
    pub fn refusals(&self) -> Vec<Refusal> {
        let choice = self.choice.proposal.iter();
        let choice = choice.filter_map(|proposal| proposal.refused.clone());
        let declined = self.declined.iter().flat_map(|d| d.refusals.clone());
        choice.chain(declined).collect()
    }
}

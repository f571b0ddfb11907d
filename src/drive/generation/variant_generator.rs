//! Generates a scenario's dangerous variant without a language model: with which effort, and how far it is.

use std::sync::Arc;

use nearmiss_scene::scenario::{Ego, Scenario};

use super::attack::AttackSetup;
use super::closed_loop_screening::NEAR_MISS;
use super::refusal::{RefusalSummary, summarize};
use super::{
    AllowedAttacks, Attack, AttackContext, AttackStyle, Change, ClosedLoop, Consequence, Gate,
    JointChange, Plausibility, RecordedMotions, Refusal, SelectedAttack, StagedDrive, attacker,
    staging,
};
use crate::simulation::{Collision, Outcome};

/// A scenario whose ego has been driven once, ready to be attacked.
#[derive(Debug)]
pub struct VariantGenerator {
    /// What drives the ego, and its drive in the scenario as it was recorded.
    pub closed: ClosedLoop,
    /// The ego of that drive.
    pub ego: Ego,
    style: AttackStyle,
    /// Recorded motions of its scenario; `None` where no obstacle moves in it.
    recorded: Option<Arc<RecordedMotions>>,
}

/// The generated attacks and the chosen one.
#[derive(Debug, Default)]
pub struct Selection {
    /// Everything that was tried.
    pub found: SearchResult,
    /// What was taken.
    pub chosen: Option<SelectedAttack>,
}

/// Progress events of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SearchEvent {
    /// A round has ended.
    Round(Progress),
    /// Ways out of the best attacks are searched for.
    Certifying,
}

/// Why no variant can be generated.
#[derive(Debug, thiserror::Error)]
pub enum GeneratorError {
    /// An ego that stands cannot be attacked.
    #[error("the planned ego never moves, so there is nothing to attack")]
    Stands,
}

impl VariantGenerator {
    /// Attacks the ego that was driven in a closed loop.
    ///
    /// # Errors
    /// [`GeneratorError::Stands`].
    pub fn from_closed_loop(closed: ClosedLoop) -> Result<Self, GeneratorError> {
        let driver = closed.driver();
        let baseline = closed.baseline().drive();
        let ego = baseline.ego(driver.problem(), driver.settings());
        let recorded = RecordedMotions::of_scenario(closed.scenario()).map(Arc::new);
        let workshop = Self {
            recorded,
            closed,
            ego,
            style: AttackStyle::default(),
        };
        workshop.stage().ok_or(GeneratorError::Stands)?;
        Ok(workshop)
    }

    /// The same with attackers of a style.
    #[must_use]
    pub fn of_style(self, style: AttackStyle) -> Self {
        Self { style, ..self }
    }

    /// How attackers move.
    #[must_use]
    pub fn style(&self) -> AttackStyle {
        self.style
    }

    fn stage(&self) -> Option<AttackContext<'_>> {
        self.stage_with(self.closed.scenario(), &self.ego, None)
    }

    /// The stage for attacks on an ego in the scenario, in which others may attack already.
    pub(super) fn stage_with<'a>(
        &self,
        scenario: &'a Scenario,
        ego: &'a Ego,
        others: Option<(&'a Attack, &'a StagedDrive)>,
    ) -> Option<AttackContext<'a>> {
        let stage = AttackContext::new(scenario, &ego.footprint, &ego.track)?;
        Some(AttackContext {
            others,
            // Who goes to the limits of a vehicle is not meant to drive like others.
            recorded: match self.style {
                AttackStyle::Human => self.recorded.clone(),
                AttackStyle::Limit => None,
            },
            ..stage.of_style(self.style)
        })
    }

    /// Gives the ground for attacks to `work`.
    ///
    /// # Errors
    /// The ego stands.
    pub fn on<T>(&self, work: impl FnOnce(&AttackSetup<'_>) -> T) -> Result<T, GeneratorError> {
        let stage = self.stage().ok_or(GeneratorError::Stands)?;
        let gate = self.gate();
        Ok(work(&AttackSetup {
            stage: &stage,
            gate: &gate,
            closed_loop: &self.closed,
        }))
    }

    /// Why no motion was tried, with the obstacles that alone might attack, where some are named, and the wish for them.
    #[must_use]
    pub fn why_untried(&self, among: &[i64], wish: Option<&str>) -> String {
        let why = self.on(|ground| attacker::why_none(ground.stage, among));
        match (why, wish) {
            (Err(error), _) => error.to_string(),
            (Ok(Some(why)), _) if among.is_empty() => format!("no obstacle can attack: {why}"),
            (Ok(Some(why)), _) => {
                let ids: Vec<String> = among.iter().map(i64::to_string).collect();
                format!("{} cannot attack: {why}", ids.join(" and "))
            }
            (Ok(None), Some(wish)) => format!("no obstacle fits the wish: {wish}"),
            (Ok(None), None) => "no manoeuvre brings an obstacle to the ego".into(),
        }
    }

    /// How plausible a change is beside the recorded motions of the scenario; `None` where no obstacle moves in those.
    #[must_use]
    pub fn plausibility(&self, change: &JointChange) -> Option<(Plausibility, &RecordedMotions)> {
        self.plausibility_of(change.changes())
    }

    /// The same of one of several changes.
    #[must_use]
    pub fn plausibility_of(&self, changes: &[Change]) -> Option<(Plausibility, &RecordedMotions)> {
        let scenario = self.closed.scenario();
        let recorded = self.recorded.as_deref()?;
        let motions = changes.iter().map(|change| change.motions.as_slice());
        let plausibility = recorded.plausibility(motions, &scenario.network);
        Some((plausibility, recorded))
    }

    /// What every changed motion has to pass.
    #[must_use]
    pub fn gate(&self) -> Gate<'_> {
        self.gate_with(self.closed.scenario(), &self.ego)
    }

    /// The gate of the scenario, in which others may attack already, beside an ego.
    pub(super) fn gate_with<'a>(&self, scenario: &'a Scenario, ego: &'a Ego) -> Gate<'a> {
        Gate::new(scenario).with_ego(ego).of_style(self.style)
    }

    /// The contact that the ego has in the original scenario: then that is not safe, and nothing is to be made
    /// dangerous.
    #[must_use]
    pub fn unsafe_already(&self) -> Option<Collision> {
        match self.closed.baseline().drive().outcome {
            Outcome::Collision(collision) => Some(collision),
            _ => None,
        }
    }

    /// Whether no obstacle comes near to the ego in the original: it touches none, and no risk score in it is that of
    /// a near miss or lower. Otherwise that is no safe scenario, and what is made of it proves less.
    #[must_use]
    pub fn is_safe(&self) -> bool {
        let lowest = self.closed.baseline().lowest();
        self.unsafe_already().is_none() && lowest.is_none_or(|score| score > NEAR_MISS)
    }

    /// Searches, and takes the most dangerous attack that an ideal driver survives, with as many attackers as it needs and
    /// the effort allows; only with what is allowed. `watch` hears how far that
    /// is, and says whether to go on. Nothing is tried where the original is not safe.
    ///
    /// # Errors
    /// The ego stands.
    pub fn search(
        &self,
        effort: &Effort,
        allowed: AllowedAttacks<'_>,
        watch: &mut dyn FnMut(SearchEvent) -> bool,
    ) -> Result<Selection, GeneratorError> {
        if self.unsafe_already().is_some() {
            return Ok(Selection::default());
        }
        self.stage().ok_or(GeneratorError::Stands)?;
        Ok(staging::search(self, effort, allowed, watch))
    }
}

/// Search effort.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Motions in all; more than [`Self::AT_FIRST`] are tried only where those lead to nothing that can be survived.
    pub candidates: usize,
    /// Rounds after each of which the search learns.
    pub rounds: usize,
    /// Closed loops in each round.
    pub drives: usize,
    /// Obstacles that are tried, those that need the least change.
    pub attackers: usize,
    /// At most so many obstacles attack together, 1 to [`super::MOST_ATTACKERS`].
    pub together: usize,
    /// An ideal driver has to survive it with this reaction time, seconds; one of [`super::DELAYS`].
    pub delay: f64,
    /// The seed of the random numbers.
    pub seed: u64,
}

impl Default for Effort {
    fn default() -> Self {
        Self {
            candidates: 3 * Self::AT_FIRST,
            rounds: 14,
            drives: 8,
            attackers: 6,
            together: 1,
            delay: 0.5,
            seed: 1,
        }
    }
}

impl Effort {
    /// Motions of the first search.
    pub const AT_FIRST: usize = 1500;

    /// The share of the first search that each attacker after the first gets.
    const SHARE: f64 = 0.5;

    /// Added to the seed for each further search: any other odd number would do.
    const ANOTHER_SEED: u64 = 0x9e37_79b9_7f4a_7c15;

    /// The effort for the first search.
    #[must_use]
    fn first(&self) -> Self {
        Self {
            candidates: self.candidates.min(Self::AT_FIRST),
            ..*self
        }
    }

    /// The efforts of the searches that follow each other while they find too little, each with random numbers of its
    /// own.
    pub fn searches(&self) -> impl Iterator<Item = Self> + use<> {
        let whole = *self;
        let many = self.candidates.div_ceil(Self::AT_FIRST).max(1);
        (0..many).map(move |n| Self {
            candidates: (whole.candidates - n * Self::AT_FIRST).min(Self::AT_FIRST),
            seed: whole
                .seed
                .wrapping_add(Self::ANOTHER_SEED.wrapping_mul(n as u64)),
            ..whole
        })
    }

    /// The effort for an attacker beside others.
    #[must_use]
    pub fn further(&self) -> Self {
        let part = |n: usize| ((n as f64 * Self::SHARE).round() as usize).max(1);
        Self {
            candidates: part(self.first().candidates),
            rounds: part(self.rounds),
            ..*self
        }
    }

    /// Motions for all attackers, at most.
    #[must_use]
    pub fn motions(&self) -> usize {
        self.candidates + self.together.saturating_sub(1) * self.further().candidates
    }
}

impl std::fmt::Display for Effort {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "search, seed {}, at most {} motions, survivable with {:.1} s reaction time",
            self.seed, self.candidates, self.delay
        )?;
        match self.together {
            0 | 1 => Ok(()),
            n => write!(f, ", at most {n} attackers"),
        }
    }
}

/// Result of a search.
#[derive(Debug, Default)]
pub struct SearchResult {
    /// Everything that passed the gate and comes near to the ego.
    pub attacks: Vec<Attack>,
    /// Refused motions, one reason each.
    pub refused: Vec<Refusal>,
    /// How many motions were tried.
    pub candidates: usize,
    /// What the drives and the searches for ways out took, see [`super::Effect::work`].
    pub work: usize,
}

/// Progress of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Progress {
    /// Motions that were tried.
    pub tried: usize,
    /// How many of them were refused.
    pub refused: usize,
    /// Against how many the ego was driven.
    pub driven: usize,
    /// The effect of the best attack.
    pub best: Option<Consequence>,
}

impl SearchResult {
    /// The best attack first.
    pub(super) fn sort(&mut self) {
        self.attacks.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
    }

    /// Adds what another search has found.
    pub(super) fn merge(&mut self, other: Self) {
        self.attacks.extend(other.attacks);
        self.refused.extend(other.refused);
        self.candidates += other.candidates;
        self.work += other.work;
        self.sort();
    }

    /// Why no motion passed the gate: the most frequent reason, with the worst case of it; nothing where one passed.
    #[must_use]
    pub fn all_refused(&self) -> Option<RefusalSummary> {
        let none = self.candidates > 0 && self.refused.len() == self.candidates;
        let reasons = summarize(&self.refused).into_iter();
        // Of equally frequent ones the first.
        reasons
            .filter(|_| none)
            .rev()
            .max_by_key(|reason| reason.count)
    }

    /// Drives that an error of the planner's process ended, and the first error; nothing without one.
    #[must_use]
    pub fn planner_errors(&self) -> Option<(usize, String)> {
        let drives = self
            .attacks
            .iter()
            .filter_map(|a| Some(&a.effect.as_ref()?.drive));
        let failed: Vec<_> = drives
            .filter(|drive| matches!(drive.outcome, Outcome::PlannerError(_)))
            .collect();
        let first = failed.first()?;
        let words = first
            .external
            .as_ref()
            .and_then(|r| r.failure())
            .unwrap_or_else(|| first.outcome.to_string());
        Some((failed.len(), words))
    }

    /// How far the search is that has found this.
    #[must_use]
    pub fn progress(&self) -> Progress {
        self.so_far(self.attacks.iter())
    }

    /// The same, where the attacks are still somewhere else.
    pub(super) fn so_far<'a>(&self, attacks: impl Iterator<Item = &'a Attack>) -> Progress {
        let driven: Vec<&Attack> = attacks.filter(|a| a.effect.is_some()).collect();
        let best = { driven.iter() }.min_by(|a, b| a.cost().total_cmp(&b.cost()));
        Progress {
            tried: self.candidates,
            refused: self.refused.len(),
            driven: driven.len(),
            best: best.and_then(|a| Some(a.effect.as_ref()?.consequence)),
        }
    }
}

impl Progress {
    /// Together with what was done after it.
    pub(super) fn and(self, later: Self) -> Self {
        let worse = |best: &Consequence| later.best.is_none_or(|now| best.is_worse_than(&now));
        Self {
            tried: self.tried + later.tried,
            refused: self.refused + later.refused,
            driven: self.driven + later.driven,
            best: self.best.filter(worse).or(later.best),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn searches_share_the_motions() {
        let whole = Effort {
            candidates: 2 * Effort::AT_FIRST + 90,
            ..Effort::default()
        };
        let all: Vec<Effort> = whole.searches().collect();
        let candidates: Vec<usize> = all.iter().map(|e| e.candidates).collect();
        assert_eq!(candidates, [Effort::AT_FIRST, Effort::AT_FIRST, 90]);
        assert_eq!(all[0].seed, whole.seed);
        assert!(all[1].seed != all[0].seed && all[2].seed != all[1].seed);
        for few in [0, 90] {
            let few = Effort {
                candidates: few,
                ..whole
            };
            assert_eq!(few.searches().collect::<Vec<_>>(), [few]);
        }
        let further = whole.further().searches();
        assert_eq!(further.count(), 1, "of a further attacker");
    }
}

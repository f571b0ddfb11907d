//! The effort of a search for attacks, what it has found, and how far it is.

use super::refusal::{RefusalSummary, summarize};
use super::{Attack, Consequence, Refusal};
use crate::simulation::Outcome;

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
    /// A good driver has to survive it with this reaction time, seconds; one of [`super::DELAYS`].
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

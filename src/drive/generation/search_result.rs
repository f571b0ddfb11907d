//! What a search for attacks has found, and how far it is.

use super::refusal_summary::{RefusalSummary, summarize};
use super::{Attack, Consequence, Refusal};
use crate::simulation::Outcome;

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

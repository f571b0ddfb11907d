//! The stretch of time steps that a description or a judgement looks at.

use std::ops::RangeInclusive;

use super::Scene;

/// Consecutive time steps, ends included; never empty, always inside the ego's recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Window {
    first: i64,
    last: i64,
}

impl Window {
    /// Steps that a recording goes on after the window of the safety task, as in "From Words to Collisions".
    pub const AFTER_SAFETY: i64 = 2;

    /// `history` steps (at least one) that end at `last`, cut to the ego's recording.
    #[must_use]
    pub fn ending_at(scene: &Scene, last: i64, history: usize) -> Self {
        let steps = scene.steps();
        let last = last.clamp(steps.start, (steps.end - 1).max(steps.start));
        let before = i64::try_from(history.max(1) - 1).unwrap_or(i64::MAX);
        Self {
            first: last.saturating_sub(before).max(steps.start),
            last,
        }
    }

    /// The first step.
    #[must_use]
    pub fn first(&self) -> i64 {
        self.first
    }

    /// The last step: the present of a judgement.
    #[must_use]
    pub fn last(&self) -> i64 {
        self.last
    }

    /// Every step.
    #[must_use]
    pub fn steps(&self) -> RangeInclusive<i64> {
        self.first..=self.last
    }
}

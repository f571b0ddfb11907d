//! The stretch of time steps that a description or a judgement looks at.

use std::ops::{Range, RangeInclusive};

use super::Scene;

/// Where the window of a question ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WindowEnd {
    /// With the recording.
    Recording,
    /// At the present step.
    Present,
    /// With the recording, and it begins with it.
    Whole,
}

/// How the window of a question is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WindowRule {
    /// Where it ends.
    pub end: WindowEnd,
    /// How many steps it has, where the recording has as many.
    pub history: usize,
}

impl WindowRule {
    /// The window of a question that is asked at the present step.
    #[must_use]
    pub fn at(&self, scene: &Scene, present: i64) -> Window {
        let last = match self.end {
            WindowEnd::Whole => return Window::whole(scene),
            WindowEnd::Recording => scene.last_step(),
            WindowEnd::Present => present,
        };
        Window::ending_at(scene, last, self.history)
    }
}

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
        Self::within(&scene.steps(), last, history)
    }

    /// Every step of the ego's recording.
    #[must_use]
    pub fn whole(scene: &Scene) -> Self {
        Self::ending_at(scene, scene.last_step(), usize::MAX)
    }

    /// The same, cut to these steps.
    #[must_use]
    pub fn within(steps: &Range<i64>, last: i64, history: usize) -> Self {
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

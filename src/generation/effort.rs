//! The effort of a search for attacks.

/// Search effort.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Motions in all.
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
            candidates: 1500,
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
    /// The share of it that each attacker after the first gets.
    const SHARE: f64 = 0.5;

    /// The effort for an attacker beside others.
    #[must_use]
    pub fn further(&self) -> Self {
        let part = |n: usize| ((n as f64 * Self::SHARE).round() as usize).max(1);
        Self {
            candidates: part(self.candidates),
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

//! The effort of a search for attacks.

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
            candidates: 2 * Self::AT_FIRST,
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

    /// Added to the seed for the second search: any other number would do.
    const ANOTHER_SEED: u64 = 0x9e37_79b9_7f4a_7c15;

    /// The effort for the first search.
    #[must_use]
    pub fn first(&self) -> Self {
        Self {
            candidates: self.candidates.min(Self::AT_FIRST),
            ..*self
        }
    }

    /// The effort for another search with new random numbers, where the first one found too little; `None` where no
    /// motions are left for it.
    #[must_use]
    pub fn second(&self) -> Option<Self> {
        let candidates = self.candidates.saturating_sub(Self::AT_FIRST);
        (candidates > 0).then(|| Self {
            candidates,
            seed: self.seed.wrapping_add(Self::ANOTHER_SEED),
            ..*self
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_search_has_what_the_first_left() {
        let whole = Effort::default();
        let (first, second) = (whole.first(), whole.second());
        assert_eq!(first.candidates, Effort::AT_FIRST);
        assert_eq!(first.seed, whole.seed);
        let second = second.map(|s| (s.candidates, s.seed == whole.seed));
        assert_eq!(second, Some((whole.candidates - Effort::AT_FIRST, false)));
        let few = Effort {
            candidates: 90,
            ..whole
        };
        assert_eq!((few.first(), few.second()), (few, None));
        assert_eq!(whole.further().second(), None, "of a further attacker");
    }
}

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

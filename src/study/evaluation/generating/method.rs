//! How a model is asked for attacks: votes, motions, retries, grades, and what decides between its motions.

use serde::{Deserialize, Serialize};

/// How often a model is asked, and what for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Method {
    /// Votes for the attacker, each an answer to the same question; 1 asks once.
    pub votes: u32,
    /// Attackers are chosen among obstacles whose centre is this near to the ego's, ahead of it or beside it, metres.
    pub within: f64,
    /// Number of motions requested, each in a separate conversation.
    pub samples: u32,
    /// How often, at most, a motion goes back to the model, in each conversation: with the reasons of a refusal, or
    /// with what came of the drive.
    pub retries: u32,
    /// Whether what came of the ego's drive goes back to the model.
    pub feedback: bool,
    /// Whether the model grades the motions that passed the gate (self-consistency).
    pub grades: bool,
    /// What decides between them.
    pub rank: Ranking,
}

/// Votes for the attacker by default.
pub const VOTES: u32 = 3;

/// Motions that are asked for by default.
pub const SAMPLES: u32 = 5;

/// How often a motion goes back to the model by default.
pub const RETRIES: u32 = 2;

/// What decides between motions that passed the gate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Ranking {
    /// The closed loop, exact risk scores, and whether a good driver survives.
    #[default]
    Exact,
    /// The model's own grades by the metrics prompt, the lowest first, as in the paper.
    Model,
}

impl Ranking {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Exact, Self::Model];

    /// Its name in options and documents.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Model => "model",
        }
    }

    /// The ranking of this name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|ranking| ranking.name() == name)
    }
}

impl Default for Method {
    fn default() -> Self {
        Self {
            votes: VOTES,
            within: nearmiss_drive::generation::attacker::ATTACKER_DISTANCE,
            samples: SAMPLES,
            retries: RETRIES,
            feedback: true,
            grades: true,
            rank: Ranking::Exact,
        }
    }
}

impl Method {
    /// Answers to requests for a motion, at most: in each conversation the first one and the retries.
    #[must_use]
    pub fn motions(&self) -> u32 {
        self.samples * (1 + self.retries)
    }

    /// Votes: none where the user names the attacker.
    #[must_use]
    pub fn votes_for(&self, attacker: Option<i64>) -> u32 {
        match attacker {
            Some(_) => 0,
            None => self.votes,
        }
    }

    /// Requests for grades, at most: one for each motion that can pass the gate.
    #[must_use]
    pub fn most_grades(&self) -> u32 {
        match (self.grades, self.feedback) {
            (false, _) => 0,
            (true, true) => self.motions(),
            // Without news of the drive a conversation ends with its first motion that passes.
            (true, false) => self.samples,
        }
    }

    /// Requests at most for one scenario.
    #[must_use]
    pub fn requests(&self, attacker: Option<i64>) -> u32 {
        self.votes_for(attacker) + self.motions() + self.most_grades()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_bounded_by_votes_motions_and_grades() {
        let method = Method {
            votes: 3,
            samples: 5,
            retries: 2,
            ..Method::default()
        };
        assert_eq!(method.requests(None), 3 + 15 + 15);
        assert_eq!(method.requests(Some(7)), 15 + 15);
        let as_before = Method {
            votes: 1,
            feedback: false,
            grades: false,
            ..method
        };
        assert_eq!(as_before.requests(None), 1 + 15);
        let graded = Method {
            grades: true,
            ..as_before
        };
        assert_eq!(graded.requests(None), 1 + 15 + 5);
    }
}

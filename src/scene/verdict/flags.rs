//! What makes a verdict doubtful by itself, and which obstacles it names as the danger.

use std::collections::HashSet;

use super::Verdict;

/// From this probability on the answer is yes, as prompts say it.
const YES: f64 = 0.5;

impl Verdict {
    /// What contradicts its yes or no: its probability, or the obstacles that it calls critical.
    #[must_use]
    pub fn contradictions(&self) -> Vec<String> {
        let word = self.word();
        let mut found = Vec::new();
        if let Some(p) = self.probability.filter(|p| (*p >= YES) != self.dangerous) {
            found.push(format!("says {word} with a probability of {p:.2}"));
        }
        let critical = self.critical.as_deref();
        if self.dangerous && critical.is_some_and(<[_]>::is_empty) {
            found.push(format!("says {word} and calls no obstacle critical"));
        }
        let mut likely = critical
            .unwrap_or_default()
            .iter()
            .filter(|one| one.probability.is_none_or(|p| p >= YES));
        if let Some(one) = likely.next().filter(|_| !self.dangerous) {
            found.push(format!(
                "says {word} and calls obstacle {} critical",
                one.id
            ));
        }
        found
    }

    /// Obstacles that it grades twice, or calls critical twice.
    #[must_use]
    pub fn named_twice(&self) -> Vec<i64> {
        let graded: Vec<i64> = self.obstacles.iter().map(|one| one.id).collect();
        let critical: Vec<i64> = self.critical.iter().flatten().map(|one| one.id).collect();
        let mut twice: Vec<i64> = [graded, critical]
            .iter()
            .flat_map(|ids| again(ids))
            .collect();
        twice.sort_unstable();
        twice.dedup();
        twice
    }

    /// All of that, with the obstacles that the scene does not have, in words.
    #[must_use]
    pub fn flags(&self) -> Vec<String> {
        let mut flags = self.contradictions();
        flags.extend(
            self.named_twice()
                .iter()
                .map(|id| format!("names obstacle {id} twice")),
        );
        flags.extend(self.unknown.iter().copied().map(Self::names_unknown));
        flags
    }

    /// The words for an obstacle that the scene does not have.
    #[must_use]
    pub fn names_unknown(id: i64) -> String {
        format!("names obstacle {id}, which is not in the scene")
    }
}

/// Those that stand in a list already.
fn again(ids: &[i64]) -> Vec<i64> {
    let mut seen = HashSet::new();
    ids.iter().copied().filter(|id| !seen.insert(*id)).collect()
}

impl Verdict {
    /// The obstacles that it names as the danger: the critical ones of a yes. An answer without a list of critical
    /// obstacles, such as those recorded with the paper, names them by its risk scores.
    #[must_use]
    pub fn danger(&self) -> Vec<i64> {
        match &self.critical {
            Some(critical) if self.dangerous => critical.iter().map(|c| c.id).collect(),
            Some(_) => Vec::new(),
            None => self.danger_by_scores(),
        }
    }

    /// The paper's rule: those that collide or are of extreme risk, the scores 0 and 1. Where a yes gives no obstacle
    /// so low a score, as for a collision that is predicted for later, those with score 2.
    fn danger_by_scores(&self) -> Vec<i64> {
        let lowest = self.obstacles.iter().map(|o| o.risk_score).min();
        let most = match lowest {
            Some(PREDICTED) if self.dangerous => PREDICTED,
            _ => EXTREME,
        };
        let named = self.obstacles.iter().filter(|o| o.risk_score <= most);
        named.map(|o| o.id).collect()
    }
}

/// The risk scores of extreme risk, and the highest one of a collision that is only predicted.
const EXTREME: u8 = 1;
const PREDICTED: u8 = 2;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::{CriticalObstacle, ObstacleRisk, Task};

    fn verdict(
        dangerous: bool,
        probability: Option<f64>,
        critical: Option<&[(i64, f64)]>,
    ) -> Verdict {
        let one = |(id, p): &(i64, f64)| CriticalObstacle {
            id: *id,
            probability: Some(*p),
        };
        Verdict {
            task: Task::Safety,
            dangerous,
            obstacles: Vec::new(),
            justification: String::new(),
            critical: critical.map(|all| all.iter().map(one).collect()),
            probability,
            token_probability: None,
            unknown: Vec::new(),
        }
    }

    #[test]
    fn yes_no_probability_and_critical_obstacles_are_held_against_each_other() {
        for sound in [
            verdict(true, Some(0.5), Some(&[(7, 0.4)])),
            verdict(false, Some(0.49), Some(&[(7, 0.3)])),
            verdict(true, None, None),
            verdict(false, None, Some(&[])),
        ] {
            assert_eq!(sound.flags(), [""; 0], "{sound:?}");
        }
        let says = |verdict: Verdict| verdict.flags().join("; ");
        assert_eq!(
            says(verdict(true, Some(0.01), Some(&[]))),
            "says safety-critical with a probability of 0.01; says safety-critical and calls no obstacle critical"
        );
        assert_eq!(
            says(verdict(false, Some(0.1), Some(&[(7, 0.2), (9, 0.9)]))),
            "says not critical and calls obstacle 9 critical"
        );
        let mut named = verdict(true, None, Some(&[(7, 0.9), (7, 0.8)]));
        let graded = |id| ObstacleRisk {
            id,
            risk_score: 2,
            reason: String::new(),
            written_score: None,
        };
        named.obstacles = vec![graded(9), graded(9), graded(9), graded(7)];
        named.unknown = vec![429];
        assert_eq!(
            says(named),
            "names obstacle 7 twice; names obstacle 9 twice; names obstacle 429, which is not in the scene"
        );
    }
}

#[cfg(test)]
mod naming_tests {
    use crate::verdict::{CriticalObstacle, ObstacleRisk, Task, Verdict};

    fn verdict(dangerous: bool, scores: &[(i64, u8)], critical: Option<&[i64]>) -> Verdict {
        let risk = |&(id, risk_score): &(i64, u8)| ObstacleRisk {
            id,
            risk_score,
            reason: String::new(),
            written_score: None,
        };
        let of = |ids: &[i64]| ids.iter().copied().map(CriticalObstacle::new).collect();
        Verdict {
            task: Task::Safety,
            dangerous,
            obstacles: scores.iter().map(risk).collect(),
            justification: String::new(),
            critical: critical.map(of),
            probability: None,
            token_probability: None,
            unknown: Vec::new(),
        }
    }

    #[test]
    fn a_yes_names_its_critical_obstacles_whatever_their_scores() {
        let scores = [(7, 4), (8, 1)];
        assert_eq!(verdict(true, &scores, Some(&[7])).danger(), [7]);
        assert_eq!(verdict(true, &scores, Some(&[])).danger(), [0; 0]);
        assert_eq!(verdict(false, &scores, Some(&[7])).danger(), [0; 0]);
        assert_eq!(
            verdict(true, &scores, Some(&[7, 9])).foremost(),
            Some((7, Some(4)))
        );
        assert_eq!(
            verdict(false, &scores, Some(&[7])).foremost(),
            Some((8, Some(1)))
        );
    }

    #[test]
    fn without_a_list_the_risk_scores_name() {
        assert_eq!(verdict(true, &[(7, 2), (8, 1)], None).danger(), [8]);
        assert_eq!(verdict(true, &[(7, 2), (8, 3)], None).danger(), [7]);
        assert_eq!(verdict(false, &[(7, 2), (8, 3)], None).danger(), [0; 0]);
        assert_eq!(verdict(false, &[(7, 1)], None).danger(), [7]);
    }
}

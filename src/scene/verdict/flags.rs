//! What makes a verdict doubtful by itself: it contradicts itself, or names an obstacle twice or one that is not there.

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

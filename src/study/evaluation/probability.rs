//! The probability of a yes that a verdict stands for, and where it is from.

use serde::Serialize;

use nearmiss_scene::verdict::{ObstacleRisk, Verdict};

/// Where the probability of a verdict is from, in the order in which they are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ProbabilitySource {
    /// The answer states it.
    Stated,
    /// The largest of its critical obstacles.
    Critical,
    /// The log probabilities of the tokens with which the answer decides.
    Token,
    /// 1 − score/5 of its gravest obstacle, by the scores that the model wrote.
    Score,
    /// Its yes or no, 1 or 0.
    Decision,
}

impl ProbabilitySource {
    /// Every source, in order.
    pub const ALL: [Self; 5] = [
        Self::Stated,
        Self::Critical,
        Self::Token,
        Self::Score,
        Self::Decision,
    ];
}

/// The probability of a yes that a verdict stands for: every verdict has one.
///
/// The paper gives its scores 0 (collision) to 5 (negligible) no probabilities; the straight line between both ends is a
/// convention.
#[must_use]
pub fn probability(verdict: &Verdict) -> (f64, ProbabilitySource) {
    let critical = verdict
        .critical
        .iter()
        .flatten()
        .filter_map(|c| c.probability)
        .reduce(f64::max);
    let score = || {
        // What the model wrote: the grade of a group is this program's reading.
        let scores = verdict.obstacles.iter().map(ObstacleRisk::stated_score);
        Some(1.0 - f64::from(scores.min()?.min(5)) / 5.0)
    };
    if let Some(stated) = verdict.probability {
        (stated, ProbabilitySource::Stated)
    } else if let Some(largest) = critical {
        (largest, ProbabilitySource::Critical)
    } else if let Some(of_tokens) = verdict.token_probability {
        (of_tokens, ProbabilitySource::Token)
    } else if let Some(of_score) = score() {
        (of_score, ProbabilitySource::Score)
    } else {
        (
            f64::from(u8::from(verdict.dangerous)),
            ProbabilitySource::Decision,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::ProbabilitySource::{Critical, Decision, Score, Stated, Token};
    use super::*;
    use nearmiss_scene::verdict::{CriticalObstacle, Task};

    #[test]
    fn every_verdict_has_a_probability() {
        let risk = |id, risk_score| ObstacleRisk {
            id,
            risk_score,
            reason: String::new(),
            written_score: None,
        };
        let critical = |probability| CriticalObstacle {
            id: 7,
            probability: Some(probability),
        };
        let mut verdict = Verdict {
            task: Task::Safety,
            dangerous: true,
            obstacles: vec![risk(7, 4), risk(8, 1)],
            justification: String::new(),
            critical: Some(vec![critical(0.3), critical(0.6)]),
            probability: Some(0.7),
            token_probability: None,
            unknown: Vec::new(),
        };
        assert_eq!(probability(&verdict), (0.7, Stated));
        verdict.probability = None;
        assert_eq!(probability(&verdict), (0.6, Critical));
        verdict.critical = Some(vec![CriticalObstacle::new(7)]);
        verdict.token_probability = Some(0.95);
        assert_eq!(probability(&verdict), (0.95, Token));
        verdict.token_probability = None;
        assert_eq!(probability(&verdict), (0.8, Score));
        verdict.obstacles[1].written_score = Some(3);
        let (graded, source) = probability(&verdict);
        assert!((graded - 0.4).abs() < 1e-12 && source == Score, "{graded}");
        verdict.obstacles.clear();
        assert_eq!(probability(&verdict), (1.0, Decision));
        verdict.dangerous = false;
        assert_eq!(probability(&verdict), (0.0, Decision));
    }
}

//! Which obstacles a verdict names as the danger.

use super::Verdict;

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

//! Summarizes many refusals of one motion: the worst of each reason.

use super::Refusal;

/// All refusals for one reason.
#[derive(Debug, Clone, PartialEq)]
pub struct RefusalSummary {
    /// The one that is farthest above its limit; of those without numbers the first.
    pub worst: Refusal,
    /// How many there are.
    pub count: usize,
    /// The first step of them, where they concern steps.
    pub first: Option<i64>,
}

/// Refusals summed up by their reasons, in the order in which these come first.
#[must_use]
pub fn summarize(refusals: &[Refusal]) -> Vec<RefusalSummary> {
    let mut all: Vec<RefusalSummary> = Vec::new();
    for refusal in refusals {
        let same = |s: &&mut RefusalSummary| s.worst.reason == refusal.reason;
        let Some(known) = all.iter_mut().find(same) else {
            all.push(RefusalSummary {
                worst: refusal.clone(),
                count: 1,
                first: refusal.step,
            });
            continue;
        };
        known.count += 1;
        if excess(refusal) > excess(&known.worst) {
            known.worst = refusal.clone();
        }
    }
    all
}

/// How many times the limit is exceeded.
fn excess(refusal: &Refusal) -> f64 {
    let value = refusal.value.unwrap_or(0.0);
    let limit = refusal.limit.unwrap_or(0.0);
    value.abs() / limit.abs().max(1e-12)
}

impl std::fmt::Display for RefusalSummary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.worst)?;
        match (self.count, self.first) {
            (1, _) => Ok(()),
            (count, Some(first)) => write!(f, ", the worst of {count} steps from {first} on"),
            (count, None) => write!(f, ", {count} times"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Reason;
    use super::*;

    #[test]
    fn why_nothing_passed_is_the_most_frequent_reason() {
        let jerk = |step, value| Refusal::at(step, Reason::Jerk).with(value, 30.0);
        let refused = vec![
            Refusal::at(9, Reason::Overlap(7)),
            jerk(3, 40.0),
            jerk(4, 90.0),
        ];
        let mut found = super::super::SearchResult {
            candidates: refused.len(),
            refused,
            ..Default::default()
        };
        let why = found.all_refused().map(|why| (why.count, why.worst.step));
        assert_eq!(why, Some((2, Some(4))));
        found.candidates += 1;
        assert_eq!(found.all_refused(), None, "one passed");
    }

    #[test]
    fn of_each_reason_the_worst_is_told() {
        let jerk = |step, value| Refusal::at(step, Reason::Jerk).with(value, 30.0);
        let overlap = Refusal::at(9, Reason::Overlap(7));
        let all = [jerk(3, 40.0), overlap.clone(), jerk(4, 90.0), jerk(5, 50.0)];
        let summed = summarize(&all);
        assert_eq!((summed[0].worst.step, summed[0].count), (Some(4), 3));
        let words: Vec<String> = summed.iter().map(ToString::to_string).collect();
        assert_eq!(
            words,
            [
                "step 4: jerk 90.0000 m/s³, at most 30.0000, the worst of 3 steps from 3 on",
                "step 9: overlap with 7"
            ]
        );
    }
}

//! How often answers name the obstacles that are truly critical, and only those.

use std::collections::BTreeMap;

use super::statistics::{Interval, scenario_interval};
use super::{AnswerStatus, Label, Scored};

/// Counts of named obstacles beside the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Naming {
    /// Verdicts on dangerous windows whose critical obstacles are known.
    pub windows: u32,
    /// Of them those that name one of these obstacles.
    pub found: u32,
    /// Of them those that give one of these obstacles the gravest risk score.
    pub first: u32,
    /// Obstacles named by verdicts, over these windows and the safe ones.
    pub named: u32,
    /// Of them those that are truly critical; on a safe window none is.
    pub right: u32,
}

/// Intervals of 95 % over units, see [`Scored::unit`] and [`scenario_interval`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NamingIntervals {
    /// Of [`Naming::recall`].
    pub recall: Option<Interval>,
    /// Of [`Naming::precision`].
    pub precision: Option<Interval>,
}

impl NamingIntervals {
    /// From the answers that are counted.
    #[must_use]
    pub fn from_scored<'a>(answers: impl IntoIterator<Item = &'a Scored>) -> Self {
        let mut units: BTreeMap<&str, Naming> = BTreeMap::new();
        for one in answers {
            units.entry(one.unit()).or_default().count(one);
        }
        let of = |part: fn(&Naming) -> (u32, u32)| {
            let counts: Vec<(u32, u32)> = units.values().map(part).collect();
            scenario_interval(&counts)
        };
        Self {
            recall: of(|naming| (naming.found, naming.windows)),
            precision: of(|naming| (naming.right, naming.named)),
        }
    }
}

impl Naming {
    /// Counts an answer. Without a verdict or a truth, or where it is not known who is critical, it tells nothing.
    pub fn count(&mut self, one: &Scored) {
        let (AnswerStatus::Verdict(verdict), Some(truth)) = (&one.status, one.truth) else {
            return;
        };
        if truth.collides() && one.critical.is_empty() {
            return;
        }
        let named = verdict.danger();
        let right = named.iter().filter(|id| one.critical.contains(id)).count();
        self.named += named.len() as u32;
        self.right += right as u32;
        if truth == Label::Safe {
            return;
        }
        self.windows += 1;
        self.found += u32::from(right > 0);
        let gravest = verdict.worst().map(|o| o.risk_score);
        let mut all = verdict.obstacles.iter();
        let first = all.any(|o| Some(o.risk_score) == gravest && one.critical.contains(&o.id));
        self.first += u32::from(first);
    }

    /// Adds the counts of other answers.
    pub fn add(&mut self, other: &Self) {
        self.windows += other.windows;
        self.found += other.found;
        self.first += other.first;
        self.named += other.named;
        self.right += other.right;
    }

    /// The share of dangerous windows with known critical obstacles of which one is named.
    #[must_use]
    pub fn recall(&self) -> Option<f64> {
        share(self.found, self.windows)
    }

    /// The share of the named obstacles that are truly critical.
    #[must_use]
    pub fn precision(&self) -> Option<f64> {
        share(self.right, self.named)
    }
}

fn share(part: u32, all: u32) -> Option<f64> {
    (all > 0).then(|| f64::from(part) / f64::from(all))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::tests_scored::{answer, failed};
    use nearmiss_scene::verdict::CriticalObstacle;

    fn says(dangerous: bool, named: &[i64], truth: Option<Label>) -> Scored {
        let mut scored = answer("a", "m/x", dangerous, &[(7, 4), (8, 1)]);
        if let AnswerStatus::Verdict(verdict) = &mut scored.status {
            verdict.critical = Some(named.iter().copied().map(CriticalObstacle::new).collect());
        }
        scored.set_truth(truth.map(|label| (label, label.critical())));
        scored
    }

    #[test]
    fn who_is_named_is_told_from_yes_and_no() {
        let hit = Some(Label::Collision(Some(7)));
        let all = [
            says(true, &[7], hit),
            says(true, &[7, 8], hit),
            says(true, &[8], hit),
            says(false, &[7], hit),
            // On a safe window every name is wrong.
            says(true, &[7], Some(Label::Safe)),
            says(false, &[], Some(Label::Safe)),
            // It is not known who it is.
            says(true, &[7], Some(Label::Collision(None))),
            says(true, &[7], None),
            failed("a", "m/x"),
        ];
        let mut naming = Naming::default();
        all.iter().for_each(|one| naming.count(one));
        let wanted = Naming {
            windows: 4,
            found: 2,
            first: 0,
            named: 5,
            right: 2,
        };
        assert_eq!(naming, wanted);
        assert_eq!(
            (naming.recall(), naming.precision()),
            (Some(0.5), Some(0.4))
        );
        assert_eq!(all[2].positive(), Some(true), "a yes is a yes");
    }
    #[test]
    fn intervals_are_over_scenarios() {
        let hit = Some(Label::Collision(Some(7)));
        let answers = |samples: usize| -> Vec<Scored> {
            let of = |n: usize| {
                let mut one = says(true, if n.is_multiple_of(3) { &[8] } else { &[7, 8] }, hit);
                one.scenario = format!("S-{n}");
                one
            };
            (0..12)
                .flat_map(|n| (0..samples).map(move |_| of(n)))
                .collect()
        };
        let (once, often) = (
            NamingIntervals::from_scored(&answers(1)),
            NamingIntervals::from_scored(&answers(5)),
        );
        assert_eq!(once.recall, super::super::statistics::wilson(8, 12));
        // Obstacles of one answer are not independent either.
        assert_eq!(once.precision, often.precision);
        assert!(once.precision.is_some_and(|i| i.low < 0.4 && i.high > 0.4));
    }
}

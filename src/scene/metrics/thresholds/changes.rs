//! The changes that a thresholds file makes, in words and as data.

use super::super::{LIMITS, measure};
use super::Thresholds;

/// An entry that a file of thresholds sets.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// The entry: `threshold ttc critical`, `risk 1 distance`, `limit tau`.
    pub entry: String,
    /// To what, in the unit.
    pub value: f64,
    /// The unit; empty where there is none.
    pub unit: &'static str,
}

impl std::fmt::Display for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.entry, self.value)?;
        match self.unit {
            "" => Ok(()),
            unit => write!(f, " {unit}"),
        }
    }
}

impl Thresholds {
    /// Every value that the user's file sets, of risk scores those that it changes, in the order of thresholds, risk
    /// scores, limits.
    #[must_use]
    pub fn changes(&self) -> Vec<Change> {
        let critical = self.critical.iter().filter(|t| t.own).map(|t| Change {
            entry: format!("threshold {} {}", t.measure, t.name),
            value: t.value,
            unit: measure(&t.measure).map_or("", |m| m.unit),
        });
        let levels = self.risk.levels.iter().zip(&Self::shipped().risk.levels);
        let bounds = levels.flat_map(|(own, shipped)| {
            let bound = |key: &str, own_bound: Option<f64>, shipped: Option<f64>, unit| {
                let value = own_bound.filter(|_| own_bound != shipped)?;
                let entry = format!("risk {} {key}", own.score);
                Some(Change { entry, value, unit })
            };
            [
                bound("distance", own.distance, shipped.distance, "m"),
                bound("time", own.time, shipped.time, "s"),
            ]
        });
        let limits = LIMITS
            .iter()
            .filter(|l| self.own_limit(l))
            .map(|limit| Change {
                entry: format!("limit {}", limit.id),
                value: limit.value(&self.limits),
                unit: limit.unit,
            });
        critical.chain(bounds.flatten()).chain(limits).collect()
    }
}

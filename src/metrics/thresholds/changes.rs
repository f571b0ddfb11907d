//! What a file of thresholds changes, in words and as data.

use super::super::{LIMITS, measure};
use super::Thresholds;

/// An entry that a file of thresholds sets.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// What: `threshold ttc critical`, `risk 1 distance`, `limit tau`.
    pub entry: String,
    /// To what, in the unit.
    pub value: f64,
    /// The unit; empty where there is none.
    pub unit: &'static str,
}

impl Thresholds {
    /// Every entry that the user's file sets, in the order of thresholds, risk scores, limits.
    #[must_use]
    pub fn changes(&self) -> Vec<Change> {
        let critical = self.critical.iter().filter(|t| t.own).map(|t| Change {
            entry: format!("threshold {} {}", t.measure, t.name),
            value: t.value,
            unit: measure(&t.measure).map_or("", |m| m.unit),
        });
        let levels = self.risk.levels.iter();
        let bounds = levels.filter(|l| self.own_level(l.score)).flat_map(|own| {
            let bound = |key: &str, value: Option<f64>, unit| {
                value.map(|value| Change {
                    entry: format!("risk {} {key}", own.score),
                    value,
                    unit,
                })
            };
            [
                bound("distance", own.distance, "m"),
                bound("time", own.time, "s"),
            ]
        });
        let limits = LIMITS.iter().filter(|l| self.own_limit(l));
        let limits = limits.map(|limit| Change {
            entry: format!("limit {}", limit.id),
            value: limit.of(&self.limits),
            unit: limit.unit,
        });
        critical.chain(bounds.flatten()).chain(limits).collect()
    }
}

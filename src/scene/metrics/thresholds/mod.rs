//! From where on values are dangerous, and the limits behind measures: as shipped, or as a file changes them.

mod file;

use std::sync::LazyLock;

use serde::Deserialize;

use super::limits::Limits;
use super::own::own_thresholds;
use super::{LIMITS, Limit, Measure, RISK_LEVELS, RiskTable, measure};

pub use file::ThresholdError;

/// A critical value of a measure.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Threshold {
    /// Id of the measure.
    pub measure: String,
    /// In the measure's unit.
    pub value: f64,
    /// Its name.
    pub name: String,
    /// Source of the threshold.
    pub source: String,
    /// Whether the value itself is not dangerous yet.
    #[serde(default)]
    pub strict: bool,
    /// Whether it comes from the user's file.
    #[serde(skip)]
    pub own: bool,
}

impl Threshold {
    /// Whether a value of its measure is there or beyond.
    #[must_use]
    pub fn reached(&self, measure: &Measure, value: f64) -> bool {
        measure.danger.reaches(value, self.value) && !(self.strict && value == self.value)
    }
}

/// Critical values, the table of risk scores, and the limits of vehicles and drivers that measures are computed with.
///
/// The convention of the paper ([`super::paper`]) has its own, which nothing changes.
#[derive(Debug, Clone, PartialEq)]
pub struct Thresholds {
    /// In the order of the measures' files; of one measure, the most dangerous first.
    critical: Vec<Threshold>,
    /// Gaps and times of the risk scores.
    pub risk: RiskTable,
    /// The assumed limits of vehicles and drivers.
    pub limits: Limits,
    /// The user's file.
    file: Option<String>,
    /// Scores whose level the file changes.
    own_levels: Vec<u8>,
    /// Ids of the limits that the file sets.
    own_limits: Vec<&'static str>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Shipped {
    threshold: Vec<Threshold>,
}

static SHIPPED: LazyLock<Thresholds> = LazyLock::new(|| {
    let shipped: Shipped = toml::from_str(include_str!("shipped.toml"))
        // A test reads the file.
        .expect("the program's own thresholds are right");
    Thresholds {
        critical: shipped
            .threshold
            .into_iter()
            .chain(own_thresholds().cloned())
            .collect(),
        risk: RISK_LEVELS.clone(),
        limits: Limits::SHIPPED,
        file: None,
        own_levels: Vec::new(),
        own_limits: Vec::new(),
    }
});

impl Thresholds {
    /// The shipped thresholds.
    #[must_use]
    pub fn shipped() -> &'static Self {
        &SHIPPED
    }

    /// The critical values of a measure, the most dangerous first.
    pub fn for_measure(&self, measure: &str) -> impl Iterator<Item = &Threshold> {
        self.critical.iter().filter(move |t| t.measure == measure)
    }

    /// The most dangerous threshold that a value of a measure is at or beyond.
    #[must_use]
    pub fn reached(&self, measure: &Measure, value: f64) -> Option<&Threshold> {
        self.for_measure(measure.id)
            .find(|t| t.reached(measure, value))
    }

    /// The file that changes them; none for those that come with the program.
    #[must_use]
    pub fn file(&self) -> Option<&str> {
        self.file.as_deref()
    }

    /// Whether the file sets this limit.
    #[must_use]
    pub fn own_limit(&self, limit: &Limit) -> bool {
        self.own_limits.contains(&limit.id)
    }

    /// Whether the file changes the level of this risk score.
    #[must_use]
    pub fn own_level(&self, score: u8) -> bool {
        self.own_levels.contains(&score)
    }
}

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
    /// The same as [`Self::changes`] in words.
    #[must_use]
    pub fn change_words(&self) -> Vec<String> {
        let changes = self.changes();
        changes.iter().map(ToString::to_string).collect()
    }

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

#[cfg(test)]
mod tests {
    use super::super::{MEASURES, measure};
    use super::*;

    #[test]
    fn each_belongs_to_a_measure_and_says_who_says_so() {
        let shipped = Thresholds::shipped();
        for threshold in &shipped.critical {
            let measure = measure(&threshold.measure);
            assert!(
                measure.is_some_and(|m| m.danger != super::super::Danger::Neutral)
                    && !threshold.source.is_empty(),
                "{threshold:?}"
            );
        }
        assert_eq!(shipped.for_measure("ttc").count(), 2);
        assert_eq!(shipped.file(), None);
        for measure in MEASURES {
            let values: Vec<f64> = shipped.for_measure(measure.id).map(|t| t.value).collect();
            let ordered = |pair: &[f64]| measure.danger.compare(pair[0], pair[1]).is_lt();
            assert!(values.windows(2).all(ordered), "{}", measure.id);
        }
    }

    #[test]
    fn the_most_dangerous_one_that_is_reached_counts() {
        let shipped = Thresholds::shipped();
        let name = |id: &str, value: f64| {
            let reached = measure(id).and_then(|m| shipped.reached(m, value));
            reached.map(|t| t.name.as_str())
        };
        assert_eq!(name("ttc", 1.5), Some("critical"));
        assert_eq!(name("ttc", 1.6), Some("conflict"));
        assert_eq!(name("ttc", 3.1), None);
        assert_eq!(name("drac", 3.0), Some("conflict"));
        assert_eq!(name("drac", 2.9), None);
        assert_eq!(name("rss_margin", 0.0), None, "exactly enough");
        assert_eq!(name("rss_margin", -1e-9), Some("dangerous"));
        assert_eq!(name("rss_lat_margin", -1.0), None, "alone it is no danger");
    }
}

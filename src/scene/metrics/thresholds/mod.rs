//! From where on values are dangerous, and the limits behind measures: as shipped, or as a file of the user's says.

mod changes;
mod entries;
mod file;

use std::sync::LazyLock;

use serde::Deserialize;

use super::limits::Limits;
use super::{Limit, Measure, RISK_LEVELS, RiskTable};

pub use changes::Change;
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
        critical: shipped.threshold,
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

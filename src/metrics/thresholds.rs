//! Values of measures that the literature calls critical, as data.

use std::sync::LazyLock;

use serde::Deserialize;

/// A critical value of a measure.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Threshold {
    /// Id of the measure.
    pub measure: String,
    /// In the measure's unit.
    pub value: f64,
    /// What it is called.
    pub name: String,
    /// Who says so.
    pub source: String,
}

#[derive(Deserialize)]
struct File {
    threshold: Vec<Threshold>,
}

static THRESHOLDS: LazyLock<Vec<Threshold>> = LazyLock::new(|| {
    let file: File = toml::from_str(include_str!("thresholds.toml"))
        // A test reads the file.
        .expect("the program's own thresholds are right");
    file.threshold
});

/// The critical values of a measure, in the order of the file.
pub fn thresholds(measure: &str) -> impl Iterator<Item = &'static Threshold> {
    THRESHOLDS.iter().filter(move |t| t.measure == measure)
}

#[cfg(test)]
mod tests {
    use super::super::MEASURES;
    use super::*;

    #[test]
    fn each_belongs_to_a_measure_and_says_who_says_so() {
        for threshold in THRESHOLDS.iter() {
            let known = MEASURES.iter().any(|m| m.id == threshold.measure);
            assert!(known && !threshold.source.is_empty(), "{threshold:?}");
        }
        assert_eq!(thresholds("ttc").count(), 2);
    }
}

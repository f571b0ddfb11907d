//! Requirements that a report must meet: `f1 >= 0.8`, `model/x: recall > 0.9`.

use std::str::FromStr;

use serde_json::Value;

use super::PromptConfig;
use super::report::{Report, is_called, name_of};
use nearmiss_base::system::{available, unknown};
use nearmiss_scene::judge;

/// What can be required: the names of CSV and JSON, with the place of each in a cell's JSON.
const METRICS: [(&str, &str); 37] = [
    ("n", "/n"),
    ("scenarios", "/scenarios"),
    ("tp", "/tp"),
    ("fp", "/fp"),
    ("fn", "/fn"),
    ("tn", "/tn"),
    ("asked", "/asked"),
    ("right", "/right"),
    ("right_of_all", "/right_of_all"),
    ("unparsed", "/unparsed"),
    ("failed", "/failed"),
    ("unasked", "/unasked"),
    ("unlabelled", "/unlabelled"),
    ("contradictory", "/contradictory"),
    ("named_twice", "/named_twice"),
    ("unknown_obstacles", "/unknown_obstacles"),
    ("precision", "/precision"),
    ("recall", "/recall"),
    ("specificity", "/specificity"),
    ("accuracy", "/accuracy"),
    ("f1", "/f1"),
    ("kappa", "/kappa"),
    ("agreement_with_reference", "/agreement_with_reference"),
    ("naming_recall", "/naming_recall"),
    ("naming_precision", "/naming_precision"),
    ("brier", "/calibration/brier"),
    ("auroc", "/calibration/auroc"),
    ("expected_error", "/calibration/expected_error"),
    ("majority_f1", "/samples/majority_f1"),
    ("unanimous", "/samples/unanimous"),
    ("all_right", "/samples/all_right"),
    ("seconds_median", "/seconds_median"),
    ("seconds_p95", "/seconds_p95"),
    ("input_tokens", "/input_tokens"),
    ("output_tokens", "/output_tokens"),
    ("cost_usd", "/cost_usd"),
    ("cost_unknown", "/cost_unknown"),
];

/// How a value is compared with its bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Comparator {
    AtLeast,
    Above,
    AtMost,
    Below,
    Equal,
}

/// Two letters first, so that `>=` is not read as `>`.
const COMPARATORS: [(&str, Comparator); 6] = [
    (">=", Comparator::AtLeast),
    ("<=", Comparator::AtMost),
    ("==", Comparator::Equal),
    (">", Comparator::Above),
    ("<", Comparator::Below),
    ("=", Comparator::Equal),
];

/// What every way of asking, or a named one, must reach.
#[derive(Debug, Clone, PartialEq)]
pub struct Requirement {
    /// A model or a prompt configuration, as tables name it; `None` for all.
    way: Option<String>,
    metric: &'static str,
    pointer: &'static str,
    comparator: Comparator,
    bound: f64,
    text: String,
}

/// What came of a requirement for one way of asking.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// What was required.
    pub requirement: String,
    /// Of whom, as tables name it.
    pub way: String,
    /// What was found, for people.
    pub found: String,
    /// Whether it is met.
    pub is_met: bool,
}

impl std::fmt::Display for Check {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let word = if self.is_met { "met" } else { "not met" };
        write!(
            f,
            "{word}: {} ({}): {}",
            self.requirement, self.way, self.found
        )
    }
}

impl FromStr for Requirement {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = || {
            "expected METRIC >= NUMBER, such as f1 >= 0.8 or lab/model: recall > 0.9".to_string()
        };
        let (way, rest) = match text.rsplit_once(": ") {
            Some((way, rest)) => (Some(way.trim().to_string()), rest),
            None => (None, text),
        };
        let found = COMPARATORS
            .iter()
            .find_map(|(sign, comparator)| Some((rest.split_once(sign)?, *comparator)));
        let ((metric, bound), comparator) = found.ok_or_else(form)?;
        let metric = metric.trim().to_lowercase();
        let known = METRICS.iter().find(|(name, _)| *name == metric);
        let Some((metric, pointer)) = known else {
            return Err(unknown("metric", &metric, METRICS.map(|(name, _)| name)));
        };
        let bound: f64 = bound.trim().parse().map_err(|_| form())?;
        if !bound.is_finite() {
            return Err(form());
        }
        Ok(Self {
            way,
            metric,
            pointer,
            comparator,
            bound,
            text: rest.trim().to_string(),
        })
    }
}

impl Requirement {
    /// Holds the requirement against every way of a report that it is about. The built-in judge is meant only where it
    /// is named or alone.
    ///
    /// # Errors
    /// The report has no way of this name.
    pub fn check(&self, report: &Report) -> Result<Vec<Check>, String> {
        let ways: Vec<&PromptConfig> = report.whole().map(|cell| &cell.way).collect();
        let alone = ways.iter().all(|way| way.model == judge::MODEL);
        let is_meant = |way: &PromptConfig| match &self.way {
            Some(name) => is_called(way, name),
            None => alone || way.model != judge::MODEL,
        };
        let split = report
            .about
            .split
            .map(|part| format!("{part} · "))
            .unwrap_or_default();
        let meant = report.whole().filter(|cell| is_meant(&cell.way));
        let checks: Vec<Check> = meant
            .map(|cell| {
                let json = cell.json();
                let value = json.pointer(self.pointer).and_then(Value::as_f64);
                let interval = json.pointer(&format!("{}_ci", self.pointer));
                Check {
                    requirement: self.text.clone(),
                    way: format!("{split}{} · {}", cell.way.task.name(), name_of(&cell.way)),
                    found: self.found(value, interval),
                    is_met: value.is_some_and(|value| self.holds(value)),
                }
            })
            .collect();
        match (&self.way, checks.is_empty()) {
            (Some(name), true) => {
                let mut known: Vec<String> = ways
                    .iter()
                    .flat_map(|way| [way.model.clone(), name_of(way)])
                    .collect();
                known.sort();
                known.dedup();
                let known = known.iter().map(String::as_str);
                Err(format!(
                    "{name}: no such model or prompt configuration{}",
                    available(name, known)
                ))
            }
            _ => Ok(checks),
        }
    }

    fn holds(&self, value: f64) -> bool {
        match self.comparator {
            Comparator::AtLeast => value >= self.bound,
            Comparator::Above => value > self.bound,
            Comparator::AtMost => value <= self.bound,
            Comparator::Below => value < self.bound,
            Comparator::Equal => value == self.bound,
        }
    }

    fn found(&self, value: Option<f64>, interval: Option<&Value>) -> String {
        let Some(value) = value else {
            return format!("{} has no value", self.metric);
        };
        let ends = interval.and_then(|ends| Some((ends.get(0)?.as_f64()?, ends.get(1)?.as_f64()?)));
        let value = if value.fract() == 0.0 && value.abs() >= 2.0 {
            format!("{value}")
        } else {
            format!("{value:.4}")
        };
        match ends {
            Some((low, high)) => format!("{} is {value} [{low:.4}, {high:.4}]", self.metric),
            None => format!("{} is {value}", self.metric),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::evaluation::tests_scored::collisions_found;

    #[test]
    fn every_metric_is_one_of_a_cell() {
        let report = Report::from_scored(&collisions_found("lab/a", 3, 4));
        let json = report.whole().next().unwrap().json();
        for (name, pointer) in METRICS {
            assert!(json.pointer(pointer).is_some(), "{name}");
        }
    }

    #[test]
    fn requirements_hold_or_not_for_each_way_that_is_meant() {
        let all = [
            collisions_found("lab/a", 3, 4),
            collisions_found("lab/b", 1, 4),
            collisions_found(judge::MODEL, 0, 4),
        ];
        let report = Report::from_scored(&all.concat());
        let met = |text: &str| -> Vec<bool> {
            let requirement: Requirement = text.parse().unwrap();
            let checks = requirement.check(&report).unwrap();
            checks.iter().map(|check| check.is_met).collect()
        };
        assert_eq!(met("recall >= 0.75"), [true, false]);
        assert_eq!(met("lab/b: Recall>0.25"), [false]);
        assert_eq!(met("lab/b: recall <= 0.25"), [true]);
        assert_eq!(met("reference/geometry: tp == 0"), [true]);
        assert_eq!(
            met("specificity > 0"),
            [false, false],
            "without a value it is not met"
        );
        let unknown: Requirement = "lab/c: f1 > 0".parse().unwrap();
        let said = unknown.check(&report).unwrap_err();
        assert!(said.contains("did you mean"), "{said}");
        for (text, words) in [
            ("recal >= 0.8", "did you mean"),
            ("f1", "expected METRIC"),
            ("f1 >= x", "expected METRIC"),
            ("f1 >= NaN", "expected METRIC"),
            ("", "expected METRIC"),
        ] {
            let said = text.parse::<Requirement>().unwrap_err();
            assert!(said.contains(words), "{text}: {said}");
        }
    }
}

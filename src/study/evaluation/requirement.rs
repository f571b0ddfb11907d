//! Requirements that a report must meet: `f1 >= 0.8`, `model/x: recall > 0.9`.

use std::str::FromStr;

use super::PromptConfig;
use super::report::{Cell, Report, is_called, name_of};
use nearmiss_base::system::{available, unknown};
use nearmiss_record::{self as record, Kind, columns, row};
use nearmiss_scene::judge;

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
    /// The name of a column of cells.
    metric: String,
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
        let columns = columns::<Cell>();
        let numbers = columns.iter().filter(|column| column.kind != Kind::Text);
        let mut named = numbers.clone();
        let Some(column) = named.find(|column| short(&column.name) == metric) else {
            let names = numbers.map(|column| short(&column.name));
            return Err(unknown("metric", &metric, names));
        };
        let bound: f64 = bound.trim().parse().map_err(|_| form())?;
        if !bound.is_finite() {
            return Err(form());
        }
        Ok(Self {
            way,
            metric: column.name.to_string(),
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
        let columns = columns::<Cell>();
        let meant = report.whole().filter(|cell| is_meant(&cell.way));
        let checks: Vec<Check> = meant
            .map(|cell| {
                let row = row(cell).unwrap_or_default();
                let number = |name: &str| {
                    let place = columns.iter().position(|column| column.name == name)?;
                    match row.get(place)? {
                        record::Cell::Integer(n) => Some(*n as f64),
                        cell => cell.number(),
                    }
                };
                let value = number(&self.metric);
                let end = |which| number(&format!("{}_ci_{which}", self.metric));
                let interval = end("low").zip(end("high"));
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

    fn found(&self, value: Option<f64>, interval: Option<(f64, f64)>) -> String {
        let metric = short(&self.metric);
        let Some(value) = value else {
            return format!("{metric} has no value");
        };
        let value = if value.fract() == 0.0 && value.abs() >= 2.0 {
            format!("{value}")
        } else {
            format!("{value:.4}")
        };
        match interval {
            Some((low, high)) => format!("{metric} is {value} [{low:.4}, {high:.4}]"),
            None => format!("{metric} is {value}"),
        }
    }
}

/// The name of a column without that of the object that it stands in.
fn short(column: &str) -> &str {
    column.rsplit('.').next().unwrap_or(column)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::evaluation::tests_scored::collisions_found;

    #[test]
    fn every_number_of_a_cell_can_be_required() {
        let report = Report::from_scored(&collisions_found("lab/a", 3, 4));
        for name in [
            "n",
            "scenarios",
            "tp",
            "fn",
            "asked",
            "right_of_all",
            "unlabelled",
            "contradictory",
            "unknown_obstacles",
            "specificity",
            "kappa",
            "agreement_with_reference",
            "naming_precision",
            "brier",
            "expected_error",
            "majority_f1",
            "unanimous",
            "all_right",
            "seconds_p95",
            "input_tokens",
            "cost_unknown",
        ] {
            let required: Requirement = format!("{name} >= 0").parse().unwrap();
            let [check] = &required.check(&report).unwrap()[..] else {
                panic!("{name}")
            };
            assert!(check.found.starts_with(name), "{}", check.found);
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

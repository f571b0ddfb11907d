//! Gates: requirements that a report must meet, such as `f1 >= 0.8`, and regressions from earlier answers.

use std::collections::BTreeMap;
use std::str::FromStr;

use nearmiss_base::system::{available, unknown};
use nearmiss_record as record;
use nearmiss_record::{Kind, columns, row};
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;

use super::report::{Cell, Report, by_configuration, configuration_name, is_called, p_value};
use super::statistics::{PairedTest, if_enough};
use super::{Cluster, PromptConfig, Scored};

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
    configuration: Option<String>,
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
    pub configuration: String,
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
            self.requirement, self.configuration, self.found
        )
    }
}

impl FromStr for Requirement {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = || {
            "expected METRIC >= NUMBER, such as f1 >= 0.8 or lab/model: recall > 0.9".to_string()
        };
        let (configuration, rest) = match text.rsplit_once(": ") {
            Some((configuration, rest)) => (Some(configuration.trim().to_string()), rest),
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
            configuration,
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
        let configurations: Vec<&PromptConfig> = report
            .full_cells()
            .map(|cell| &cell.configuration)
            .collect();
        let alone = configurations
            .iter()
            .all(|configuration| configuration.model == judge::MODEL);
        let is_meant = |configuration: &PromptConfig| match &self.configuration {
            Some(name) => is_called(configuration, name),
            None => alone || configuration.model != judge::MODEL,
        };
        let split = report
            .about
            .split
            .map(|part| format!("{part} · "))
            .unwrap_or_default();
        let columns = columns::<Cell>();
        let meant = report
            .full_cells()
            .filter(|cell| is_meant(&cell.configuration));
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
                    configuration: format!(
                        "{split}{} · {}",
                        cell.configuration.task.name(),
                        configuration_name(&cell.configuration)
                    ),
                    found: self.found(value, interval),
                    is_met: value.is_some_and(|value| self.holds(value)),
                }
            })
            .collect();
        match (&self.configuration, checks.is_empty()) {
            (Some(name), true) => {
                let mut known: Vec<String> = configurations
                    .iter()
                    .flat_map(|configuration| {
                        [
                            configuration.model.clone(),
                            configuration_name(configuration),
                        ]
                    })
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

/// A way of asking beside the one that was asked earlier.
#[derive(Debug, Clone, PartialEq)]
pub struct Regression {
    /// The way.
    pub configuration: PromptConfig,
    /// The earlier one.
    pub before: PromptConfig,
    /// What is counted.
    pub cluster: Cluster,
    /// Units with the same questions and a truth that both were asked about.
    pub n: u32,
    /// Units that both were asked about, without such a question.
    pub left_out: u32,
    /// By how much more often it is right now; `None` without a common unit.
    pub test: Option<PairedTest>,
}

/// A question: the scenario with its window.
type Asked<'a> = (&'a str, Option<(i64, i64)>);

/// How often a way is right about its questions, and how often not: see [`Scored::is_right`].
type Right<'a> = BTreeMap<Asked<'a>, (u32, u32)>;

/// Each way of now beside the same one before: the same task, frame, techniques and model, whatever the template; where
/// none is the same and each side has one way of the task, these two. `is_same` says whether a scenario is the same file in
/// both.
pub fn regressions(
    now: &[Scored],
    before: &[Scored],
    is_same: impl Fn(&str) -> bool,
) -> Vec<Regression> {
    let (configurations, earlier) = (by_configuration(now), by_configuration(before));
    let mut found = Vec::new();
    for (configuration, scored) in &configurations {
        let same = |other: &&PromptConfig| bare(other) == bare(configuration);
        let of_task = |all: &BTreeMap<&PromptConfig, Vec<&Scored>>, task: Task| {
            all.keys()
                .filter(|configuration| configuration.task == task)
                .count()
        };
        let lone = of_task(&configurations, configuration.task) == 1
            && of_task(&earlier, configuration.task) == 1;
        let fits = |other: &&PromptConfig| same(other) || lone && other.task == configuration.task;
        let Some((other, old)) = earlier.iter().find(|(other, _)| fits(other)) else {
            continue;
        };
        found.push(compared((configuration, scored), (other, old), &is_same));
    }
    found
}

fn bare(configuration: &PromptConfig) -> PromptConfig {
    PromptConfig {
        template: None,
        ..configuration.clone()
    }
}

fn compared(
    (configuration, now): (&PromptConfig, &[&Scored]),
    (earlier, before): (&PromptConfig, &[&Scored]),
    is_same: &impl Fn(&str) -> bool,
) -> Regression {
    let cluster = now.first().map_or_else(Cluster::default, |one| one.cluster);
    let (now, before) = (right(now), right(before));
    // By unit, as its questions are not independent: sums of shares of right answers, and how many questions.
    let mut units: BTreeMap<&str, (f64, u32)> = BTreeMap::new();
    for (question @ (scenario, _), new) in &now {
        let Some(old) = before.get(question).filter(|_| is_same(scenario)) else {
            continue;
        };
        let sum = units.entry(cluster.unit(scenario)).or_default();
        if let (Some(new), Some(old)) = (share(*new), share(*old)) {
            sum.0 += new - old;
            sum.1 += 1;
        }
    }
    let with = units.values().filter(|(_, n)| *n > 0);
    let differences: Vec<f64> = with.map(|(sum, n)| sum / f64::from(*n)).collect();
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    Regression {
        configuration: configuration.clone(),
        before: earlier.clone(),
        cluster,
        n: count(differences.len()),
        left_out: count(units.len() - differences.len()),
        test: PairedTest::of_differences(&differences),
    }
}

fn share((right, wrong): (u32, u32)) -> Option<f64> {
    (right + wrong > 0).then(|| f64::from(right) / f64::from(right + wrong))
}

fn right<'a>(scored: &[&'a Scored]) -> Right<'a> {
    let mut found = Right::new();
    for one in scored {
        if one.is_collision().is_none() {
            continue;
        }
        let of_question = found.entry((&one.scenario, one.window)).or_default();
        match one.is_right() {
            Some(true) => of_question.0 += 1,
            Some(false) => of_question.1 += 1,
            None => {}
        }
    }
    found
}

/// A p value as a sentence has it.
fn p(value: f64) -> String {
    match p_value(value) {
        small if small.starts_with('<') => format!("p {small}"),
        other => format!("p = {other}"),
    }
}

impl Regression {
    /// Whether the share that is right of all asked fell by more than `margin`.
    #[must_use]
    pub fn check(&self, margin: f64) -> Check {
        let name = format!(
            "{} · {}",
            self.configuration.task.name(),
            configuration_name(&self.configuration)
        );
        let mut found = match &self.test {
            None => "no common question was asked of both".to_string(),
            Some(test) => {
                let interval = if_enough(test.interval, self.n);
                let ends = interval.map_or_else(
                    || "no interval of so few".into(),
                    |ends| format!("95 % interval {:+.4} to {:+.4}", ends.low, ends.high),
                );
                format!(
                    "right of all asked differs by {:+.4} ({ends}, {}) over {} common {}s",
                    test.difference,
                    p(test.p),
                    self.n,
                    self.cluster
                )
            }
        };
        if self.left_out > 0 {
            found += &format!(", {} left out as not asked yet", self.left_out);
        }
        if self.before.model != self.configuration.model {
            found += &format!(", beside {}", configuration_name(&self.before));
        }
        Check {
            requirement: format!("no worse than the baseline by more than {margin}"),
            configuration: name,
            found,
            // A share of a whole number of answers: rounding is no regression.
            is_met: self
                .test
                .is_some_and(|test| test.difference >= -margin - 1e-9),
        }
    }
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

    #[test]
    fn a_way_is_worse_than_before_by_more_than_the_margin_or_not() {
        let all = |_: &str| true;
        let found = regressions(
            &collisions_found("lab/a", 18, 20),
            &collisions_found("lab/a", 19, 20),
            all,
        );
        let one = &found[0];
        assert_eq!((found.len(), one.n, one.left_out), (1, 20, 0));
        assert!((one.test.unwrap().difference + 0.05).abs() < 1e-9);
        assert!(one.check(0.05).is_met && !one.check(0.02).is_met);
        let words = one.check(0.02).to_string();
        assert!(words.contains("-0.0500 (95 % interval"), "{words}");
        // Another file of the same name is another question.
        let found = regressions(
            &collisions_found("lab/a", 18, 20),
            &collisions_found("lab/a", 19, 20),
            |name| name != "S18",
        );
        assert_eq!((found[0].n, found[0].test.unwrap().difference), (19, 0.0));
        // A lone model is compared with the lone one before it; of several only the same one.
        let lone = regressions(
            &collisions_found("lab/b", 18, 20),
            &collisions_found("lab/a", 19, 20),
            all,
        );
        assert!(lone[0].check(0.02).found.contains("beside lab/a"));
        let several = [
            collisions_found("lab/a", 1, 2),
            collisions_found("lab/b", 1, 2),
        ]
        .concat();
        assert_eq!(
            regressions(&several, &collisions_found("lab/b", 1, 2), all).len(),
            1
        );
        let nothing = regressions(
            &collisions_found("lab/a", 1, 2),
            &collisions_found("lab/a", 1, 2),
            |_| false,
        );
        assert!(!nothing[0].check(1.0).is_met);
    }
}

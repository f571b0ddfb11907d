//! Regressions: the answers of now beside earlier ones to the same questions.

use std::collections::BTreeMap;

use super::report::{name_of, p_value};
use super::statistics::{PairedTest, shown};
use super::{Check, Cluster, PromptConfig, Scored};
use nearmiss_scene::verdict::Task;

/// A way of asking beside the one that was asked earlier.
#[derive(Debug, Clone, PartialEq)]
pub struct Regression {
    /// The way.
    pub way: PromptConfig,
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
    let (ways, earlier) = (ways(now), ways(before));
    let mut found = Vec::new();
    for (way, scored) in &ways {
        let same = |other: &&PromptConfig| bare(other) == bare(way);
        let of_task = |all: &BTreeMap<&PromptConfig, Vec<&Scored>>, task: Task| {
            all.keys().filter(|way| way.task == task).count()
        };
        let lone = of_task(&ways, way.task) == 1 && of_task(&earlier, way.task) == 1;
        let fits = |other: &&PromptConfig| same(other) || lone && other.task == way.task;
        let Some((other, old)) = earlier.iter().find(|(other, _)| fits(other)) else {
            continue;
        };
        found.push(compared((way, scored), (other, old), &is_same));
    }
    found
}

fn bare(way: &PromptConfig) -> PromptConfig {
    PromptConfig {
        template: None,
        ..way.clone()
    }
}

fn ways(scored: &[Scored]) -> BTreeMap<&PromptConfig, Vec<&Scored>> {
    let mut ways: BTreeMap<&PromptConfig, Vec<&Scored>> = BTreeMap::new();
    for one in scored {
        ways.entry(&one.way).or_default().push(one);
    }
    ways
}

fn compared(
    (way, now): (&PromptConfig, &[&Scored]),
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
        let sum = units.entry(cluster.of(scenario)).or_default();
        if let (Some(new), Some(old)) = (share(*new), share(*old)) {
            sum.0 += new - old;
            sum.1 += 1;
        }
    }
    let with = units.values().filter(|(_, n)| *n > 0);
    let differences: Vec<f64> = with.map(|(sum, n)| sum / f64::from(*n)).collect();
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    Regression {
        way: way.clone(),
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
        let name = format!("{} · {}", self.way.task.name(), name_of(&self.way));
        let mut found = match &self.test {
            None => "no common question was asked of both".to_string(),
            Some(test) => {
                let interval = shown(test.interval, self.n);
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
        if self.before.model != self.way.model {
            found += &format!(", beside {}", name_of(&self.before));
        }
        Check {
            requirement: format!("no worse than the baseline by more than {margin}"),
            way: name,
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

//! Figures for another share of dangerous questions than a batch has: on the road it is far below a half.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::super::statistics::{Interval, if_enough, intervals};
use super::super::{AxisValues, Confusion, PromptConfig, RuleScore, Scored};
use super::contents::{columns_of_task, record_rows};
use nearmiss_record::{CaptionedTable, Record};
use nearmiss_scene::verdict::Task;

/// What a way of asking would come to at another share of dangerous questions.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct AtPrevalence {
    /// The way.
    #[serde(flatten)]
    pub configuration: PromptConfig,
    /// The share of dangerous questions, from 0 to 1.
    pub prevalence: f64,
    /// The share that is right of all asked.
    #[schemars(title = "Right of all", extend("decimals" = 2))]
    pub right_of_all: Option<f64>,
    /// Its interval of 95 %.
    pub right_of_all_ci: Option<Interval>,
    /// The precision of the verdicts.
    #[schemars(title = "Precision", extend("decimals" = 2))]
    pub precision: Option<f64>,
    /// Its interval of 95 %.
    pub precision_ci: Option<Interval>,
    /// F1 of the verdicts.
    #[schemars(title = "F1", extend("decimals" = 2))]
    pub f1: Option<f64>,
    /// Its interval of 95 %.
    pub f1_ci: Option<Interval>,
}

impl Record for AtPrevalence {
    const NAME: &'static str = "prevalence";
    const TITLE: &'static str = "A prompt configuration at another share of dangerous questions";
}

/// Questions of a unit.
#[derive(Default)]
struct Counts {
    /// Those with a verdict.
    answered: Confusion,
    /// All that were asked; no verdict is wrong.
    asked: Confusion,
}

/// Every way at a share of dangerous questions, if its answers to dangerous ones and to safe ones are as good as here:
/// p·recall + (1 − p)·specificity are right, of the yes p·recall of p·recall + (1 − p)·(1 − specificity). C. J. van
/// Rijsbergen's F1 and Bayes' rule; A. N. Vecchio, "Predictive value of a single diagnostic test in unselected
/// populations", New England Journal of Medicine 274 (1966).
#[must_use]
pub fn at_prevalence(scored: &[Scored], prevalence: f64) -> Vec<AtPrevalence> {
    let mut configurations: BTreeMap<&PromptConfig, BTreeMap<&str, Counts>> = BTreeMap::new();
    for one in scored {
        let Some((truth, is_right)) = one.is_collision().zip(one.is_right()) else {
            continue;
        };
        let counts = configurations
            .entry(&one.configuration)
            .or_default()
            .entry(one.unit())
            .or_default();
        counts.asked.count(truth == is_right, truth);
        if let Some(said) = one.positive() {
            counts.answered.count(said, truth);
        }
    }
    let of_way = |(configuration, units): (&PromptConfig, BTreeMap<&str, Counts>)| {
        let (mut asked, mut answered) = (Vec::new(), Vec::new());
        for counts in units.into_values() {
            asked.push(counts.asked);
            answered.push(counts.answered);
        }
        let [(right_of_all, right_of_all_ci)] =
            figures(&asked, |counts| [right(counts, prevalence)]);
        let [(precision, precision_ci), (f1, f1_ci)] =
            figures(&answered, |counts| of_verdicts(counts, prevalence));
        AtPrevalence {
            configuration: configuration.clone(),
            prevalence,
            right_of_all,
            right_of_all_ci,
            precision,
            precision_ci,
            f1,
            f1_ci,
        }
    };
    configurations.into_iter().map(of_way).collect()
}

/// Figures of all units together, with their intervals.
fn figures<const N: usize>(
    units: &[Confusion],
    figures: impl Fn(&Confusion) -> [Option<f64>; N],
) -> [(Option<f64>, Option<Interval>); N] {
    let mut sum = Confusion::default();
    units.iter().for_each(|counts| sum.add(counts));
    let many = u32::try_from(units.len()).unwrap_or(u32::MAX);
    let mut drawn = intervals(units, &figures).into_iter();
    figures(&sum).map(|value| {
        // Where no draw differs, the bootstrap says nothing.
        let interval = drawn
            .next()
            .flatten()
            .filter(|drawn| drawn.low < drawn.high);
        (value, if_enough(interval, many))
    })
}

fn right(counts: &Confusion, prevalence: f64) -> Option<f64> {
    Some(prevalence * counts.recall()? + (1.0 - prevalence) * counts.specificity()?)
}

/// Precision and F1.
fn of_verdicts(counts: &Confusion, prevalence: f64) -> [Option<f64>; 2] {
    let Some((recall, specificity)) = counts.recall().zip(counts.specificity()) else {
        return [None, None];
    };
    let (hits, alarms) = (
        prevalence * recall,
        (1.0 - prevalence) * (1.0 - specificity),
    );
    let precision = (hits + alarms > 0.0).then(|| hits / (hits + alarms));
    [precision, Some(2.0 * hits / (hits + alarms + prevalence))]
}

/// The table of a task, trivial rules last; `None` without rows.
pub(super) fn table(
    task: Task,
    rows: &[AtPrevalence],
    rules: &[RuleScore],
) -> Option<CaptionedTable> {
    let of_task = rows.iter().filter(|row| row.configuration.task == task);
    let mut rows: Vec<AtPrevalence> = of_task.cloned().collect();
    let prevalence = rows.first()?.prevalence;
    rows.extend(rules.iter().filter(|rule| rule.task == task).map(|rule| {
        let [precision, f1] = of_verdicts(&rule.counts, prevalence);
        AtPrevalence {
            configuration: PromptConfig {
                task,
                frame: None,
                techniques: None,
                model: format!("rule: {}", rule.rule),
                settings: AxisValues::default(),
                template: None,
            },
            prevalence,
            right_of_all: right(&rule.counts, prevalence),
            right_of_all_ci: None,
            precision,
            precision_ci: None,
            f1,
            f1_ci: None,
        }
    }));
    let caption = format!(
        "If {} % of the questions were dangerous, {} task",
        100.0 * prevalence,
        task.name()
    );
    let name = format!("nearmiss-{}-prevalence", task.name());
    let columns = columns_of_task::<AtPrevalence>("");
    let table = CaptionedTable::new(caption, name, &columns, &record_rows(&rows));
    Some(table.with_notes([
        "Recall and specificity are taken as they are here, and weighed with that share; intervals are bootstraps over the \
         same units."
            .into(),
    ]))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::evaluation::tests_scored::answer;
    use crate::evaluation::{AnswerStatus, Label, Rule};

    /// 20 dangerous ones, of which 16 are found, and 20 safe ones with 2 false alarms, weighed by
    /// 0.1/20 and 0.9/20: 0.08 + 0.81 are right, precision 0.08/0.17, F1 0.16/0.27.
    #[test]
    fn as_weighed_by_hand() {
        let counts = Confusion {
            false_negatives: 20,
            true_negatives: 20,
            ..Confusion::default()
        };
        let rules = [RuleScore {
            task: Task::Safety,
            rule: Rule::AlwaysNo,
            is_fitted: false,
            counts,
        }];
        let one = |n: usize, said: bool, truth: bool| {
            let mut one = answer(&format!("s{n}"), "lab/m", said, &[]);
            let label = if truth {
                Label::Collision(None)
            } else {
                Label::Safe
            };
            one.set_truth(Some((label, Vec::new())));
            one
        };
        let dangerous = (0..20).map(|n| one(n, n < 16, true));
        let safe = (20..40).map(|n| one(n, n < 22, false));
        let mut all: Vec<Scored> = dangerous.chain(safe).collect();
        let [row] = &at_prevalence(&all, 0.1)[..] else {
            panic!()
        };
        let near = |value: Option<f64>, wanted: f64| (value.unwrap() - wanted).abs() < 1e-6;
        assert!(near(row.right_of_all, 0.89), "{row:?}");
        assert!(near(row.precision, 0.470_588), "{row:?}");
        assert!(near(row.f1, 0.592_593), "{row:?}");
        let ends = row.precision_ci.unwrap();
        assert!(ends.low < 0.4 && ends.high > 0.55, "{ends:?}");
        let table = table(Task::Safety, &at_prevalence(&all, 0.1), &rules).unwrap();
        assert_eq!(table.rows[1][2..], ["rule: always no", "0.90", "–", "0.00"]);
        // Who says nothing of a safe one is not right about it.
        all[39].status = AnswerStatus::Unparsed("nothing".into());
        let row = &at_prevalence(&all, 0.1)[0];
        assert!(near(row.right_of_all, 0.845), "{row:?}");
        // At the share of the questions themselves it is what they come to.
        all.pop();
        all.push(one(39, false, false));
        assert!(near(at_prevalence(&all, 0.5)[0].right_of_all, 0.85));
    }
}

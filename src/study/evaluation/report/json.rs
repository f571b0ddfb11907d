//! Reports as JSON: every number, unrounded.

use serde_json::{Map, Value, json};

use super::super::statistics::Calibration;
use super::super::statistics::{DRAWS, Interval, RESAMPLES, SEED, shown};
use super::super::{Confusion, ProbabilitySource, PromptConfig};
use super::names::technique;
use super::{Cell, Pair, Pivot, Report};

impl Report {
    /// `{"cells": […], "pairs": […], …}`, with the subject of the report; missing values are null.
    #[must_use]
    pub fn json(&self) -> Value {
        let unit = self.unit();
        let mut report = json!({
            "cells": self.cells.iter().map(Cell::json).collect::<Vec<_>>(),
            "pairs": self.pairs.iter().map(pair).collect::<Vec<_>>(),
            "intervals": {
                "level": 0.95,
                "unit": unit.to_string(),
                "proportions": format!("Wilson with one answer a {unit}, else percentile bootstrap over {unit}s"),
                "f1": format!("percentile bootstrap over {unit}s"),
                "resamples": RESAMPLES,
                "comparisons": format!("paired permutation test by {unit}"),
                "permutations": DRAWS,
                "seed": SEED,
            },
        });
        for (name, value) in self.about.fields() {
            report[name] = value;
        }
        for (name, rows) in self.varied.fields() {
            report[name] = rows;
        }
        if !self.tables.is_empty() {
            report["tables"] = self.tables.iter().map(Pivot::json).collect();
        }
        if !self.rules.is_empty() {
            report["rules"] = self.rules.iter().map(super::rules::row).collect();
        }
        if !self.prevalence.is_empty() {
            report["prevalence"] = self.prevalence.iter().map(super::prevalence::row).collect();
        }
        if !self.leaks.is_empty() {
            report["leaks"] = self.leaks.iter().map(super::leaks::row).collect();
        }
        report
    }
}

/// The parts of a way.
pub(crate) fn way(way: &PromptConfig) -> Map<String, Value> {
    let fields = [
        ("task", json!(way.task.name())),
        ("frame", json!(way.frame.map(|f| f.name()))),
        ("techniques", json!(way.techniques.map(|t| t.to_string()))),
        // The name of before `schema_version`.
        ("technique", json!(way.techniques.map(technique))),
        ("model", json!(way.model)),
        ("settings", json!(way.settings.words())),
        ("template", json!(way.template.as_ref().map(|t| &t.name))),
        (
            "template_hash",
            json!(way.template.as_ref().map(|t| &t.hash)),
        ),
    ];
    fields
        .map(|(k, v)| (k.to_string(), v))
        .into_iter()
        .collect()
}

/// The four counts.
pub(crate) fn counts(c: &Confusion) -> Map<String, Value> {
    let fields = [
        ("tp", c.true_positives),
        ("fp", c.false_positives),
        ("fn", c.false_negatives),
        ("tn", c.true_negatives),
    ];
    fields
        .map(|(k, v)| (k.to_string(), json!(v)))
        .into_iter()
        .collect()
}

pub(super) fn interval(interval: Option<Interval>) -> Value {
    interval.map_or(Value::Null, |i| json!([i.low, i.high]))
}

/// Probabilities beside the truth.
fn calibration(all: &Calibration) -> Value {
    json!({
        "n": all.n(),
        "brier": all.brier(),
        "auroc": all.auroc(),
        "expected_error": all.error(),
        "bins": all.bins(),
    })
}

impl Cell {
    /// The same of all verdicts, with how many probabilities are from where.
    fn calibrated(&self) -> Value {
        let mut all = json!({
            "n": self.calibration.n(),
            "from_stated": self.source(ProbabilitySource::Stated),
            "from_critical": self.source(ProbabilitySource::Critical),
            "from_token": self.source(ProbabilitySource::Token),
            "from_score": self.source(ProbabilitySource::Score),
            "from_decision": self.source(ProbabilitySource::Decision),
        });
        if let (Some(all), Value::Object(rest)) =
            (all.as_object_mut(), calibration(&self.calibration))
        {
            all.extend(rest);
        }
        all
    }

    /// One object, flat except for nested values.
    #[must_use]
    pub fn json(&self) -> Value {
        let mut map = Map::new();
        map.insert("label".into(), json!(self.half.name()));
        map.extend(way(&self.way));
        map.insert("n".into(), json!(self.n));
        map.extend(counts(&self.confusion));
        let main = [
            ("asked", json!(self.asked)),
            ("asked_dangerous", json!(self.dangerous)),
            ("right", json!(self.right)),
            ("right_of_all", json!(self.right_of_all())),
            ("right_of_all_ci", interval(self.intervals.right)),
        ];
        let (c, of, samples) = (&self.confusion, &self.consumption, &self.samples);
        let rest = json!({
            "unparsed": self.unparsed,
            "failed": self.failed,
            "unasked": self.unasked,
            "unlabelled": self.unlabelled,
            "scenarios": self.scenarios,
            "precision": self.precision(),
            "precision_ci": interval(self.intervals.precision),
            "recall": c.recall(),
            "recall_ci": interval(self.intervals.recall),
            "specificity": c.specificity(),
            "specificity_ci": interval(self.intervals.specificity),
            "accuracy": c.accuracy(),
            "accuracy_ci": interval(self.intervals.accuracy),
            "f1": self.f1(),
            "f1_ci": interval(self.intervals.f1),
            "kappa": self.kappa.and_then(|k| k.kappa),
            "kappa_ci": interval(self.kappa.and_then(|k| k.interval)),
            "kappa_n": self.kappa.map(|k| k.n),
            "agreement_with_reference": self.kappa.map(|k| k.agreement),
            "named": self.naming.found,
            "named_of": self.naming.windows,
            "named_first": self.naming.first,
            "naming_recall": self.naming.recall(),
            "naming_recall_ci": interval(self.naming_intervals.recall),
            "obstacles_named": self.naming.named,
            "obstacles_named_right": self.naming.right,
            "naming_precision": self.naming.precision(),
            "naming_precision_ci": interval(self.naming_intervals.precision),
            "calibration": self.calibrated(),
            "samples": {
                "scenarios": samples.spread.scenarios,
                "unanimous": samples.spread.unanimous,
                "agreement": samples.spread.agreement(),
                "majority": counts(&samples.majority),
                "majority_f1": self.f1().and(samples.majority.f1()),
                "majority_coverage": samples.coverage(),
                "undecided": samples.undecided,
                "ties": samples.ties,
                "all_right": samples.all_right.share,
                "all_right_k": samples.all_right.k,
                "all_right_of": samples.all_right.questions,
            },
            "seconds_median": of.median_s,
            "seconds_p95": of.p95_s,
            "timed": of.timed,
            "input_tokens": (of.counted > 0).then_some(of.input_tokens),
            "output_tokens": (of.counted > 0).then_some(of.output_tokens),
            "tokens_of": of.counted,
            "cost_usd": of.spending.cost(),
            "cost_of": of.spending.known,
            "cost_unknown": of.spending.unpriced(),
            "cost_unknown_most_usd": of.spending.most(),
            "superseded": of.superseded,
        });
        if let Value::Object(rest) = rest {
            map.extend(rest);
        }
        map.extend(main.map(|(key, value)| (key.to_string(), value)));
        let tokens = calibration(&self.token_calibration);
        map.insert("token_calibration".into(), tokens);
        map.extend(self.claims.fields());
        let flagged = [
            ("contradictory", self.flagged.contradictory),
            ("named_twice", self.flagged.twice),
            ("unknown_obstacles", self.flagged.unknown),
        ];
        map.extend(flagged.map(|(key, count)| (key.to_string(), json!(count))));
        Value::Object(map)
    }
}

pub(super) fn pair(pair: &Pair) -> Value {
    json!({
        "first": way(&pair.first),
        "second": way(&pair.second),
        "differs": pair.differs,
        "n": pair.n,
        "left_out": pair.left_out,
        "family": pair.family.name(),
        "ties": pair.ties,
        "difference": pair.test.difference,
        "difference_ci": interval(shown(pair.test.interval, pair.n)),
        "detectable": pair.test.detectable,
        "p": pair.test.p,
        "p_holm": pair.corrected,
        "exact": pair.test.exact,
        "only_first": pair.mcnemar.only_first,
        "only_second": pair.mcnemar.only_second,
        "chi_square": pair.mcnemar.chi_square,
        "p_mcnemar": pair.mcnemar.p,
    })
}

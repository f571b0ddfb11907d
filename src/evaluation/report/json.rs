//! Reports as JSON: every number, unrounded.

use serde_json::{Map, Value, json};

use super::super::statistics::{Interval, RESAMPLES, SEED};
use super::super::{Confusion, PromptConfig};
use super::names::technique;
use super::{Cell, Pair, Report};

impl Report {
    /// `{"cells": […], "pairs": […], …}`, with the subject of the report; missing values are null.
    #[must_use]
    pub fn json(&self) -> Value {
        let mut report = json!({
            "cells": self.cells.iter().map(Cell::json).collect::<Vec<_>>(),
            "pairs": self.pairs.iter().map(pair).collect::<Vec<_>>(),
            "intervals": {
                "level": 0.95,
                "proportions": "Wilson",
                "f1": "percentile bootstrap over scenarios",
                "resamples": RESAMPLES,
                "seed": SEED,
            },
        });
        for (name, value) in self.about.fields() {
            report[name] = value;
        }
        for (name, rows) in self.varied.fields() {
            report[name] = rows;
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

fn interval(interval: Option<Interval>) -> Value {
    interval.map_or(Value::Null, |i| json!([i.low, i.high]))
}

impl Cell {
    /// One object, flat except for nested values.
    #[must_use]
    pub fn json(&self) -> Value {
        let mut map = Map::new();
        map.insert("label".into(), json!(self.half.name()));
        map.extend(way(&self.way));
        map.insert("n".into(), json!(self.n));
        map.extend(counts(&self.confusion));
        let (c, of) = (&self.confusion, &self.consumption);
        let rest = json!({
            "unparsed": self.unparsed,
            "failed": self.failed,
            "unasked": self.unasked,
            "unlabelled": self.unlabelled,
            "scenarios": self.scenarios,
            "precision": self.precision(),
            "precision_ci": interval(self.precision_interval()),
            "recall": c.recall(),
            "recall_ci": interval(self.recall_interval()),
            "specificity": c.specificity(),
            "specificity_ci": interval(self.specificity_interval()),
            "accuracy": c.accuracy(),
            "accuracy_ci": interval(self.accuracy_interval()),
            "f1": self.f1(),
            "f1_ci": interval(self.f1_interval),
            "kappa": self.kappa.and_then(|k| k.kappa),
            "kappa_ci": interval(self.kappa.and_then(|k| k.interval)),
            "kappa_n": self.kappa.map(|k| k.n),
            "agreement_with_reference": self.kappa.map(|k| k.agreement),
            "fn_wrong_obstacle": self.wrong_obstacle,
            "named": self.named.right,
            "named_of": self.named.n,
            "named_first": self.named.first,
            "calibration": {
                "scores": self.calibration.bins,
                "brier": self.calibration.brier(),
                "expected_error": self.calibration.error(),
            },
            "samples": {
                "scenarios": self.spread.scenarios,
                "unanimous": self.spread.unanimous,
                "agreement": self.spread.agreement(),
                "majority": counts(&self.majority),
                "majority_f1": self.f1().and(self.majority.f1()),
                "undecided": self.undecided,
            },
            "seconds_median": of.median_s,
            "seconds_p95": of.p95_s,
            "timed": of.timed,
            "input_tokens": (of.counted > 0).then_some(of.input_tokens),
            "output_tokens": (of.counted > 0).then_some(of.output_tokens),
            "tokens_of": of.counted,
            "cost_usd": of.cost_usd,
            "cost_unknown": of.unpriced(),
        });
        if let Value::Object(rest) = rest {
            map.extend(rest);
        }
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
        "only_first": pair.test.only_first,
        "only_second": pair.test.only_second,
        "chi_square": pair.test.chi_square,
        "p": pair.test.p,
        "p_holm": pair.corrected,
    })
}

//! The collision task: the judge's verdicts on whole recordings, compared with labels.

use serde_json::json;

use super::{Batch, Evaluate, Format, Truth, batch, number, share};
use crate::cli::{Failure, Outcome, output};
use crate::evaluation::{Confusion, Label};
use crate::formats::Entry;
use crate::judge::{self, judge};
use crate::scenario::Window;
use crate::verdict::Task;

/// The judge's answer: the first obstacle the ego collides with.
type Said = Option<i64>;

pub(super) fn run(arguments: &Evaluate, truth: &Truth, entries: &[Entry]) -> Outcome {
    if truth.is_geometry() {
        return Err(Failure::input(
            "--task collision needs --truth CSV or layout: the exact geometry is what the built-in judge itself answers",
        ));
    }
    let batch = batch(truth, entries, |case| -> Said {
        let whole = Window::ending_at(case.scene, i64::MAX, 1);
        let verdict = judge(case.scene, Task::Collision, &whole).verdict;
        let first = verdict.obstacles.first().filter(|_| verdict.dangerous);
        first.map(|o| o.id)
    })?;
    if !batch.judged.is_empty() {
        write(arguments, truth, &batch)?;
    }
    batch.outcome()
}

fn write(arguments: &Evaluate, truth: &Truth, batch: &Batch<Said>) -> Outcome {
    let mut c = Confusion::default();
    // Of the collisions that were found and have an obstacle in their label.
    let (mut named, mut who) = (0, 0);
    for j in &batch.judged {
        c.count(j.result.is_some(), j.label.collides());
        if let (Some(said), Label::Collision(Some(id))) = (j.result, j.label) {
            named += 1;
            who += u32::from(said == id);
        }
    }
    let other: Vec<_> = batch
        .judged
        .iter()
        .filter(|j| differs(j.label, j.result))
        .collect();
    match arguments.format {
        Format::Table => {
            let mut text = format!(
                "collision task: {}, {}\ntruth: {}\n\n{:<20} precision {}  recall {}  F1 {}  \
                 the labelled obstacle {who} of {named}\n",
                number(c.positives() as usize, "collision"),
                number(c.negatives() as usize, "safe scenario"),
                truth.words(),
                judge::MODEL,
                share(c.precision()),
                share(c.recall()),
                share(c.f1()),
            );
            for j in other {
                let words = format!(
                    "  {:<28} label: {:<18} judge: {}\n",
                    j.name,
                    label(j.label),
                    said(j.result)
                );
                text.push_str(&output::visible(&words));
            }
            output::text(&text)
        }
        Format::Csv => {
            let head = ["scenario", "label", "judge", "agrees"].map(String::from);
            let rows = batch.judged.iter().map(|j| {
                let agrees = !differs(j.label, j.result);
                [
                    j.name.clone(),
                    label(j.label),
                    said(j.result),
                    agrees.to_string(),
                ]
            });
            output::csv(std::iter::once(head).chain(rows))
        }
        Format::Json => {
            let other = other.iter().map(
                |j| json!({ "scenario": j.name, "label": label(j.label), "judge": said(j.result) }),
            );
            output::json(&json!({
                "task": "collision",
                "truth": truth.json(),
                "model": judge::MODEL,
                "tp": c.true_positives,
                "fp": c.false_positives,
                "fn": c.false_negatives,
                "tn": c.true_negatives,
                "precision": c.precision(),
                "recall": c.recall(),
                "f1": c.f1(),
                "obstacles_labelled": named,
                "obstacles_right": who,
                "differences": other.collect::<Vec<_>>(),
                "failed": batch.failed,
                "without_ego": batch.without_ego,
                "unlabelled": batch.unlabelled,
            }))
        }
    }
}

fn differs(label: Label, said: Said) -> bool {
    match (label, said) {
        (Label::Safe, said) => said.is_some(),
        (Label::Collision(_), None) => true,
        (Label::Collision(id), Some(said)) => id.is_some_and(|id| id != said),
    }
}

fn label(label: Label) -> String {
    match label {
        Label::Safe => "safe".into(),
        Label::Collision(None) => "collision".into(),
        Label::Collision(Some(id)) => format!("collision {id}"),
    }
}

fn said(said: Said) -> String {
    label(said.map_or(Label::Safe, |id| Label::Collision(Some(id))))
}

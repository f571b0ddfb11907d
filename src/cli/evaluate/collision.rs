//! The collision task: the judge's verdicts on whole recordings, compared with labels.

use serde_json::json;

use super::{Evaluate, Format, Truth, built_in, number, outcome, share};
use crate::cli::{Failure, Outcome, output};
use crate::evaluation::{AnswerStatus, Confusion, Label, Scored};
use crate::formats::Entry;
use crate::judge::{self, judge_collision};
use crate::metrics::Thresholds;
use crate::workflow::batch::BuiltInAnswers;

pub(super) fn run(arguments: &Evaluate, truth: &Truth, entries: &[Entry]) -> Outcome {
    if truth.is_geometry() {
        return Err(Failure::input(
            "--task collision needs --truth CSV or layout: the built-in judge itself answers from the exact geometry",
        ));
    }
    let answers = built_in(truth, entries, |entry, case| {
        let verdict = judge_collision(case.scene, Thresholds::shipped()).verdict;
        Scored::built_in(&entry.name, judge::MODEL, Some(case.label), verdict)
    })?;
    if !answers.judged.is_empty() {
        write(arguments, truth, &answers)?;
    }
    outcome(&answers)
}

/// The label of a scenario beside the judge's: its verdict, with the first obstacle the ego collides with.
struct Row<'a> {
    name: &'a str,
    label: Label,
    judge: Label,
}

impl<'a> Row<'a> {
    fn of((label, scored): &'a (Label, Scored)) -> Self {
        let judge = match &scored.status {
            AnswerStatus::Verdict(verdict) if verdict.dangerous => {
                Label::Collision(verdict.obstacles.first().map(|o| o.id))
            }
            _ => Label::Safe,
        };
        Self {
            name: &scored.scenario,
            label: *label,
            judge,
        }
    }

    fn differs(&self) -> bool {
        match (self.label, self.judge) {
            (Label::Collision(Some(id)), Label::Collision(said)) => said != Some(id),
            (label, judge) => label.collides() != judge.collides(),
        }
    }
}

fn write(arguments: &Evaluate, truth: &Truth, answers: &BuiltInAnswers<Scored>) -> Outcome {
    let c = Confusion::from_scored(answers.judged.iter().map(|(_, one)| one), Scored::positive);
    let rows: Vec<Row<'_>> = answers.judged.iter().map(Row::of).collect();
    // Of the collisions that were found and have an obstacle in their label.
    let (mut named, mut who) = (0, 0);
    for row in &rows {
        if let (Label::Collision(Some(_)), Label::Collision(_)) = (row.label, row.judge) {
            named += 1;
            who += u32::from(!row.differs());
        }
    }
    let other = rows.iter().filter(|row| row.differs());
    match arguments.format() {
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
            for row in other {
                let line = format!(
                    "  {:<28} label: {:<18} judge: {}\n",
                    row.name,
                    words(row.label),
                    words(row.judge)
                );
                text.push_str(&output::visible(&line));
            }
            output::text(&text)
        }
        Format::Csv => {
            let head = ["scenario", "label", "judge", "agrees"].map(String::from);
            let rows = rows.iter().map(|row| {
                [
                    row.name.to_string(),
                    words(row.label),
                    words(row.judge),
                    (!row.differs()).to_string(),
                ]
            });
            output::csv(std::iter::once(head).chain(rows))
        }
        Format::Json => {
            let other = other.map(
                |row| json!({ "scenario": row.name, "label": words(row.label), "judge": words(row.judge) }),
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
                "failed": answers.failed,
                "without_ego": answers.without_ego,
                "unlabelled": answers.unlabelled,
            }))
        }
    }
}

fn words(label: Label) -> String {
    match label {
        Label::Safe => "safe".into(),
        Label::Collision(None) => "collision".into(),
        Label::Collision(Some(id)) => format!("collision {id}"),
    }
}

//! The tasks about whole recordings: the judge's verdicts, compared with labels.

use schemars::JsonSchema;
use serde::Serialize;

use super::{About, Format, Run, Truth, built_in, number, outcome, share};
use crate::open::{configuration, user_thresholds};
use crate::{Failure, Outcome, json, output};
use nearmiss_record::{Record, Table, columns, rows as rows_of};
use nearmiss_scene::judge::{self, Judgement, judge_collision, judge_recording};
use nearmiss_scene::metrics::{RiskConvention, Thresholds};
use nearmiss_scene::scenario::Scene;
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::{AnswerStatus, Confusion, Label, Scored};
use nearmiss_workflow::batch::BuiltInAnswers;

pub(super) fn run(arguments: &Run, task: Task, about: About<'_>) -> Outcome {
    let truth = about.0;
    let (judge, others): (fn(&Scene, &Thresholds) -> Judgement, _) = match task {
        Task::Recording => (judge_recording, "CSV or score:paper"),
        _ => (judge_collision, "CSV or layout"),
    };
    let is_its_own = match truth.known.convention() {
        Some(convention) => task == Task::Collision || convention == RiskConvention::Exact,
        // Where a layout has no collision, the exact score of the recording is the truth.
        None => truth.is_geometry() || task == Task::Recording && truth.is_layout(),
    };
    if is_its_own {
        return Err(Failure::input(format!(
            "--task {} needs --truth {others}: the built-in judge itself answers from the exact geometry",
            task.name()
        )));
    }
    let (folders, _) = configuration()?;
    let thresholds = user_thresholds(&folders)?;
    let answers = built_in((task, &thresholds), about, |entry, case| {
        let verdict = judge(case.scene, &thresholds).verdict;
        Scored::built_in(&entry.name, judge::MODEL, Some(case.label), verdict)
    })?;
    if !answers.judged.is_empty() {
        write(arguments, task, truth, &answers)?;
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

    fn line(&self, task: Task) -> LabelRow {
        LabelRow {
            scenario: self.name.into(),
            label: words(task, self.label),
            judge: words(task, self.judge),
            agrees: !self.differs(),
        }
    }

    fn differs(&self) -> bool {
        match (self.label, self.judge) {
            (Label::Collision(Some(id)), Label::Collision(said)) => said != Some(id),
            (label, judge) => label.collides() != judge.collides(),
        }
    }
}

fn write(arguments: &Run, task: Task, truth: &Truth, answers: &BuiltInAnswers<Scored>) -> Outcome {
    let c = Confusion::from_scored(answers.judged.iter().map(|(_, one)| one), Scored::positive);
    let rows: Vec<Row<'_>> = answers.judged.iter().map(Row::of).collect();
    // Of the collisions that were found and have an obstacle in their label.
    let (mut named, mut who) = (0_u32, 0_u32);
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
                "{} task: {}, {}\ntruth: {}\n\n{:<20} precision {}  recall {}  F1 {}  \
                 the labelled obstacle {who} of {named}\n",
                task.name(),
                number(c.positives() as usize, dangerous(task)),
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
                    words(task, row.label),
                    words(task, row.judge)
                );
                text.push_str(&output::visible(&line));
            }
            output::text(&text)
        }
        Format::Csv => {
            let lines: Vec<LabelRow> = rows.iter().map(|row| row.line(task)).collect();
            let table = Table::new("labels", columns::<LabelRow>());
            let csv = table.csv(rows_of(&lines).map_err(Failure::input)?);
            output::text(&String::from_utf8_lossy(&csv))
        }
        Format::Json => output::document(&CollisionDocument {
            task: task.name(),
            truth: truth.json(),
            model: judge::MODEL,
            counts: c,
            precision: c.precision(),
            recall: c.recall(),
            f1: c.f1(),
            obstacles_labelled: named,
            obstacles_right: who,
            differences: other.map(|row| row.line(task)).collect(),
            failed: answers.failed,
            without_ego: answers.without_ego.clone(),
            unlabelled: answers.unlabelled.clone(),
        }),
    }
}

/// The built-in judge beside labels of whole recordings, for programs.
#[derive(Serialize, JsonSchema)]
pub struct CollisionDocument {
    /// The task: collision or recording.
    task: &'static str,
    /// Source of the ground truth.
    truth: serde_json::Value,
    /// The built-in judge.
    model: &'static str,
    /// Its answers beside the labels.
    #[serde(flatten)]
    counts: Confusion,
    /// tp / (tp + fp).
    precision: Option<f64>,
    /// tp / (tp + fn).
    recall: Option<f64>,
    /// Harmonic mean of precision and recall.
    f1: Option<f64>,
    /// Found collisions whose label names an obstacle.
    obstacles_labelled: u32,
    /// Of these, those with the right obstacle.
    obstacles_right: u32,
    /// Scenarios where label and judge differ.
    differences: Vec<LabelRow>,
    /// Number of scenarios that could not be opened.
    failed: usize,
    /// Scenarios without a recorded ego.
    without_ego: Vec<String>,
    /// Scenarios without ground truth.
    unlabelled: Vec<String>,
}

impl json::Output for CollisionDocument {
    const NAME: &'static str = "evaluate-collision";
    const TITLE: &'static str = "`evaluate --task collision --format json` of the built-in judge";
}

/// The label of a scenario beside the judge's.
#[derive(Serialize, JsonSchema)]
struct LabelRow {
    /// The scenario.
    scenario: String,
    /// Its label.
    label: String,
    /// What the judge says.
    judge: String,
    /// Whether they agree.
    agrees: bool,
}

impl Record for LabelRow {
    const NAME: &'static str = "label";
    const TITLE: &'static str = "The label of a scenario beside the judge's";
}

/// What a yes is called.
fn dangerous(task: Task) -> &'static str {
    match task {
        Task::Recording => "high-risk recording",
        _ => "collision",
    }
}

fn words(task: Task, label: Label) -> String {
    let yes = match task {
        Task::Recording => "high risk",
        _ => "collision",
    };
    match label {
        Label::Safe => "safe".into(),
        Label::Collision(None) => yes.into(),
        Label::Collision(Some(id)) => format!("{yes} {id}"),
    }
}

//! The safety task: precision, recall and F1 by the time to the collision, and false alarms.

use std::collections::HashMap;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use super::{About, Format, Run, Truth, built_in, number, outcome};
use crate::open::{configuration, user_thresholds};
use crate::{Failure, Outcome, json, output};
use nearmiss_formats::Entry;
use nearmiss_record::{Cell, Column, Kind, Record, Table, columns, rows as rows_of, text_table};
use nearmiss_scene::judge::Criterion;
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::batch::{Experiment, stored_path};
use nearmiss_study::evaluation::report::LeadWord;
use nearmiss_study::evaluation::windows::{MATCHED_ON, Recording, SampledWindow, WITHIN};
use nearmiss_study::evaluation::{
    Alarms, Candidate, Confusion, CriticalMoments, Labelled, Lead, Naming, Predictions, Scored,
    Setting,
};
use nearmiss_workflow::batch::{BuiltInAnswers, BuiltInRequest};

pub(super) fn run(
    arguments: &Run,
    asked: &Experiment,
    candidates: Vec<Candidate>,
    about: About<'_>,
) -> Outcome {
    let truth = about.0;
    let (folders, _) = configuration()?;
    let setting = Setting {
        leads: if asked.leads.is_empty() {
            LEADS.to_vec()
        } else {
            asked.leads.clone()
        },
        history: asked.history.unwrap_or(10),
        within: asked.within.unwrap_or(WITHIN),
        radius: asked.radius.unwrap_or(30.0),
        candidates,
        thresholds: Arc::new(user_thresholds(&folders)?),
        every_window: true,
    };
    let mut answers = judged(&setting, about)?;
    if !answers.judged.is_empty() {
        let of_each = answers.judged.iter_mut().map(|(_, of)| std::mem::take(of));
        let rows = rows(&setting, of_each);
        let judges = || -> Vec<JudgeRow> {
            let rows = rows.iter();
            rows.map(|row| JudgeRow::new(&setting, row)).collect()
        };
        match arguments.format() {
            Format::Table => output::text(&table(&setting, truth, &answers, &rows))?,
            Format::Csv => csv(&judges())?,
            Format::Json => output::document(&document(&setting, truth, &answers, judges()))?,
        }
    }
    outcome(&answers)
}

/// Draws the windows of all scenarios, then judges them: each scenario is opened twice, so that not all are in memory.
fn judged(setting: &Setting, about: About<'_>) -> Result<Judged, Failure> {
    let (truth, entries, ego) = about;
    let thresholds = &*setting.thresholds;
    let known = built_in((Task::Safety, thresholds), about, |entry, case| {
        let recording = match truth.known.convention() {
            // A scene without scores is left out before.
            Some(convention) => CriticalMoments::new(convention, case.scene, thresholds)
                .unwrap_or_default()
                .recording(&entry.name, case.scene, setting.radius),
            None => Recording::new(&entry.name, case, setting.radius),
        };
        (stored_path(entry), recording)
    })?;
    let (paths, recordings): (Vec<String>, Vec<Recording>) =
        known.judged.iter().map(|(_, of)| of.clone()).unzip();
    let windows: HashMap<String, Vec<Vec<SampledWindow>>> = paths
        .into_iter()
        .zip(setting.windows(&recordings))
        .collect();
    let none = vec![Vec::new(); setting.leads.len()];
    let request = BuiltInRequest {
        ego,
        entries,
        truth: &truth.known,
        task: Task::Safety,
        thresholds,
    };
    let judge = |entry: &Entry, case: &Labelled<'_>| {
        let windows = windows.get(&stored_path(entry)).unwrap_or(&none);
        setting.ask(&entry.name, case, windows)
    };
    let answers = request.run(judge, |_| ());
    answers.map_err(|wrong| Failure::input(format!("--truth: {wrong}")))
}

/// Leads by default.
const LEADS: [Lead; 6] = [
    Lead::Paper,
    Lead::Seconds(0.2),
    Lead::Seconds(0.5),
    Lead::Seconds(1.0),
    Lead::Seconds(1.5),
    Lead::Seconds(2.0),
];

type Judged = BuiltInAnswers<Vec<Predictions>>;

/// Results of one candidate.
struct Row {
    candidate: Candidate,
    /// At each lead.
    leads: Vec<Counts>,
    alarms: Alarms,
}

impl Row {
    fn line(&self, figures: Vec<Option<f64>>) -> Line {
        let Candidate { name, criterion } = self.candidate;
        (name, Some(criterion), figures)
    }
}

/// Results of one candidate at one lead.
struct Counts {
    answers: Vec<Scored>,
    said: Confusion,
    naming: Naming,
}

impl Counts {
    fn of(answers: Vec<Scored>) -> Self {
        let mut naming = Naming::default();
        answers.iter().for_each(|one| naming.count(one));
        Self {
            said: Confusion::from_scored(&answers, Scored::positive),
            naming,
            answers,
        }
    }

    /// The scenarios with this truth and answer.
    fn scenarios(&self, truth: bool, said: bool) -> Vec<&str> {
        let those = self
            .answers
            .iter()
            .filter(|one| (one.is_collision(), one.positive()) == (Some(truth), Some(said)));
        those.map(|one| one.scenario.as_str()).collect()
    }
}

fn rows(setting: &Setting, of_each: impl Iterator<Item = Vec<Predictions>>) -> Vec<Row> {
    let all = setting.candidates.iter().zip(setting.join(of_each));
    let row = |(candidate, all): (&Candidate, Predictions)| Row {
        candidate: *candidate,
        leads: all.leads.into_iter().map(Counts::of).collect(),
        alarms: all.alarms,
    };
    all.map(row).collect()
}

/// Title of a table block, and its number for one candidate and lead.
type Block = (&'static str, fn(&Counts) -> Option<f64>);

const BLOCKS: [Block; 5] = [
    ("F1", |c| c.said.f1()),
    ("precision", |c| c.said.precision()),
    ("recall", |c| c.said.recall()),
    ("obstacle named", |c| c.naming.recall()),
    ("names right", |c| c.naming.precision()),
];

fn table(setting: &Setting, truth: &Truth, answers: &Judged, rows: &[Row]) -> String {
    // What is dangerous: the scenario, its moment, and what follows a dangerous window.
    let [scenario, moment, follows] = match truth.known.convention() {
        Some(_) => ["critical scenario", "extreme risk", "extreme risk"],
        None => ["collision", "overlap", "contact"],
    };
    let mut text = format!(
        "safety task: {}, {}\ntruth: {}\nwindows: {}, obstacles within {} m; dangerous ones end the given seconds before \
         the first\n{moment} (end: two steps before the last recorded step), each beside a safe one like it in \
         position,\ntraffic and speed; dangerous: {follows} within {} s after the window\nobstacle named: share of \
         dangerous windows whose obstacle is named\nnames right: share of the named obstacles that are critical\ns: horizon in \
         seconds; p ≥: probability of contact from which on a window is critical\n",
        number(answers.collisions(), scenario),
        number(answers.safe(), "safe scenario"),
        truth.words(),
        number(setting.history, "step"),
        setting.radius,
        setting.within,
    );
    let leads = |decimals| {
        let leads = setting.leads.iter().map(Lead::to_string);
        leads.map(|lead| (lead, decimals)).collect::<Vec<_>>()
    };
    for (name, value) in BLOCKS {
        let lines = rows
            .iter()
            .map(|row| row.line(row.leads.iter().map(value).collect()));
        text += &block(name, &leads(3), lines);
    }
    let Some(first) = rows.first() else {
        return text;
    };
    let count = |of: fn(&Confusion) -> u32| -> Vec<Option<f64>> {
        let leads = first.leads.iter();
        leads.map(|lead| Some(f64::from(of(&lead.said)))).collect()
    };
    let windows = [
        ("dangerous", None, count(Confusion::positives)),
        ("safe", None, count(Confusion::negatives)),
    ];
    text += &block("windows", &leads(0), windows);
    text += &format!(
        "\nfalse alarms over all {} of the safe scenarios ({:.1} min)\nshare: fraction of windows called critical; \
         per min: alarms per minute (critical windows less\nthan {} s apart are one alarm)\n",
        number(first.alarms.windows as usize, "window"),
        first.alarms.seconds / 60.0,
        Alarms::APART,
    );
    let titles = [("share".into(), 3), ("per min".into(), 2)];
    let alarms = |row: &Row| vec![alarmed(&row.alarms), row.alarms.per_minute()];
    let lines = rows.iter().map(|row| row.line(alarms(row)));
    text + &block("false alarms", &titles, lines)
}

/// A line of a block: whose it is, with which criterion, and figures.
type Line = (&'static str, Option<Criterion>, Vec<Option<f64>>);

/// Figures under titles, with so many digits behind the point.
fn block(
    title: &'static str,
    titles: &[(String, usize)],
    lines: impl IntoIterator<Item = Line>,
) -> String {
    let number = |title: String, decimals| Column {
        title: title.into(),
        decimals: Some(decimals),
        ..Column::new("", Kind::Number, "", "")
    };
    let label = Column {
        title: title.into(),
        ..Column::new("", Kind::Text, "", "")
    };
    let titles = titles.iter().cloned();
    let figures = titles.map(|(title, decimals)| number(title, decimals));
    let head = [label, number("s".into(), 1), number("p ≥".into(), 2)];
    let columns: Vec<Column> = head.into_iter().chain(figures).collect();
    let cell = |value: Option<f64>| value.map_or(Cell::None(""), Cell::finite);
    let row = |(label, criterion, figures): Line| {
        let head = [
            Cell::from(label),
            cell(criterion.map(|c| c.horizon)),
            cell(criterion.map(|c| c.threshold)),
        ];
        head.into_iter()
            .chain(figures.into_iter().map(cell))
            .collect()
    };
    let rows: Vec<Vec<Cell>> = lines.into_iter().map(row).collect();
    format!("\n{}", text_table(&columns, &rows))
}

fn alarmed(alarms: &Alarms) -> Option<f64> {
    (alarms.windows > 0).then(|| f64::from(alarms.alarmed) / f64::from(alarms.windows))
}

/// The built-in judge at each lead, for programs.
#[derive(Serialize, JsonSchema)]
pub struct SafetyDocument {
    /// The task: safety.
    task: &'static str,
    /// Which windows are evaluated.
    windows: &'static str,
    /// What safe windows are matched to dangerous ones on.
    matched_on: &'static str,
    /// Horizon of the truth after a window, seconds.
    within: f64,
    /// Source of the ground truth.
    truth: serde_json::Value,
    /// Steps in a window.
    history: usize,
    /// Radius in metres.
    radius: f64,
    /// Number of collisions.
    collisions: usize,
    /// Number of safe scenarios.
    safe: usize,
    /// Number of scenarios that could not be opened.
    failed: usize,
    /// Scenarios without a recorded ego.
    without_ego: Vec<String>,
    /// Scenarios without ground truth.
    unlabelled: Vec<String>,
    /// Results by model, horizon and threshold.
    judges: Vec<JudgeRow>,
}

impl json::Output for SafetyDocument {
    const NAME: &'static str = "evaluate-safety";
    const TITLE: &'static str = "`evaluate --format json` of the built-in judge, safety task";
}

/// A judge or predictor at all leads.
#[derive(Serialize, JsonSchema)]
struct JudgeRow {
    /// Its name.
    model: &'static str,
    /// Its horizon, seconds.
    horizon: f64,
    /// The probability of contact from which on a window is critical.
    threshold: f64,
    /// At each lead.
    leads: Vec<LeadFigures>,
    /// False alarms over all windows of the safe scenarios.
    all_safe_windows: AlarmFigures,
}

/// A judge or predictor at one lead.
#[derive(Clone, Serialize, JsonSchema)]
struct LeadFigures {
    /// Seconds from the end of the window to the collision, or `end`.
    lead: LeadWord,
    /// Number of dangerous windows.
    collisions: u32,
    /// Number of safe windows.
    safe: u32,
    /// Its answers beside the truth.
    #[serde(flatten)]
    counts: Confusion,
    /// tp / (tp + fp).
    precision: Option<f64>,
    /// tp / (tp + fn).
    recall: Option<f64>,
    /// Harmonic mean of precision and recall.
    f1: Option<f64>,
    /// The share of dangerous windows whose obstacle is named.
    naming_recall: Option<f64>,
    /// The share of named obstacles that are critical.
    naming_precision: Option<f64>,
    /// Scenarios whose dangerous window is called safe.
    missed: Vec<String>,
    /// Scenarios whose safe window is called dangerous.
    false_alarms: Vec<String>,
}

/// False alarms over all windows of the safe scenarios.
#[derive(Clone, Copy, Serialize, JsonSchema)]
struct AlarmFigures {
    /// Windows looked at.
    windows: u32,
    /// Those called critical.
    alarmed: u32,
    /// Alarms: critical windows that are near in time are one.
    alarms: u32,
    /// Minutes that the windows span.
    minutes: f64,
    /// Alarms per minute.
    alarms_per_minute: Option<f64>,
}

/// A judge or predictor at one lead, as a row of CSV.
#[derive(Serialize, JsonSchema)]
struct LeadLine {
    /// Its name.
    model: &'static str,
    /// Its horizon, seconds.
    horizon: f64,
    /// The probability of contact from which on a window is critical.
    threshold: f64,
    /// At the lead.
    #[serde(flatten)]
    figures: LeadFigures,
    /// False alarms over all windows of the safe scenarios.
    all_safe_windows: AlarmFigures,
}

impl Record for LeadLine {
    const NAME: &'static str = "judge-lead";
    const TITLE: &'static str = "A judge or predictor at one lead";
}

impl JudgeRow {
    fn new(setting: &Setting, row: &Row) -> Self {
        let figures = |(lead, counts): (&Lead, &Counts)| {
            let c = &counts.said;
            let named = |truth, said| {
                let names = counts.scenarios(truth, said).into_iter();
                names.map(String::from).collect()
            };
            LeadFigures {
                lead: (*lead).into(),
                collisions: c.positives(),
                safe: c.negatives(),
                counts: *c,
                precision: c.precision(),
                recall: c.recall(),
                f1: c.f1(),
                naming_recall: counts.naming.recall(),
                naming_precision: counts.naming.precision(),
                missed: named(true, false),
                false_alarms: named(false, true),
            }
        };
        Self {
            model: row.candidate.name,
            horizon: row.candidate.criterion.horizon,
            threshold: row.candidate.criterion.threshold,
            leads: setting.leads.iter().zip(&row.leads).map(figures).collect(),
            all_safe_windows: AlarmFigures {
                windows: row.alarms.windows,
                alarmed: row.alarms.alarmed,
                alarms: row.alarms.alarms,
                minutes: row.alarms.seconds / 60.0,
                alarms_per_minute: row.alarms.per_minute(),
            },
        }
    }

    fn lines(&self) -> impl Iterator<Item = LeadLine> {
        self.leads.iter().map(|figures| LeadLine {
            model: self.model,
            horizon: self.horizon,
            threshold: self.threshold,
            figures: figures.clone(),
            all_safe_windows: self.all_safe_windows,
        })
    }
}

fn csv(judges: &[JudgeRow]) -> Outcome {
    let lines: Vec<LeadLine> = judges.iter().flat_map(JudgeRow::lines).collect();
    let table = Table::new("judges", columns::<LeadLine>());
    let csv = table.csv(rows_of(&lines).map_err(Failure::input)?);
    output::text(&String::from_utf8_lossy(&csv))
}

fn document(
    setting: &Setting,
    truth: &Truth,
    answers: &Judged,
    judges: Vec<JudgeRow>,
) -> SafetyDocument {
    SafetyDocument {
        task: Task::Safety.name(),
        windows: "dangerous ones end at the lead, safe ones are like them",
        matched_on: MATCHED_ON,
        within: setting.within,
        truth: truth.json(),
        history: setting.history,
        radius: setting.radius,
        collisions: answers.collisions(),
        safe: answers.safe(),
        failed: answers.failed,
        without_ego: answers.without_ego.clone(),
        unlabelled: answers.unlabelled.clone(),
        judges,
    }
}

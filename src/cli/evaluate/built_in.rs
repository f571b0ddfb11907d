//! `nearmiss evaluate` with built-in models alone: the judge beside simpler predictors on the questions of a batch that
//! is neither sent nor stored.

use std::collections::BTreeMap;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};

use super::context::planned;
use super::options::{Format, Run};
use super::table::{BatchTable, table};
use super::{number, some};
use crate::open::{configuration, doubts, found, not_opened, user_thresholds};
use crate::output::Progress;
use crate::{Failure, Outcome, knobs, output};
use nearmiss_ask::prompts::Library;
use nearmiss_formats::Entry;
use nearmiss_record::fields::{Fields, Layers};
use nearmiss_record::{Record, Table, columns, row, rows};
use nearmiss_scene::judge;
use nearmiss_scene::metrics::RiskConvention;
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::batch::{Experiment, TruthSource};
use nearmiss_study::evaluation::report::{LeadRow, LeadWord};
use nearmiss_study::evaluation::{Alarms, AnswerCase, Candidate, Label, Lead, PAPER_STEPS};
use nearmiss_workflow::batch::{BatchPlan, BatchRequest, BuiltInAnswers, BuiltInEvent};

/// Leads by default.
const LEADS: [Lead; 6] = [
    Lead::Paper,
    Lead::Seconds(0.2),
    Lead::Seconds(0.5),
    Lead::Seconds(1.0),
    Lead::Seconds(1.5),
    Lead::Seconds(2.0),
];

/// Obstacles are predicted within so many metres of the ego by default.
const RADIUS: f64 = 30.0;

pub fn run(arguments: &Run) -> Outcome {
    // Nothing is asked in words.
    let library = Library::load(None);
    let mut layers = Layers::default();
    let usual = Experiment {
        scenarios: arguments.paths.clone(),
        models: vec![judge::MODEL.into()],
        truth: Some(TruthSource::Geometry),
        history: Some(PAPER_STEPS),
        radius: Some(RADIUS),
        ..Experiment::default()
    };
    layers.fields("", &usual);
    arguments.add_knobs(&mut layers);
    let has_leads = layers.has("leads");
    let mut experiment = knobs::complete(layers, &library)?;
    experiment.models = usual.models;
    let task = experiment.tasks.first().copied().unwrap_or(Task::Safety);
    if task.is_about_all_steps() {
        // The judge looks at the whole recording, so no windows are drawn.
        experiment.within = None;
    } else if !has_leads {
        experiment.leads = LEADS.to_vec();
    }
    let candidates = candidates(arguments, task)?;
    refuse_own_answer(task, experiment.truth.as_ref())?;
    let entries = found(&arguments.paths)?;
    let request = BatchRequest {
        ego: arguments.ego(&entries)?,
        entries,
        shard: None,
        drafts: BTreeMap::new(),
        experiment,
    };
    let (folders, _) = configuration()?;
    let thresholds = Arc::new(user_thresholds(&folders)?);
    let plan = planned(|cancel, on_event| request.plan(&library, &thresholds, cancel, on_event))?;
    let progress = Progress::new(plan.scenarios(), "scenarios", true);
    let answered = plan.built_in(&candidates, |entry, event| {
        progress.step();
        progress.suspend(|| say(entry, event));
    });
    drop(progress);
    let answers = answered.map_err(Failure::input)?;
    if !answers.without_ego.is_empty() {
        output::say(&format!(
            "nearmiss: {} without a recorded ego: {}; add --ego planner, or put NAME.ego_trajectory.csv beside NAME.xml",
            number(answers.without_ego.len(), "scenario"),
            some(&answers.without_ego),
        ));
    }
    let end = outcome(&answers);
    if answers.collisions + answers.safe > 0 {
        let counted = BatchTable::new(None, &answers.answers);
        let document = BuiltInDocument::new(&plan, &candidates, answers);
        match arguments.format {
            Format::Table => output::text(&document.text(&plan, &counted)?)?,
            Format::Csv => output::text(&document.csv(&counted)?)?,
            Format::Json => {
                output::document(&BatchTable::document(
                    None,
                    vec![counted],
                    Vec::new(),
                    Some(document),
                ))?;
            }
        }
    }
    end
}

/// Refuses a truth that is what the judge itself says about whole recordings.
fn refuse_own_answer(task: Task, truth: Option<&TruthSource>) -> Outcome {
    use TruthSource::{Geometry, Layout, Score};
    let others = match (task, truth) {
        (Task::Collision, Some(Geometry | Score(_))) => "CSV or layout",
        // Where a layout has no collision, the exact score of the recording is the truth.
        (Task::Recording, Some(Geometry | Layout | Score(RiskConvention::Exact))) => {
            "CSV or score:paper"
        }
        _ => return Ok(()),
    };
    Err(Failure::input(format!(
        "--task {} needs --truth {others}: the built-in judge itself answers from the exact geometry",
        task.name()
    )))
}

fn candidates(arguments: &Run, task: Task) -> Result<Vec<Candidate>, Failure> {
    let known = if task == Task::Safety {
        &Candidate::NAMES[..]
    } else {
        &[judge::MODEL]
    };
    let named: Vec<&str> = arguments.model.iter().map(String::as_str).collect();
    let names = if named.is_empty() { known } else { &named };
    let mut found: Vec<Candidate> = Vec::new();
    for name in names {
        let more = Candidate::by_name(name, &arguments.horizon).filter(|_| known.contains(name));
        let Some(more) = more else {
            return Err(Failure::input(format!(
                "--model {name}: the {} task takes {}",
                task.name(),
                known.join(", "),
            )));
        };
        for candidate in more {
            if !found.contains(&candidate) {
                found.push(candidate);
            }
        }
    }
    Ok(found)
}

/// Says what is doubtful about a scenario, or why it has no answer.
fn say(entry: &Entry, event: BuiltInEvent) {
    let say = |words: &str| output::say(&format!("nearmiss: {}: {words}", entry.name));
    match event {
        BuiltInEvent::Judged { scene, doubt } => {
            doubts(entry, &scene)
                .iter()
                .for_each(|doubt| output::say(doubt));
            doubt.into_iter().for_each(say);
        }
        BuiltInEvent::NotScored(why) => say(&why),
        BuiltInEvent::Failed(error) => not_opened(error).say(),
        // They are told together.
        BuiltInEvent::WithoutEgo | BuiltInEvent::Unlabelled => {}
    }
}

/// How it ends, when everything is written.
fn outcome(answers: &BuiltInAnswers) -> Outcome {
    let (without, unlabelled) = (answers.without_ego.len(), answers.unlabelled.len());
    let reasons = [
        (answers.failed, "could not be opened".into()),
        (without, "without a recorded ego".into()),
        (
            unlabelled,
            format!("without a label or score ({})", some(&answers.unlabelled)),
        ),
    ];
    let judged = answers.collisions + answers.safe;
    let left = reasons.into_iter().filter(|(count, _)| *count > 0);
    let words: Vec<String> = left.map(|(count, why)| format!("{count} {why}")).collect();
    if words.is_empty() {
        return Ok(());
    }
    let all = number(judged + answers.failed + without + unlabelled, "scenario");
    Err(Failure {
        message: format!("of {all}, {}", words.join(", ")),
        status: if judged == 0 { 2 } else { 1 },
    })
}

/// What an evaluation without a stored batch has beside the tables of one, for programs.
#[derive(Serialize, JsonSchema)]
pub struct BuiltInDocument {
    /// How it was asked, with the keys of experiment files.
    asked: Map<String, Value>,
    /// Scenarios that are a collision in truth, critical or of high risk.
    collisions: usize,
    /// Scenarios that are not.
    safe: usize,
    /// Number of scenarios that could not be opened.
    failed: usize,
    /// Scenarios without a recorded ego.
    without_ego: Vec<String>,
    /// Scenarios without ground truth.
    unlabelled: Vec<String>,
    /// The predictors of the safety task, with their false alarms over all windows of the safe scenarios.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    predictors: Vec<PredictorRow>,
    /// Answers that differ from the truth.
    differences: Vec<AnswerDifference>,
}

/// A predictor, with its false alarms over all windows of the safe scenarios.
#[derive(Clone, Serialize, JsonSchema)]
struct PredictorRow {
    /// The model of its answers.
    #[schemars(title = "false alarms")]
    model: String,
    /// Its horizon, seconds.
    #[schemars(title = "s", extend("decimals" = 1))]
    horizon: f64,
    /// The probability of contact from which on a window is critical.
    #[schemars(title = "p ≥", extend("decimals" = 2))]
    threshold: f64,
    /// Windows looked at.
    windows: u32,
    /// Those called critical.
    alarmed: u32,
    /// Their share.
    #[schemars(title = "share", extend("decimals" = 3))]
    alarmed_share: Option<f64>,
    /// Alarms: critical windows that are near in time are one.
    alarms: u32,
    /// Minutes that the windows span.
    minutes: f64,
    /// Alarms per minute.
    #[schemars(title = "per min", extend("decimals" = 2))]
    alarms_per_minute: Option<f64>,
}

impl Record for PredictorRow {
    const NAME: &'static str = "predictor";
    const TITLE: &'static str =
        "A predictor, with its false alarms over all windows of the safe scenarios";
}

/// An answer that differs from the truth.
#[derive(Serialize, JsonSchema)]
struct AnswerDifference {
    /// The scenario.
    #[schemars(title = "Differences")]
    scenario: String,
    /// Who says it.
    model: String,
    /// The lead of the window; null for whole recordings.
    lead: Option<LeadWord>,
    /// What is true: `dangerous` or `safe`.
    #[schemars(title = "truth")]
    label: &'static str,
    /// Obstacles that are truly critical.
    #[schemars(title = "obstacles")]
    critical: Vec<i64>,
    /// What the model says.
    #[schemars(title = "judge")]
    said: &'static str,
    /// Obstacles that it names.
    #[schemars(title = "obstacles")]
    named: Vec<i64>,
}

impl Record for AnswerDifference {
    const NAME: &'static str = "answer-difference";
    const TITLE: &'static str = "An answer that differs from the truth";
}

impl AnswerDifference {
    /// Of whole recordings, another obstacle than that of the label differs, too.
    fn find(case: AnswerCase<'_>) -> Option<Self> {
        let scored = case.scored;
        let (verdict, truth) = (scored.status.verdict()?, scored.is_collision()?);
        let named: Vec<i64> = verdict.obstacles.iter().map(|o| o.id).collect();
        let labelled = match scored.truth? {
            Label::Collision(id) if verdict.task.is_about_all_steps() => id,
            _ => None,
        };
        let other = labelled.is_some_and(|id| named.first() != Some(&id));
        let word = |dangerous| if dangerous { "dangerous" } else { "safe" };
        (other || verdict.dangerous != truth).then(|| Self {
            scenario: scored.scenario.clone(),
            model: scored.configuration.model.clone(),
            lead: case.lead.map(LeadWord::from),
            label: word(truth),
            critical: scored.critical.clone(),
            said: word(verdict.dangerous),
            named,
        })
    }
}

/// What people read of a row by lead.
const SHOWN: [(&str, &str); 10] = [
    ("model", "Model"),
    ("lead", "Lead"),
    ("n", "n"),
    ("yes_rate", "Recall"),
    ("named_rate", "Named"),
    ("false_alarms", "False alarms"),
    ("false_alarms_of", "Safe"),
    ("precision", "Precision"),
    ("f1", "F1"),
    ("naming_precision", "Names right"),
];

impl BuiltInDocument {
    fn new(plan: &BatchPlan, candidates: &[Candidate], found: BuiltInAnswers) -> Self {
        let experiment = &plan.spec.experiment;
        let each = candidates.iter().zip(&found.alarms);
        let predictors = each.map(|(candidate, alarms)| PredictorRow {
            model: candidate.model(),
            horizon: candidate.criterion.horizon,
            threshold: candidate.criterion.threshold,
            windows: alarms.windows,
            alarmed: alarms.alarmed,
            alarmed_share: alarms.share(),
            alarms: alarms.alarms,
            minutes: alarms.seconds / 60.0,
            alarms_per_minute: alarms.per_minute(),
        });
        let cases = found.answers.cases().into_iter();
        Self {
            predictors: predictors
                .filter(|_| experiment.tasks == [Task::Safety])
                .collect(),
            differences: cases.filter_map(AnswerDifference::find).collect(),
            asked: experiment.asked().to_json(),
            collisions: found.collisions,
            safe: found.safe,
            failed: found.failed,
            without_ego: found.without_ego,
            unlabelled: found.unlabelled,
        }
    }

    /// The rows by lead, each with its predictor; without leads the cells.
    fn csv(&self, counted: &BatchTable) -> Result<String, Failure> {
        let leads = counted.by_lead();
        if leads.is_empty() {
            return Ok(BatchTable::csv(None, std::slice::from_ref(counted)));
        }
        let mut all = rows(&leads).map_err(Failure::input)?;
        for (line, lead) in all.iter_mut().zip(&leads) {
            let is_its = |one: &&PredictorRow| one.model == lead.configuration.model;
            if let Some(predictor) = self.predictors.iter().find(is_its) {
                line.extend(row(predictor).map_err(Failure::input)?.split_off(1));
            }
        }
        let of_predictor = columns::<PredictorRow>().split_off(1);
        let columns = columns::<LeadRow>().into_iter().chain(of_predictor);
        let csv = Table::new("leads", columns.collect()).csv(all);
        Ok(String::from_utf8_lossy(&csv).into_owned())
    }

    /// For people.
    fn text(&self, plan: &BatchPlan, counted: &BatchTable) -> Result<String, Failure> {
        let experiment = &plan.spec.experiment;
        let by_score = matches!(plan.spec.truth(), TruthSource::Score(_));
        let [dangerous, moment, follows] = match (&experiment.tasks[..], by_score) {
            ([Task::Recording], _) => ["high-risk recording", "", ""],
            ([Task::Safety], true) => ["critical scenario", "extreme risk", "extreme risk"],
            _ => ["collision", "overlap", "contact"],
        };
        let mut text = format!(
            "{} task: {}, {}\ntruth: {}\n",
            experiment.texts("tasks").join(","),
            number(self.collisions, dangerous),
            number(self.safe, "safe scenario"),
            output::visible(&plan.spec.truth_summary()),
        );
        let Some(first) = self.predictors.first() else {
            let differences = table(&columns::<AnswerDifference>(), &self.differences)?;
            return Ok(format!("{text}\n{}\n{differences}", counted.text()?));
        };
        text += &format!(
            "windows: {}, obstacles within {} m; dangerous ones end the given seconds before the first\n{moment} (end: two \
             steps before the last recorded step), each beside a safe one like it in position,\ntraffic and speed; dangerous: \
             {follows} within {} s after the window\n",
            number(experiment.history.unwrap_or_default(), "step"),
            experiment.radius.unwrap_or_default(),
            experiment.within.unwrap_or_default(),
        );
        let leads = counted.by_lead();
        text += "\n";
        if leads.is_empty() {
            text += &counted.text()?;
        } else {
            let mut shown = columns::<LeadRow>();
            for column in &mut shown {
                let known = SHOWN.iter().find(|(name, _)| *name == column.name);
                column.title = known.map_or("", |(_, title)| title).into();
            }
            text += &table(&shown, &leads)?;
            text += "n: dangerous windows; Safe: safe ones; Named: share of dangerous windows whose obstacle is named\n";
        }
        text += &format!(
            "\nfalse alarms over all {} of the safe scenarios ({:.1} min)\nshare: fraction of windows called critical; per min: \
             alarms per minute (critical windows less\nthan {} s apart are one alarm); s: horizon in seconds; p ≥: probability \
             of contact from which\non a window is critical\n\n",
            number(first.windows as usize, "window"),
            first.minutes,
            Alarms::APART,
        );
        Ok(text + &table(&columns::<PredictorRow>(), &self.predictors)?)
    }
}

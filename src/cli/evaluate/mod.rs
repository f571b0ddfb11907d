//! `nearmiss evaluate`: measures how good the built-in judge and language models are on many scenarios.

mod batch;
mod collision;
mod context;
mod drawing;
mod dry_run;
mod experiment;
mod leaks;
mod listed;
mod options;
mod resume;
mod running;
mod safety;
mod split_table;
mod submit;
mod table;
mod truth;

pub use collision::CollisionDocument;
pub use context::BatchContext;
pub use drawing::planned;
pub use dry_run::{DryRunDocument, make as questions_of};
pub use leaks::LeaksDocument;
pub use listed::ListedDocument;
pub use options::part_of_split;
pub use running::runtime;
pub use safety::SafetyDocument;
use std::path::PathBuf;
pub use table::BatchDocument;

use super::doubts::doubts;
use super::open::{found, not_opened, task};
use super::output::counted as number;
use super::plan::as_ego;
use super::progress::Progress;
use super::span::history;
use super::{Failure, Outcome, output};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::judge;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::windows::WITHIN;
use nearmiss_study::evaluation::{Candidate, Labelled, Lead};
use nearmiss_workflow::batch::{BatchError, BuiltInAnswers, BuiltInEvent, BuiltInRequest};
use truth::{Truth, truth};

/// Arguments of `evaluate`.
#[derive(Debug, clap::Args)]
pub struct Evaluate {
    /// Scenario files, folders or names of bundled scenarios, each with its recorded ego; or one experiment file
    /// (FILE.toml, see `nearmiss help experiments`).
    #[arg(required_unless_present_any = ["resume", "list"])]
    paths: Vec<PathBuf>,
    /// Models to evaluate, separated by commas: provider/model, reference/geometry; for the safety task also the
    /// baselines reference/constant-velocity and reference/constant-acceleration [default: all built-in ones for the
    /// task].
    #[arg(long, value_delimiter = ',', value_name = "MODEL")]
    model: Vec<String>,
    /// Task: safety, collision or recording (is it safe or of high risk as a whole); language models take several,
    /// separated by commas [default: safety].
    #[arg(long, value_delimiter = ',', value_parser = task)]
    task: Vec<Task>,
    /// Ground truth: `auto` is the exact geometry of the recordings; `layout` reads the folders collision_scenarios and
    /// normal_scenarios with their annotations; `score` is the risk score of TTC and MDC, critical up to 1 (exact, or
    /// by the paper's convention as `score:paper`); CSV files have the columns `scenario` and `label` (or `obstacle_id`,
    /// with `none` for no collision), separated by commas [default: auto; for language models layout if these folders
    /// exist].
    #[arg(long, value_delimiter = ',', value_name = "CSV|auto|layout|score")]
    truth: Vec<PathBuf>,
    /// End of the dangerous windows: seconds before the first overlap of the bodies, or `end` for two steps before the
    /// last recorded step, as in the paper. Each gets a safe window that is like it in position, length, traffic and
    /// speed of the ego [default: end,0.2,0.5,1,1.5,2; for language models 1]. Language models answer the safety task
    /// once per lead: the first table shows the first lead, the second all of them.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "S",
        allow_negative_numbers = true
    )]
    lead: Vec<Lead>,
    /// A window is dangerous if the ego touches another body within so many seconds after it; the longest lead at most
    /// [default: 2].
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = horizon)]
    within: Option<f64>,
    /// Horizons of the baselines in seconds, at most 10; that of the judge is fixed.
    #[arg(long, value_delimiter = ',', default_value = "1,1.5,2", value_name = "S", allow_negative_numbers = true, value_parser = horizon)]
    horizon: Vec<f64>,
    /// Steps in the window [default: 10; for language models from the template].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = history)]
    history: Option<u32>,
    /// Leave out obstacles farther from the ego than this, metres; language models are told, too, of those that can
    /// reach it soon [default: 30; for language models from the template].
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = radius)]
    radius: Option<f64>,
    /// Format of the result. JSON and CSV hold the rows of the table: by lead for the built-in judge, by prompt
    /// configuration for a batch.
    #[arg(long, value_enum, default_value = "table")]
    format: Format,
    /// Ego of all scenarios: `planner` (the built-in planner drives), or `planner:NAME` with a [planner.NAME] of
    /// config.toml or a command; it drives first, and the questions are about its drives [default: the recordings
    /// beside the scenarios].
    #[arg(long, value_name = "planner[:NAME]", value_parser = planner, conflicts_with_all = ["resume", "list", "write_experiment"])]
    ego: Option<String>,
    #[command(flatten)]
    batch: options::Options,
}

fn planner(text: &str) -> Result<String, String> {
    match as_ego::named(text) {
        Some(_) => Ok(text.into()),
        None => {
            Err("expected planner or planner:NAME; other egos lie beside their scenarios".into())
        }
    }
}

impl Evaluate {
    /// The ego of the scenarios.
    fn ego(&self, entries: &[Entry]) -> Result<EgoSelection, Failure> {
        let Some(planner) = self.ego.as_deref().and_then(as_ego::named) else {
            return Ok(EgoSelection::Beside);
        };
        let ego = as_ego::drive(planner, None, entries)?;
        if let Some(drives) = ego.planner() {
            output::say(&output::visible(&format!(
                "nearmiss: egos {}",
                drives.words()
            )));
        }
        Ok(ego)
    }

    /// How the result is written.
    fn format(&self) -> Format {
        if self.batch.json {
            Format::Json
        } else {
            self.format
        }
    }

    /// The tasks.
    fn tasks(&self) -> Vec<Task> {
        if self.task.is_empty() {
            vec![Task::Safety]
        } else {
            self.task.clone()
        }
    }

    /// The horizon of the truth, seconds.
    fn within(&self) -> Result<f64, Failure> {
        let within = self.within.unwrap_or(WITHIN);
        let beyond = |lead: &&Lead| lead.is_beyond(Some(within));
        match self.lead.iter().find(beyond) {
            Some(lead) => Err(Failure::input(BatchError::Beyond {
                option: "--lead",
                lead: *lead,
                within,
            })),
            None => Ok(within),
        }
    }

    /// Whether more is wanted than an evaluation of the built-in judge.
    fn is_batch(&self) -> bool {
        let in_words = |model: &String| !model.starts_with("reference/");
        self.batch.any()
            || self.task.len() > 1
            || self
                .paths
                .iter()
                .any(|path| path.extension().is_some_and(|end| end == "toml"))
            || self.model.iter().any(in_words)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    Table,
    Csv,
    Json,
}

fn between(text: &str, most: f64) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= most => Ok(value),
        _ => Err(format!("expected a number above 0, at most {most}")),
    }
}

fn horizon(text: &str) -> Result<f64, String> {
    between(text, 10.0)
}

fn radius(text: &str) -> Result<f64, String> {
    between(text, 1e6)
}

/// Runs `evaluate`.
pub fn run(arguments: &Evaluate) -> Outcome {
    if arguments.is_batch() {
        return batch::run(arguments);
    }
    let task = arguments.tasks()[0];
    let candidates = candidates(arguments, task)?;
    let entries = found(&arguments.paths)?;
    let truth = truth(&arguments.truth, &entries)?;
    let about = (&truth, &*entries, &arguments.ego(&entries)?);
    match task {
        Task::Safety => safety::run(arguments, candidates, about),
        task @ (Task::Collision | Task::Recording) => collision::run(arguments, task, about),
        task @ (Task::Attacker | Task::Trajectory) => Err(no_verdicts(task)),
    }
}

fn no_verdicts(task: Task) -> Failure {
    Failure::input(format!(
        "--task {} cannot be evaluated: it has no yes or no; use {}",
        task.name(),
        Task::names(&Task::VERDICTS)
    ))
}

fn candidates(arguments: &Evaluate, task: Task) -> Result<Vec<Candidate>, Failure> {
    let safety = task == Task::Safety;
    let names: Vec<&str> = match (arguments.model.is_empty(), safety) {
        (false, _) => arguments.model.iter().map(String::as_str).collect(),
        (true, true) => Candidate::NAMES.to_vec(),
        (true, false) => vec![judge::MODEL],
    };
    let mut found: Vec<Candidate> = Vec::new();
    for name in names {
        let known = if safety {
            &Candidate::NAMES[..]
        } else {
            &[judge::MODEL]
        };
        let more = Candidate::named(name, &arguments.horizon).filter(|_| known.contains(&name));
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

/// What is true about scenarios, the scenarios, and their ego.
type About<'a> = (&'a Truth, &'a [Entry], &'a EgoSelection);

/// Judges every scenario with `judge`; what cannot be opened or has no label is said and counted. A label that cannot
/// be of its scenario is refused.
fn built_in<T: Send>(
    (task, thresholds): (Task, &Thresholds),
    (truth, entries, ego): About<'_>,
    judge: impl Fn(&Entry, &Labelled<'_>) -> T + Sync,
) -> Result<BuiltInAnswers<T>, Failure> {
    let truth = &truth.known;
    let progress = Progress::new(entries.len(), "scenarios", true);
    let request = BuiltInRequest {
        entries,
        ego,
        truth,
        task,
        thresholds,
    };
    let answers = request
        .run(judge, |event| {
            progress.step();
            progress.suspend(|| match event {
                BuiltInEvent::Judged {
                    entry,
                    scene,
                    doubt,
                } => {
                    let of_label = doubt.map(|words| format!("nearmiss: {}: {words}", entry.name));
                    let doubts = doubts(entry, &scene).into_iter().chain(of_label);
                    doubts.for_each(|doubt| output::say(&doubt));
                }
                BuiltInEvent::LeftOut => {}
                BuiltInEvent::NotScored { entry, why } => {
                    output::say(&format!("nearmiss: {}: {why}", entry.name));
                }
                BuiltInEvent::Failed(error) => not_opened(error).say(),
            });
        })
        .map_err(|wrong| Failure::input(format!("--truth: {wrong}")))?;
    drop(progress);
    if !answers.without_ego.is_empty() {
        output::say(&format!(
            "nearmiss: {} without a recorded ego: {}; put NAME.ego_trajectory.csv beside NAME.xml",
            number(answers.without_ego.len(), "scenario"),
            some(&answers.without_ego),
        ));
    }
    Ok(answers)
}

/// The first few names, and how many more there are.
fn some(names: &[String]) -> String {
    let first = &names[..names.len().min(NAMED)];
    let more = match names.len() - first.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("{}{more}", first.join(", "))
}

/// So many scenarios are named where there may be thousands.
const NAMED: usize = 3;

/// How it ends, when everything is written.
fn outcome<T>(answers: &BuiltInAnswers<T>) -> Outcome {
    let (without, unlabelled) = (answers.without_ego.len(), answers.unlabelled.len());
    if answers.failed + without + unlabelled == 0 {
        return Ok(());
    }
    let all = answers.judged.len() + answers.failed + without + unlabelled;
    let mut reasons = Vec::new();
    if answers.failed > 0 {
        reasons.push(format!("{} could not be opened", answers.failed));
    }
    if without > 0 {
        reasons.push(format!("{without} without a recorded ego"));
    }
    if unlabelled > 0 {
        let some = some(&answers.unlabelled);
        reasons.push(format!("{unlabelled} without a label or score ({some})"));
    }
    Err(Failure {
        message: format!("of {}, {}", number(all, "scenario"), reasons.join(", ")),
        status: if answers.judged.is_empty() { 2 } else { 1 },
    })
}

/// With three decimals, or a dash where there is no value.
fn share(value: Option<f64>) -> String {
    value.map_or_else(|| "–".into(), |v| format!("{v:.3}"))
}

//! `nearmiss evaluate`: measures how good the built-in judge and language models are on many scenarios.

mod batch;
mod collision;
mod context;
mod drawing;
mod dry_run;
mod leaks;
mod listed;
mod options;
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
pub use running::runtime;
pub use safety::SafetyDocument;
use std::path::{Path, PathBuf};
pub use table::BatchDocument;

use super::doubts::doubts;
use super::open::{found, not_opened};
use super::output::counted as number;
use super::plan::as_ego;
use super::progress::Progress;
use super::{Failure, Outcome, output};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_record::fields::Layers;
use nearmiss_scene::judge;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::verdict::Task;
use nearmiss_store::BatchId;
use nearmiss_study::evaluation::batch::Experiment;
use nearmiss_study::evaluation::windows::WITHIN;
use nearmiss_study::evaluation::{Candidate, Labelled};
use nearmiss_workflow::batch::{BatchError, BuiltInAnswers, BuiltInEvent, BuiltInRequest};
use nearmiss_workflow::experiment_among;
use options::Run;
use truth::Truth;

/// Arguments of `evaluate`.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Evaluate {
    #[command(subcommand)]
    command: Option<EvaluateCommand>,
    #[command(flatten)]
    run: Run,
}

#[derive(Debug, clap::Subcommand)]
enum EvaluateCommand {
    /// List the stored batches and their progress.
    List(List),
}

/// Arguments of `evaluate list`.
#[derive(Debug, clap::Args)]
struct List {
    #[command(flatten)]
    format: crate::output::FormatOption,
}

/// What is evaluated.
enum Subject<'a> {
    /// Scenarios.
    Scenarios,
    /// The experiment in a file.
    Experiment(&'a Path),
    /// A stored batch; `None` for the last one.
    Batch(Option<BatchId>),
}

impl Run {
    /// What is evaluated.
    fn subject(&self) -> Result<Subject<'_>, Failure> {
        if let Some(file) = experiment_among(&self.paths).map_err(Failure::input)? {
            return Ok(Subject::Experiment(file));
        }
        let batch = |path: &PathBuf| match path.to_str()? {
            "last" => Some(None),
            name => name.parse().ok().map(Some),
        };
        match (self.paths.iter().find_map(batch), &self.paths[..]) {
            (None, _) => Ok(Subject::Scenarios),
            (Some(which), [_]) => Ok(Subject::Batch(which)),
            (Some(_), _) => Err(Failure::input(
                "a stored batch keeps its scenarios; give it alone, or start a new batch",
            )),
        }
    }

    /// Adds what is set on the command line.
    fn add_knobs(&self, layers: &mut Layers<Experiment>) {
        self.knobs.add(
            layers,
            &[
                ("--model", "models", &self.model),
                ("--task", "tasks", &self.task),
                ("--techniques", "techniques", &self.techniques),
                ("--samples", "samples", self.samples.as_slice()),
                ("--truth", "truth", &self.truth),
                ("--budget", "budget", self.budget.as_slice()),
            ],
        );
    }

    /// The ego of the scenarios.
    fn ego(&self, entries: &[Entry]) -> Result<EgoSelection, Failure> {
        let Some(planner) = self.ego.as_deref().and_then(as_ego::named) else {
            return Ok(EgoSelection::Beside);
        };
        let ego = as_ego::drive(planner, None, entries)?;
        if let Some(drives) = ego.planner() {
            output::say(&output::visible(&format!(
                "nearmiss: egos {}",
                drives.text()
            )));
        }
        Ok(ego)
    }

    /// How the result is written.
    fn format(&self) -> Format {
        self.format
    }

    /// Whether an option is given that only a batch understands.
    fn needs_batch(&self) -> bool {
        let options = [
            self.shard.is_some(),
            self.split.is_some(),
            self.unlock,
            self.batch,
            self.dry_run.is_some(),
            self.write_experiment.is_some(),
            self.retry_failed,
            self.retry > 0,
            self.gate.any(),
        ];
        options.contains(&true)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    Table,
    Csv,
    #[value(alias = "jsonl")]
    Json,
}

/// Settings that the built-in judge understands.
const BUILT_IN: [&str; 7] = [
    "models", "tasks", "truth", "leads", "within", "history", "radius",
];

/// Runs `evaluate`.
pub fn run(arguments: &Evaluate) -> Outcome {
    if let Some(EvaluateCommand::List(list)) = &arguments.command {
        return listed::list(list.format.is_json());
    }
    let arguments = &arguments.run;
    let subject = arguments.subject()?;
    let mut layers = Layers::default();
    arguments.add_knobs(&mut layers);
    let in_words = |model: &String| !model.starts_with("reference/");
    let only_batch = layers.keys().any(|key| !BUILT_IN.contains(&key));
    if !matches!(subject, Subject::Scenarios)
        || arguments.needs_batch()
        || only_batch
        || arguments.task.len() > 1
        || arguments.model.iter().any(in_words)
    {
        return batch::run(arguments, subject);
    }
    let mistakes = |mistakes: String| Failure::input(output::visible(&mistakes));
    let asked = layers.read().map_err(mistakes)?;
    let within = asked.within.unwrap_or(WITHIN);
    if let Some(lead) = asked.leads.iter().find(|lead| lead.is_beyond(Some(within))) {
        return Err(Failure::input(BatchError::Beyond {
            lead: *lead,
            within,
        }));
    }
    let task = asked.tasks.first().copied().unwrap_or(Task::Safety);
    let candidates = candidates(arguments, task)?;
    let entries = found(&arguments.paths)?;
    let truth = Truth::read(asked.truth.clone(), &entries)?;
    let about = (&truth, &*entries, &arguments.ego(&entries)?);
    match task {
        Task::Safety => safety::run(arguments, &asked, candidates, about),
        task @ (Task::Collision | Task::Recording) => collision::run(arguments, task, about),
        task @ (Task::Attacker | Task::Trajectory) => Err(Failure::input(format!(
            "--task {} cannot be evaluated: it has no yes or no; use {}",
            task.name(),
            Task::names(&Task::VERDICTS)
        ))),
    }
}

fn candidates(arguments: &Run, task: Task) -> Result<Vec<Candidate>, Failure> {
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
        let more = Candidate::by_name(name, &arguments.horizon).filter(|_| known.contains(&name));
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

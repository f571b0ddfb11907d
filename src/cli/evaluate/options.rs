//! Options of `evaluate`: what is asked, how it is run, and how the result is written.

use std::path::{Path, PathBuf};

use crate::gate::Gate;
use crate::knobs::Knobs;
use crate::plan::as_ego;
use crate::{Failure, output};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_record::fields::Layers;
use nearmiss_store::{BatchId, SplitPart};
use nearmiss_study::evaluation::batch::{Experiment, Shard};
use nearmiss_workflow::batch::Selection;
use nearmiss_workflow::experiment_among;

/// Arguments of a run.
#[derive(Debug, clap::Args)]
#[command(after_long_help = crate::knobs::help())]
pub struct Run {
    /// Scenario files, folders or names of bundled scenarios, each with its recorded ego; or one experiment file
    /// (FILE.toml); or a stored batch (b7, or last), which is resumed.
    #[arg(required = true)]
    pub paths: Vec<PathBuf>,
    /// Models, separated by commas: provider/model, reference/geometry; for the safety task also the baselines
    /// reference/constant-velocity and reference/constant-acceleration [default: all built-in ones for the task]. Of a
    /// stored batch those that are added.
    #[arg(long, value_delimiter = ',', value_name = "MODEL")]
    pub model: Vec<String>,
    /// Tasks, separated by commas: safety, collision or recording (is it safe or of high risk as a whole) [default:
    /// safety].
    #[arg(long, value_delimiter = ',')]
    pub task: Vec<String>,
    /// Prompting techniques, separated by commas: base, cp, cot, icl, all, or combinations such as cp+cot [default: all].
    #[arg(long, value_delimiter = ',')]
    pub techniques: Vec<String>,
    /// Answers per request; of a stored batch the new total [default: 1].
    #[arg(long, value_name = "N")]
    pub samples: Option<String>,
    /// Ground truth: `auto` is the exact geometry of the recordings; `layout` reads the folders collision_scenarios and
    /// normal_scenarios with their annotations; `score` is the risk score of TTC and MDC, critical up to 1 (exact, or
    /// by the paper's convention as `score:paper`); CSV files have the columns `scenario` and `label` (or `obstacle_id`,
    /// with `none` for no collision), separated by commas [default: auto; for language models layout if these folders
    /// exist].
    #[arg(long, value_delimiter = ',', value_name = "CSV|auto|layout|score")]
    pub truth: Vec<String>,
    /// Maximum cost of this run in US dollars; needs known prices and a token limit [default: `budget` in config.toml].
    #[arg(long, value_name = "USD", allow_hyphen_values = true)]
    pub budget: Option<String>,
    #[command(flatten)]
    pub knobs: Knobs,
    /// Ego of all scenarios: `planner` (the built-in planner drives), or `planner:NAME` with a [planner.NAME] of
    /// config.toml or a command; it drives first, and the questions are about its drives [default: the recordings
    /// beside the scenarios].
    #[arg(long, value_name = "planner[:NAME]", value_parser = planner, conflicts_with = "write_experiment")]
    pub ego: Option<String>,
    /// Horizons of the baselines in seconds, at most 10; that of the judge is fixed.
    #[arg(long, value_delimiter = ',', default_value = "1,1.5,2", value_name = "S", allow_negative_numbers = true, value_parser = horizon)]
    pub horizon: Vec<f64>,
    /// Only this part of the scenarios, such as 2/8; the name decides the part.
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Ask only this part of a split: dev or test.
    #[arg(long, value_name = "PART")]
    pub split: Option<SplitPart>,
    /// Show the figures of a test split before it is complete; later reports say that it was looked at.
    #[arg(long)]
    pub unlock: bool,
    /// Submit the questions through the batch APIs of OpenAI, Anthropic and Gemini: answers within a day, at half the
    /// price. `nearmiss runs batches collect` fetches the answers, `evaluate BATCH` counts them.
    #[arg(long, conflicts_with = "dry_run")]
    pub batch: bool,
    /// Send nothing, and print what would be asked: its tokens and maximum cost; with `questions` every question as a JSON
    /// line; with `leaks` how well position, length and traffic alone tell dangerous from safe windows. The last two need
    /// no model.
    #[arg(
        long,
        value_name = "WHAT",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "cost",
        conflicts_with_all = NEED_ANSWERS
    )]
    pub dry_run: Option<DryRunOf>,
    /// Write scenarios and settings to this experiment file (TOML) and send nothing; `nearmiss evaluate FILE.toml` runs
    /// it.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["dry_run", "batch"])]
    pub write_experiment: Option<PathBuf>,
    /// Of a stored batch or an experiment, ask only questions that failed, whose answer was cut off, or whose whole answer
    /// has no readable verdict.
    #[arg(long, conflicts_with_all = ["model", "techniques", "samples"])]
    pub retry_failed: bool,
    /// Ask questions that failed, were cut off or have no readable verdict again, up to N times and within the budget.
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with_all = ["dry_run", "batch"])]
    pub retry: u32,
    /// Format of the result. JSON and CSV hold the rows of the table: by lead for the built-in judge, by prompt
    /// configuration for a batch.
    #[arg(long, value_enum, default_value = "table")]
    pub format: Format,
    #[command(flatten)]
    pub gate: Gate,
}

/// Format of the result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    Table,
    Csv,
    #[value(alias = "jsonl")]
    Json,
}

/// What is evaluated.
pub enum Subject<'a> {
    /// Scenarios.
    Scenarios,
    /// The experiment in a file.
    Experiment(&'a Path),
    /// A stored batch; `None` for the last one.
    Batch(Option<BatchId>),
}

impl Run {
    /// What is evaluated.
    pub fn subject(&self) -> Result<Subject<'_>, Failure> {
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
    pub fn add_knobs(&self, layers: &mut Layers<Experiment>) {
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
    pub fn ego(&self, entries: &[Entry]) -> Result<EgoSelection, Failure> {
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

    /// Whether an option is given that only a batch understands.
    pub fn needs_batch(&self) -> bool {
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

    /// Which questions of a stored batch are asked, or listed.
    pub fn selection(&self) -> Selection {
        match (self.retry_failed, self.dry_run) {
            (true, _) => Selection::Failed,
            (false, Some(DryRunOf::Questions | DryRunOf::Leaks)) => Selection::All,
            (false, _) => Selection::Open,
        }
    }
}

/// Options that hold a requirement against answers.
const NEED_ANSWERS: [&str; 3] = ["require", "baseline_bundle", "junit"];

/// What a dry run prints.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum DryRunOf {
    /// Questions, tokens and the maximum cost.
    Cost,
    /// Every question.
    Questions,
    /// What the surface of the questions gives away.
    Leaks,
}

fn planner(text: &str) -> Result<String, String> {
    match as_ego::named(text) {
        Some(_) => Ok(text.into()),
        None => {
            Err("expected planner or planner:NAME; other egos lie beside their scenarios".into())
        }
    }
}

fn horizon(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 10.0 => Ok(value),
        _ => Err("expected a number above 0, at most 10".into()),
    }
}

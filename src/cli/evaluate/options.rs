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
    /// Scenario files, folders or names of bundled scenarios
    ///
    /// Scenarios are used with their recorded egos. Instead, give one experiment file (FILE.toml), or a stored batch to
    /// resume (b7 or last).
    #[arg(required = true)]
    pub paths: Vec<PathBuf>,
    /// Models to ask, separated by commas: provider/model or reference/geometry [default: all built-in ones for the
    /// task]
    ///
    /// The safety task also has the baselines reference/constant-velocity and reference/constant-acceleration. For a
    /// stored batch, these models are added.
    #[arg(long, value_delimiter = ',', value_name = "MODEL")]
    pub model: Vec<String>,
    /// Tasks, separated by commas: safety, collision or recording (whether a whole recording is safe or of high risk)
    /// [default: safety].
    #[arg(long, value_delimiter = ',')]
    pub task: Vec<String>,
    /// Prompting techniques, separated by commas: base, cp, cot, icl, all, or combinations such as cp+cot [default: all].
    #[arg(long, value_delimiter = ',')]
    pub techniques: Vec<String>,
    /// Answers per question; for a stored batch, the new total [default: 1].
    #[arg(long, value_name = "N")]
    pub samples: Option<String>,
    /// Ground truth [default: auto; for language models layout if its folders exist]
    ///
    /// `auto`: exact geometry of the recordings. `layout`: the folders collision_scenarios and normal_scenarios with
    /// their annotations. `score`: the exact risk score of TTC and MDC, critical up to 1; `score:paper` uses the
    /// paper's convention. CSV files, separated by commas, need the columns `scenario` and `label`, or `obstacle_id`
    /// with `none` for no collision.
    #[arg(long, value_delimiter = ',', value_name = "CSV|auto|layout|score")]
    pub truth: Vec<String>,
    /// Maximum cost of this run in US dollars; needs known prices and a token limit [default: `budget` in config.toml].
    #[arg(long, value_name = "USD", allow_hyphen_values = true)]
    pub budget: Option<String>,
    #[command(flatten)]
    pub knobs: Knobs,
    /// Drive the ego of every scenario with a planner first and ask about these drives [default: the recordings beside
    /// the scenarios]
    ///
    /// `planner` is the built-in planner, `planner:NAME` that of [planner.NAME] in config.toml or a command.
    #[arg(long, value_name = "planner[:NAME]", value_parser = planner, conflicts_with = "write_experiment")]
    pub ego: Option<String>,
    /// Prediction horizons of the baselines in seconds, separated by commas, at most 10; the judge's horizon is fixed.
    #[arg(long, value_delimiter = ',', default_value = "1,1.5,2", value_name = "S", allow_negative_numbers = true, value_parser = horizon)]
    pub horizon: Vec<f64>,
    /// Process only part I of N of the scenarios, such as 2/8; the scenario name decides the part.
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Ask only about one part of the split: dev or test.
    #[arg(long, value_name = "PART")]
    pub split: Option<SplitPart>,
    /// Show the figures of an incomplete test split; later reports state that it was unlocked.
    #[arg(long)]
    pub unlock: bool,
    /// Submit the questions through the batch APIs of OpenAI, Anthropic or Gemini, at half price and within a day
    ///
    /// `nearmiss runs batches collect` fetches the answers; `nearmiss evaluate BATCH` counts them.
    #[arg(long, conflicts_with = "dry_run")]
    pub batch: bool,
    /// Send nothing; print the questions with their tokens and maximum cost
    ///
    /// `questions` prints every question as a JSON line. `leaks` measures how well position, length and traffic alone
    /// separate dangerous from safe windows. Neither needs a model.
    #[arg(
        long,
        value_name = "WHAT",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "cost",
        conflicts_with_all = NEED_ANSWERS
    )]
    pub dry_run: Option<DryRunOf>,
    /// Write scenarios and settings to an experiment file (TOML) and send nothing; run it with `nearmiss evaluate
    /// FILE.toml`.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["dry_run", "batch"])]
    pub write_experiment: Option<PathBuf>,
    /// Ask only the questions of a stored batch or experiment that failed, were cut off, or have no readable verdict.
    #[arg(long, conflicts_with_all = ["model", "techniques", "samples"])]
    pub retry_failed: bool,
    /// Retry questions that failed, were cut off or have no readable verdict, up to N times and within the budget.
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with_all = ["dry_run", "batch"])]
    pub retry: u32,
    /// Output format. JSON and CSV contain the rows of the table: per lead for the built-in judge, per prompt
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
    /// Number of questions, tokens and maximum cost.
    Cost,
    /// Every question as a JSON line.
    Questions,
    /// What position, length and traffic alone reveal.
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

//! Options of `evaluate`: what is asked, how it is run, and how the result is written.

use std::path::PathBuf;

use super::Format;
use crate::gate::Gate;
use crate::knobs::Knobs;
use crate::plan::as_ego;
use nearmiss_store::SplitPart;
use nearmiss_study::evaluation::batch::Shard;

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

//! `nearmiss evaluate`: measures how good the built-in judge and language models are on many scenarios.

mod batch;
mod built_in;
mod context;
mod dry_run;
mod listed;
mod options;
mod running;
mod table;

pub use context::{BatchContext, planned, runtime};
pub use dry_run::{DryRunDocument, LeaksDocument, make as questions_of};
pub use listed::ListedDocument;
pub use table::BatchDocument;

use super::Outcome;
use super::output::counted as number;
use nearmiss_record::fields::Layers;
use options::{Run, Subject};

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
    /// List stored batches and their progress.
    List(List),
}

/// Arguments of `evaluate list`.
#[derive(Debug, clap::Args)]
struct List {
    #[command(flatten)]
    format: crate::output::FormatOption,
}

/// Settings with which the built-in judge alone is no batch.
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
    let is_batch = !matches!(subject, Subject::Scenarios)
        || arguments.needs_batch()
        || layers.keys().any(|key| !BUILT_IN.contains(&key))
        || arguments.task.len() > 1
        || arguments.model.iter().any(in_words);
    if is_batch {
        batch::run(arguments, subject)
    } else {
        built_in::run(arguments)
    }
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

//! The command line, one file for each subcommand. Data goes to standard output, messages to standard error.

mod ask;
mod batches;
mod convert;
mod cost;
mod crash;
mod describe;
mod doctor;
mod evaluate;
mod export;
mod filters;
mod generate;
mod generated;
mod help;
mod import;
mod inspect;
mod interrupt;
mod metrics;
mod models;
mod open;
mod output;
mod parallel;
mod plan;
mod print_config;
mod progress;
mod prompt;
mod prompts;
mod ratings;
mod render;
mod report;
mod routes;
mod runs;
mod span;
mod themes_and_keys;
mod time;
mod verdicts;

pub use crash::report_panics;
pub use open::{EgoChoice, chosen_ego};
pub use print_config::print_config;
pub use themes_and_keys::Workbench;
pub use verdicts::{has_terminal, without_terminal};

use std::fmt::Display;
use std::path::PathBuf;

use crate::system;

/// A terminal workbench for safety-critical driving scenarios.
#[derive(Debug, clap::Parser)]
#[command(name = "nearmiss", version, about, disable_help_subcommand = true)]
#[command(
    after_help = "Manual: `nearmiss help` lists its topics, `nearmiss help TOPIC` prints one."
)]
pub struct Arguments {
    /// What to do without the workbench.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Scenario files or folders to open in the workbench [default: the bundled scenarios].
    pub paths: Vec<PathBuf>,
    /// Who is the ego in the workbench.
    #[command(flatten)]
    pub ego: EgoChoice,
    /// Print the configuration that is in force, with where each value comes from.
    #[arg(long, exclusive = true)]
    pub print_config: bool,
}

/// The headless commands.
#[derive(Debug, clap::Subcommand)]
pub enum Command {
    /// What is in a scenario, and what is wrong with it, with line numbers.
    Inspect(inspect::Inspect),
    /// Scenarios written anew as CommonRoad 2020a XML.
    Convert(convert::Convert),
    /// Every measure of every obstacle at every step, as a table.
    Metrics(metrics::Metrics),
    /// A window of a scene in words.
    Describe(describe::Describe),
    /// The messages as they would be sent to a model.
    Prompt(prompt::PromptArguments),
    /// The prompt templates: list, show, compare with the shipped ones, copy to change them.
    Prompts(prompts::Prompts),
    /// One verdict: by the built-in judge, or by a language model.
    Ask(ask::Ask),
    /// Which models can be asked, with what key, at what price, and how long still.
    Models(models::Models),
    /// Asks models about many scenarios, in many ways, and counts how often they are right; the built-in judge too.
    Evaluate(evaluate::Evaluate),
    /// Batches that providers work off: list, collect their answers, cancel.
    Batches(batches::Batches),
    /// How often answers are right: runs of the store, or recorded answers beside the paper's tables.
    Report(report::ReportArguments),
    /// What was asked and answered: the store of runs.
    Runs(runs::Runs),
    /// What people made of answers side by side: wins and strengths of models and prompts.
    Ratings(ratings::Ratings),
    /// Plans the ego's motion and drives it through the recorded traffic, which does not react; how it ends.
    Plan(plan::PlanArguments),
    /// Makes safe scenarios dangerous: one obstacle moves otherwise, physically possible and survivable.
    Generate(generate::GenerateArguments),
    /// Runs of the store as a file.
    Export(export::Export),
    /// Figures for papers: the map, measures over time, or the workbench, as SVG, PNG or GIF.
    Render(render::Render),
    /// Runs of another store, or the recorded answers of a published repository, into the store.
    Import(import::Import),
    /// The themes of the workbench, as they look in this terminal.
    Themes(themes_and_keys::Themes),
    /// The keys of the workbench, and a keymap file to begin with.
    Keys(themes_and_keys::Keys),
    /// Whether everything is in order: terminal, files, store, models; and what to do where it is not.
    Doctor(doctor::Doctor),
    /// Completions for a shell.
    Completions(generated::Completions),
    /// The manual page.
    Man,
    /// A topic of the manual, or the options of a command.
    Help(help::Help),
}

/// The arguments of this process; what is wrong with them is said, and ends the program.
#[must_use]
pub fn arguments() -> Arguments {
    use clap::FromArgMatches;
    let found = help::program().try_get_matches();
    let parsed = found.and_then(|found| Arguments::from_arg_matches(&found));
    parsed.unwrap_or_else(|error| {
        let said = error.render().to_string();
        let plain = said.replace("invalid digit found in string", NO_NUMBER);
        let plain = plain.replace("cannot parse integer from empty string", NO_NUMBER);
        if plain == said {
            error.exit();
        }
        output::lines(&plain);
        std::process::exit(error.exit_code());
    })
}

/// Said of a word where a number without decimals is needed.
const NO_NUMBER: &str = "a whole number is needed";

/// Result of a command.
pub type Outcome = Result<(), Failure>;

/// Why a command failed; the message names what, where and what to do.
#[derive(Debug)]
pub struct Failure {
    /// For people.
    pub message: String,
    /// The exit status: 1 for a finding, 2 for a usage or input error, 130 when interrupted. A panic ends with 101.
    pub status: u8,
}

impl Failure {
    /// An input or usage error.
    pub fn input(error: impl Display) -> Self {
        Self {
            message: error.to_string(),
            status: 2,
        }
    }

    /// What the system said about a file, or about what else is named.
    pub fn system(name: impl Display, error: &std::io::Error) -> Self {
        Self::input(format!("{name}: {}", system::words(error)))
    }

    /// Says on standard error what went wrong.
    pub fn say(&self) {
        output::say(&format!("nearmiss: {}", self.message));
    }
}

/// Runs a headless command; `workbench` is asked what only the workbench knows.
///
/// # Errors
/// See [`Failure`].
pub fn run(command: &Command, workbench: &Workbench) -> Outcome {
    let _doing = crash::running();
    interrupt::listen();
    match command {
        Command::Inspect(arguments) => inspect::run(arguments),
        Command::Convert(arguments) => convert::run(arguments),
        Command::Metrics(arguments) => metrics::run(arguments),
        Command::Describe(arguments) => describe::run(arguments),
        Command::Prompt(arguments) => prompt::run(arguments),
        Command::Prompts(arguments) => prompts::run(arguments),
        Command::Ask(arguments) => ask::run(arguments),
        Command::Models(arguments) => models::run(arguments),
        Command::Evaluate(arguments) => evaluate::run(arguments),
        Command::Batches(arguments) => batches::run(arguments),
        Command::Report(arguments) => report::run(arguments),
        Command::Runs(arguments) => runs::run(arguments),
        Command::Ratings(arguments) => ratings::run(arguments),
        Command::Plan(arguments) => plan::run(arguments),
        Command::Generate(arguments) => generate::run(arguments),
        Command::Export(arguments) => export::run(arguments),
        Command::Render(arguments) => render::run(arguments, workbench.screen),
        Command::Import(arguments) => import::run(arguments),
        Command::Themes(arguments) => themes_and_keys::themes(arguments, workbench),
        Command::Keys(arguments) => themes_and_keys::keys(arguments, workbench),
        Command::Doctor(arguments) => doctor::run(arguments, workbench),
        Command::Completions(arguments) => generated::completions(arguments),
        Command::Man => generated::man(),
        Command::Help(arguments) => help::run(arguments),
    }
}

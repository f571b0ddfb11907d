//! The command line, one file for each subcommand. Data goes to standard output, messages to standard error.

mod annex;
mod ask;
mod batches;
mod bundle;
mod check;
mod config;
mod convert;
mod corpus;
mod doctor;
mod drivers;
mod ending;
mod evaluate;
mod export;
mod files;
mod filters;
mod find;
mod gate;
mod generate;
mod hard;
mod help;
mod import;
mod index;
mod inspect;
mod json;
mod knobs;
mod many_files;
mod mcp;
mod metrics;
mod models;
mod open;
mod output;
mod parts;
mod plan;
mod prompt;
mod prompts;
mod rate;
mod ratings;
mod render;
mod report;
mod runs;
mod span;
mod stream;
mod tune;
mod workbench;

pub use config::Workbench;
pub use ending::{Failure, Outcome, clean_up, report_panics};
pub use open::{EgoChoice, Reading};
pub use workbench::{chosen_ego, chosen_index, chosen_paths, has_terminal, without_terminal};

use std::path::PathBuf;

/// A terminal workbench for safety-critical driving scenarios.
#[derive(Debug, clap::Parser)]
#[command(name = "nearmiss", version, disable_help_subcommand = true)]
#[command(
    after_help = "Manual: `nearmiss help` lists its topics, `nearmiss help TOPIC` prints one."
)]
pub struct Arguments {
    /// Command to run; without one, the workbench opens.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Scenario files, folders or names of bundled scenarios to open in the workbench, or one experiment file (.toml)
    /// [default: the bundled scenarios].
    pub paths: Vec<PathBuf>,
    /// Who is the ego in the workbench.
    #[command(flatten)]
    pub ego: EgoChoice,
    /// Index folder (`nearmiss corpus index`) whose terms filter the list of the workbench.
    #[arg(long, value_name = "FOLDER")]
    pub index: Option<PathBuf>,
    /// How tables of tracks are read.
    #[command(flatten)]
    pub reading: Reading,
    /// Take a tour of the workbench in nine keys, with bundled scenarios and example answers; nothing is saved.
    #[arg(long, conflicts_with_all = ["paths", "ego", "index"])]
    pub tour: bool,
}

/// The headless commands, in the order of `help::GROUPS`.
#[derive(Debug, clap::Subcommand)]
pub enum Command {
    /// Show what a scenario contains, and report errors with line numbers.
    Inspect(inspect::Inspect),
    /// Describe a scenario as prompts do, or tell what happened (`--story`).
    Describe(prompt::Describe),
    /// Draw maps, plots or the workbench as SVG, PNG, GIF, MP4 or HTML.
    Render(render::Render),
    /// Convert scenarios to CommonRoad, OpenSCENARIO with OpenDRIVE, or tables of tracks.
    Convert(convert::Convert),
    /// Compute every safety measure for every obstacle at every time step.
    Metrics(metrics::Metrics),
    /// Index the windows of many scenarios, search them and draw samples.
    #[command(subcommand)]
    Corpus(corpus::Corpus),
    /// Ask a model or the built-in judge for one verdict.
    Ask(ask::Ask),
    /// Show prompts as models receive them, and manage their templates.
    #[command(subcommand)]
    Prompt(prompts::Prompt),
    /// List models with their keys, prices and retirement dates.
    Models(models::Models),
    /// Ask models about many scenarios and count correct answers.
    Evaluate(Box<evaluate::Evaluate>),
    /// Report the accuracy of stored or recorded answers.
    Report(report::ReportArguments),
    /// Check the claims of a text against the scene.
    Check(check::Check),
    /// List, show, export and import stored answers, ratings and provider batches.
    #[command(subcommand)]
    Runs(runs::Runs),
    /// Improve a prompt template from wrong answers on the dev split of an experiment.
    Tune(tune::Tune),
    /// Plan the ego's motion and simulate it in recorded or reactive traffic.
    Plan(plan::PlanArguments),
    /// Turn safe scenarios into dangerous but avoidable ones.
    Generate(generate::GenerateArguments),
    /// Find out which driver models would have avoided a contact or near miss, and until when.
    Drivers(drivers::Drivers),
    /// Check planners against a safety requirement and write an annex for a safety case.
    Annex(annex::AnnexArguments),
    /// Serve tools, scenarios and prompts over the Model Context Protocol.
    Mcp(mcp::Mcp),
    /// Check terminal, files, store and models, and suggest fixes.
    Doctor(doctor::Doctor),
    /// Print the configuration in force, or the themes and keys of the workbench.
    #[command(subcommand)]
    Config(config::ConfigCommand),
    /// Print shell completions or the manual page.
    Completions(help::Completions),
    /// Print a topic of the manual or the help of a command.
    Help(help::Help),
}

impl Command {
    /// Whether a wrong measure in the configuration stops it: not what looks at the configuration, nor help.
    fn stops_at_mistakes(&self) -> bool {
        !matches!(
            self,
            Self::Doctor(_) | Self::Config(_) | Self::Completions(_) | Self::Help(_)
        )
    }
}

/// The arguments of this process; what is wrong with them is said, and ends the program.
#[must_use]
pub fn arguments() -> Arguments {
    use clap::FromArgMatches;
    use clap::error::ContextKind;
    // A mistake is said by the command, once it is known.
    let _ = open::use_own_measures();
    let program = help::program();
    let first = std::env::args_os().nth(1);
    if let Some(failure) = first.and_then(|word| help::mistyped(&program, &word)) {
        failure.say();
        std::process::exit(failure.status.into());
    }
    let found = program.try_get_matches();
    let parsed = found.and_then(|found| Arguments::from_arg_matches(&found));
    parsed.unwrap_or_else(|mut error| {
        // It would advise to pass a mistyped option as a file: `-- -o`.
        error.remove(ContextKind::Suggested);
        let said = error.render().to_string();
        let plain = said
            .replace("invalid digit found in string", NO_NUMBER)
            .replace("cannot parse integer from empty string", NO_NUMBER);
        if !error.use_stderr() {
            std::process::exit(printed(&error).map_or_else(
                |failure| {
                    failure.say();
                    failure.status.into()
                },
                |()| error.exit_code(),
            ));
        }
        let words = std::env::args_os().skip(1);
        let words: Vec<String> = words.map_while(|word| word.into_string().ok()).collect();
        match help::moved_option(&error, &words) {
            Some(moved) => output::lines(&format!("error: {moved}")),
            None if plain == said => error.exit(),
            None => output::lines(&plain),
        }
        std::process::exit(error.exit_code());
    })
}

/// Prints help or version, which clap would not notice to be lost.
fn printed(said: &clap::Error) -> Outcome {
    use std::io::Write;
    let printed = said.print().and_then(|()| std::io::stdout().flush());
    output::written(None, printed).map(drop)
}

/// Said of a word where a number without decimals is needed.
const NO_NUMBER: &str = "expected a whole number";

/// Runs a headless command; `workbench` is asked what only the workbench knows.
///
/// # Errors
/// See [`Failure`].
pub fn run(command: &Command, workbench: &Workbench) -> Outcome {
    let _doing = ending::note_command();
    ending::listen();
    match command {
        Command::Inspect(arguments) => inspect::run(arguments),
        Command::Describe(arguments) => prompt::describe(arguments),
        Command::Render(arguments) => render::run(arguments, workbench.screen),
        Command::Convert(arguments) => convert::run(arguments),
        Command::Metrics(arguments) => metrics::run(arguments),
        Command::Corpus(command) => corpus::run(command),
        Command::Ask(arguments) => ask::run(arguments),
        Command::Prompt(command) => prompts::run(command),
        Command::Models(arguments) => models::run(arguments),
        Command::Evaluate(arguments) => evaluate::run(arguments),
        Command::Report(arguments) => report::run(arguments),
        Command::Runs(command) => runs::run(command),
        Command::Tune(arguments) => tune::run(arguments),
        Command::Plan(arguments) => plan::run(arguments),
        Command::Generate(arguments) => generate::run(arguments),
        Command::Drivers(arguments) => drivers::run(arguments),
        Command::Check(arguments) => check::run(arguments),
        Command::Annex(arguments) => annex::run(arguments),
        Command::Mcp(arguments) => mcp::run(arguments),
        Command::Doctor(arguments) => doctor::run(arguments, workbench),
        Command::Config(command) => config::run(command, workbench),
        Command::Completions(arguments) => help::completions(arguments),
        Command::Help(arguments) => help::run(arguments),
    }
}

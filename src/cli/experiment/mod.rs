//! `nearmiss experiment`: a batch with its answers as one file, for other machines.

mod pack;
mod show;
mod unpack;

use std::path::PathBuf;

use super::Outcome;
pub use show::Document;

/// Arguments of `experiment`.
#[derive(Debug, clap::Args)]
pub struct ExperimentArguments {
    #[command(subcommand)]
    what: ExperimentCommand,
}

#[derive(Debug, clap::Subcommand)]
enum ExperimentCommand {
    /// Write a batch with its answers, truth and templates to one file.
    Pack(pack::Pack),
    /// Check a bundle and list what is in it.
    Show(show::Show),
    /// Put the answers of a bundle into the store and its files into a folder.
    Unpack(unpack::Unpack),
}

/// A bundle as an argument.
#[derive(Debug, clap::Args)]
struct BundleFile {
    /// The bundle, FILE.nearmiss.
    file: PathBuf,
}

/// Runs `experiment`.
pub fn run(arguments: &ExperimentArguments) -> Outcome {
    match &arguments.what {
        ExperimentCommand::Pack(arguments) => pack::run(arguments),
        ExperimentCommand::Show(arguments) => show::run(arguments),
        ExperimentCommand::Unpack(arguments) => unpack::run(arguments),
    }
}

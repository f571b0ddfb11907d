//! `nearmiss config`: what is set up, and what can be.

use super::themes_and_keys::{self, Keys, Themes, Workbench};
use super::{Outcome, print_config};

/// Subcommands of `config`.
#[derive(Debug, clap::Subcommand)]
pub enum ConfigCommand {
    /// Print the configuration in force and where each value comes from.
    Print,
    /// List and preview the themes of the workbench.
    Themes(Themes),
    /// List the keys of the workbench, or print a keymap file.
    Keys(Keys),
}

/// Runs `config`.
pub fn run(command: &ConfigCommand, workbench: &Workbench) -> Outcome {
    match command {
        ConfigCommand::Print => print_config::print_config(),
        ConfigCommand::Themes(arguments) => themes_and_keys::themes(arguments, workbench),
        ConfigCommand::Keys(arguments) => themes_and_keys::keys(arguments, workbench),
    }
}

//! The `nearmiss` program: arguments to a headless command or the workbench, and the exit status.

use std::process::ExitCode;

use clap::Parser;
use nearmiss::{cli, tui};

fn main() -> ExitCode {
    let arguments = cli::Arguments::parse();
    let outcome = match &arguments.command {
        Some(command) => cli::run(command),
        None if cli::has_terminal() => tui::run(arguments.paths).map_err(cli::Failure::input),
        None => cli::without_terminal(&arguments.paths),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.say();
            ExitCode::from(failure.status)
        }
    }
}

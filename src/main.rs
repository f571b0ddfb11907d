//! The `nearmiss` program: arguments to a headless command or the workbench, and the exit status.

use nearmiss::{cli, tui};
use std::process::ExitCode;

fn main() -> ExitCode {
    cli::report_panics();
    let outcome = run(cli::arguments());
    cli::clean_up();
    let Err(failure) = outcome else {
        return ExitCode::SUCCESS;
    };
    failure.say();
    ExitCode::from(failure.status)
}

fn run(arguments: cli::Arguments) -> cli::Outcome {
    arguments.reading.apply(arguments.command.as_ref())?;
    let (ego, index) = (cli::chosen_ego(&arguments)?, cli::chosen_index(&arguments)?);
    let paths = cli::chosen_paths(&arguments)?;
    match &arguments.command {
        Some(command) => cli::run(command, &workbench()),
        None if cli::has_terminal() => {
            tui::run(paths, ego, index, arguments.tour).map_err(cli::Failure::input)
        }
        None => cli::without_terminal(&paths, &ego),
    }
}

/// Commands and workbench do not know each other; this is where they meet.
fn workbench() -> cli::Workbench {
    cli::Workbench {
        themes: tui::themes,
        keys: tui::keys,
        key_bindings: tui::key_bindings,
        theme_mistakes: tui::theme_mistakes,
        terminal: tui::terminal_here,
        screen: tui::screen,
    }
}

//! `nearmiss completions`: completions and the manual page, generated from the argument definitions.

use clap::{CommandFactory, ValueEnum};
use clap_complete::Shell;

use super::{Arguments, Failure, Outcome, output};

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub struct Completions {
    /// Shell whose completions are printed, or man for the manual page.
    #[arg(value_enum, value_name = "SHELL|man")]
    kind: Generated,
}

/// What is generated.
#[derive(Debug, Clone, Copy)]
enum Generated {
    Shell(Shell),
    Man,
}

impl ValueEnum for Generated {
    fn value_variants<'a>() -> &'a [Self] {
        &[
            Self::Shell(Shell::Bash),
            Self::Shell(Shell::Elvish),
            Self::Shell(Shell::Fish),
            Self::Shell(Shell::PowerShell),
            Self::Shell(Shell::Zsh),
            Self::Man,
        ]
    }

    fn to_possible_value(&self) -> Option<clap::builder::PossibleValue> {
        match self {
            Self::Shell(shell) => shell.to_possible_value(),
            Self::Man => Some("man".into()),
        }
    }
}

/// Runs `completions`.
pub fn run(arguments: &Completions) -> Outcome {
    let mut bytes = Vec::new();
    let mut program = Arguments::command();
    match arguments.kind {
        Generated::Shell(shell) => {
            clap_complete::generate(shell, &mut program, "nearmiss", &mut bytes);
        }
        Generated::Man => clap_mangen::Man::new(program)
            .render(&mut bytes)
            .map_err(Failure::input)?,
    }
    output::text(&String::from_utf8_lossy(&bytes))
}

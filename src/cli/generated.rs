//! `nearmiss completions` and `nearmiss man`: generated from the argument definitions.

use clap::CommandFactory;

use super::{Arguments, Failure, Outcome, output};

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub struct Completions {
    /// Shell.
    shell: clap_complete::Shell,
}

/// Runs `completions`.
pub fn completions(arguments: &Completions) -> Outcome {
    let mut bytes = Vec::new();
    clap_complete::generate(
        arguments.shell,
        &mut Arguments::command(),
        "nearmiss",
        &mut bytes,
    );
    output::text(&String::from_utf8_lossy(&bytes))
}

/// Runs `man`.
pub fn man() -> Outcome {
    let mut bytes = Vec::new();
    let page = clap_mangen::Man::new(Arguments::command());
    page.render(&mut bytes).map_err(Failure::input)?;
    output::text(&String::from_utf8_lossy(&bytes))
}

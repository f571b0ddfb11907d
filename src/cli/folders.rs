//! `nearmiss folders`: where files of the user's lie.

use super::{Outcome, output};

/// Arguments of `folders`.
#[derive(Debug, clap::Args)]
pub struct FoldersArguments {}

/// Runs `folders`.
pub fn run(_: &FoldersArguments) -> Outcome {
    let (folders, _) = super::open::configuration()?;
    output::text(&format!("{}\n", folders.config_file().display()))
}

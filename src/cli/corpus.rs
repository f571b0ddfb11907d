//! `nearmiss corpus`: an index of many scenarios, searched and drawn from.

use super::Outcome;
use super::{find, index, sample};

/// Subcommands of `corpus`.
#[derive(Debug, clap::Subcommand)]
pub enum Corpus {
    /// Measure every window of every pair of road users in many scenarios.
    Index(Box<index::Index>),
    /// Count the windows of an index by manoeuvre, road and severity.
    Show(index::Show),
    /// Find the windows of an index that a sentence means.
    Find(find::Find),
    /// Draw scenarios or windows from an index so that they cover it.
    Sample(sample::Sample),
}

/// Runs `corpus`.
pub fn run(command: &Corpus) -> Outcome {
    match command {
        Corpus::Index(arguments) => index::run(arguments),
        Corpus::Show(arguments) => index::show(arguments),
        Corpus::Find(arguments) => find::run(arguments),
        Corpus::Sample(arguments) => sample::run(arguments),
    }
}

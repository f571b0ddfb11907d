//! `--at`, `--history` and `--obstacle`: the steps of a scene to look at, on the command line.

pub use nearmiss_workflow::span::{At, moment, worst_step};

use nearmiss_workflow::span;

/// Which steps are looked at, and which obstacle.
#[derive(Debug, clap::Args)]
pub struct Span {
    /// End of the window [default: the last step; two steps earlier for the safety task]
    ///
    /// A time step (32), seconds (3.2s), worst (the most severe moment, see `nearmiss help measures`), or the worst by
    /// one measure: worst:risk, worst:ttc, worst:distance.
    #[arg(long, value_name = AT, allow_negative_numbers = true)]
    at: Option<At>,
    /// Steps in the window [default: from the template, else 10].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = history)]
    history: Option<u32>,
    /// Describe only this obstacle; required for the trajectory frame.
    #[arg(long, value_name = "ID", allow_negative_numbers = true)]
    obstacle: Option<i64>,
}

/// What can be written after `--at`.
pub const AT: &str = "STEP|SECONDS|worst[:risk|ttc|distance]";

/// Steps of a window: no recording is longer than the most.
pub fn history(word: &str) -> Result<u32, String> {
    match word.parse() {
        Ok(steps @ 1..=100_000) => Ok(steps),
        _ => Err("expected 1 to 100000 steps".into()),
    }
}

impl Span {
    /// What was said.
    pub fn named(&self) -> span::Span {
        span::Span {
            at: self.at,
            history: self.history.map(|steps| steps as usize),
            obstacle: self.obstacle,
        }
    }
}

//! Time, tokens and cost of many questions, every attempt included; unknown values are counted, never taken as 0.

use super::super::statistics::quantile;
use super::super::{Scored, Spending};
use nearmiss_store::Consumed;

/// Consumption of questions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Consumption {
    /// Answers whose time is known.
    pub timed: u32,
    /// The median of their times, seconds.
    pub median_s: Option<f64>,
    /// The quantile 0.95 of their times, seconds.
    pub p95_s: Option<f64>,
    /// Attempts whose tokens are known.
    pub counted: u32,
    /// Tokens of their questions.
    pub input_tokens: u64,
    /// Tokens of their answers.
    pub output_tokens: u64,
    /// What they cost.
    pub spending: Spending,
    /// Attempts in whose place another one counts; they are among the others.
    pub superseded: u32,
}

impl Consumption {
    /// Of some questions. Medians and quantiles as in [`quantile`].
    pub fn from_scored(all: &[&Scored]) -> Self {
        let mut times = Vec::new();
        let mut sum = Self::default();
        for one in all {
            times.extend(one.consumed.duration_ms.map(|ms| ms as f64 / 1000.0));
            sum.tokens(&one.consumed);
            one.superseded.iter().for_each(|a| sum.tokens(&a.consumed));
            sum.superseded += count(one.superseded.len());
            sum.spending.join(&one.spending());
        }
        sum.timed = count(times.len());
        sum.median_s = quantile(&times, 0.5);
        sum.p95_s = quantile(&times, 0.95);
        sum
    }

    fn tokens(&mut self, of: &Consumed) {
        if let (Some(input), Some(output)) = (of.input_tokens, of.output_tokens) {
            self.counted += 1;
            self.input_tokens = self.input_tokens.saturating_add(input);
            self.output_tokens = self.output_tokens.saturating_add(output);
        }
    }
}

pub(super) fn count(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

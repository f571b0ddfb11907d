//! Time, tokens and cost of many questions, every attempt included; unknown values are counted, never taken as 0.

use schemars::JsonSchema;
use serde::Serialize;

use super::super::statistics::quantile;
use super::super::{Scored, Spending};
use nearmiss_store::Consumed;

/// Consumption of questions.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, JsonSchema)]
pub struct Consumption {
    /// Answers whose time is known.
    #[schemars(title = "Timed", extend("table" = "cost"))]
    pub timed: u32,
    /// The median of their times, seconds.
    #[schemars(title = "Median", extend("unit" = "s", "table" = "cost", "decimals" = 2))]
    pub seconds_median: Option<f64>,
    /// The quantile 0.95 of their times, seconds.
    #[schemars(title = "95 %", extend("unit" = "s", "table" = "cost", "decimals" = 2))]
    pub seconds_p95: Option<f64>,
    /// Attempts whose tokens are known.
    #[schemars(title = "Tokens known", extend("table" = "cost"))]
    pub tokens_of: u32,
    /// Tokens of their questions.
    #[schemars(title = "Input", extend("table" = "cost"))]
    pub input_tokens: Option<u64>,
    /// Tokens of their answers.
    #[schemars(title = "Output", extend("table" = "cost"))]
    pub output_tokens: Option<u64>,
    /// What the attempts of known cost cost, US dollars.
    #[schemars(title = "US dollars", extend("table" = "cost", "decimals" = 4))]
    pub cost_usd: Option<f64>,
    /// Attempts of known cost.
    pub cost_of: u32,
    /// Attempts of unknown cost.
    #[schemars(title = "Cost unknown", extend("table" = "cost"))]
    pub cost_unknown: u32,
    /// What those of them cost at most that a price and a limit bound, US dollars.
    #[schemars(title = "at most", extend("table" = "cost", "decimals" = 4))]
    pub cost_unknown_most_usd: Option<f64>,
    /// Attempts in whose place another one counts; they are among the others.
    #[schemars(title = "Superseded", extend("table" = "cost"))]
    pub superseded: u32,
}

impl Consumption {
    /// Of some questions. Medians and quantiles as in [`quantile`].
    pub fn from_scored(all: &[&Scored]) -> Self {
        let mut times = Vec::new();
        let mut sum = Self::default();
        let mut spending = Spending::default();
        for one in all {
            times.extend(one.consumed.duration_ms.map(|ms| ms as f64 / 1000.0));
            sum.tokens(&one.consumed);
            one.superseded.iter().for_each(|a| sum.tokens(&a.consumed));
            sum.superseded += count(one.superseded.len());
            spending.join(&one.spending());
        }
        Self {
            timed: count(times.len()),
            seconds_median: quantile(&times, 0.5),
            seconds_p95: quantile(&times, 0.95),
            cost_usd: spending.cost(),
            cost_of: spending.known,
            cost_unknown: spending.unpriced(),
            cost_unknown_most_usd: spending.most(),
            ..sum
        }
    }

    /// Whether anything is known of it.
    pub fn is_known(&self) -> bool {
        let bounded = self.cost_unknown_most_usd.is_some();
        self.timed + self.tokens_of + self.cost_of > 0 || bounded
    }

    fn tokens(&mut self, of: &Consumed) {
        if let (Some(input), Some(output)) = (of.input_tokens, of.output_tokens) {
            self.tokens_of += 1;
            let sum = |known: Option<u64>, more| known.unwrap_or(0).saturating_add(more);
            self.input_tokens = Some(sum(self.input_tokens, input));
            self.output_tokens = Some(sum(self.output_tokens, output));
        }
    }
}

pub(super) fn count(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

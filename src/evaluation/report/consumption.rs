//! Time, tokens and cost of many answers; unknown values are counted, never taken as 0.

use super::super::statistics::quantile;
use crate::store::Consumed;

/// Consumption of answers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Consumption {
    /// Answers whose time is known.
    pub timed: u32,
    /// The median of their times, seconds.
    pub median_s: Option<f64>,
    /// The quantile 0.95 of their times, seconds.
    pub p95_s: Option<f64>,
    /// Answers whose tokens are known.
    pub counted: u32,
    /// Tokens of their questions.
    pub input_tokens: u64,
    /// Tokens of these answers.
    pub output_tokens: u64,
    /// Answers whose cost is known.
    pub priced: u32,
    /// Their cost, US dollars; `None` if none is known.
    pub cost_usd: Option<f64>,
    /// All answers, known or not.
    pub n: u32,
}

impl Consumption {
    /// Of some answers. Medians and quantiles as in [`quantile`].
    pub fn from_answers<'a>(all: impl Iterator<Item = &'a Consumed> + Clone) -> Self {
        let times: Vec<f64> = all
            .clone()
            .filter_map(|c| c.duration_ms)
            .map(|ms| ms as f64 / 1000.0)
            .collect();
        let mut sum = Self {
            timed: count(times.len()),
            median_s: quantile(&times, 0.5),
            p95_s: quantile(&times, 0.95),
            ..Self::default()
        };
        for one in all {
            sum.n += 1;
            if let (Some(input), Some(output)) = (one.input_tokens, one.output_tokens) {
                sum.counted += 1;
                sum.input_tokens = sum.input_tokens.saturating_add(input);
                sum.output_tokens = sum.output_tokens.saturating_add(output);
            }
            if let Some(usd) = one.cost_usd {
                sum.priced += 1;
                *sum.cost_usd.get_or_insert(0.0) += usd;
            }
        }
        sum
    }

    /// Answers whose cost is not known.
    #[must_use]
    pub fn unpriced(&self) -> u32 {
        self.n - self.priced
    }
}

pub(super) fn count(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

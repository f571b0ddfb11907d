//! Measures that sum over the rest of the recording, from the last step to the first.
//!
//! Crash potential index: how likely, over the rest of the recording, the brakes are too weak.
//!
//! CPI = mean over the steps from now on, at which both are there, of P(MADR < DRAC); a step without a DRAC
//! counts as 0. The maximum available deceleration rate MADR is a truncated normal distribution. Source: Cunto
//! and Saccomanno 2008.
//!
//! Time integrated time to collision: by how much, from now to the end of the recording, it is too short.
//!
//! TIT = Σ dt·(τ − TTC) over the steps with TTC < τ, with the time to collision along the lane and τ the limit `tau`.
//! Source: Minderhoud and Bovy 2001.
//!
//! Time exposed time to collision: how long, from now to the end of the recording, it is too short.
//!
//! TET = Σ dt·[TTC < τ] with the time to collision along the lane and τ the limit `tau`. Steps at which the bodies
//! overlap along the lane have none and do not count. Source: Minderhoud and Bovy 2001.

use std::f64::consts::SQRT_2;

use super::super::{Danger, Encounter, Measure, Reading};
use super::following;
use crate::metrics::Context;
use crate::metrics::limits::Madr;

/// The quantity summed from a step to the end of the recording.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::metrics) struct Exposure {
    /// Seconds with a time to collision below the threshold.
    pub exposed: f64,
    /// The deficit to the threshold, integrated over time, s².
    pub integrated: f64,
    /// Probabilities that the needed deceleration is not available, added up.
    pub crash: f64,
    /// Steps at which both are there.
    pub steps: u32,
}

impl Exposure {
    /// The sums from every step of the ego on.
    pub fn rows(context: &Context<'_>, participant: usize) -> Vec<Self> {
        let mut rows = vec![Self::default(); context.length()];
        let mut sum = Self::default();
        let limits = context.limits();
        for index in (0..context.length()).rev() {
            let both = context.ego[index].is_some() && context.other(participant, index).is_some();
            sum.steps += u32::from(both);
            if both && let Ok(following) = context.following(participant, index) {
                if let Ok(time) = following::lane_time_to_collision(&following)
                    && time < limits.tau
                {
                    sum.exposed += context.dt();
                    sum.integrated += (limits.tau - time) * context.dt();
                }
                if let Ok(rate) = following::deceleration_rate(&following) {
                    sum.crash += probability(rate, &limits.madr);
                }
            }
            rows[index] = sum;
        }
        rows
    }
}

/// What the steps from now on sum up to.
fn of_exposure(encounter: &Encounter<'_>, sum: fn(&Exposure) -> f64) -> Reading {
    let exposure = encounter.ask(|c, other, index| c.exposure(other, index));
    exposure.map(|exposure| sum(&exposure)).into()
}

pub(in crate::metrics) const CRASH_POTENTIAL: Measure = Measure::new(
    "cpi",
    "crash potential index",
    "",
    Danger::High,
    "mean probability from now on that DRAC exceeds the brakes (Cunto and Saccomanno 2008)",
    |e| of_exposure(e, |x| x.crash / f64::from(x.steps.max(1))),
)
.reading_ahead();

/// Probability that the brakes give less than `rate`, m/s².
pub(super) fn probability(rate: f64, madr: &Madr) -> f64 {
    let below = |x: f64| 0.5 * libm::erfc((madr.mean - x) / (madr.deviation * SQRT_2));
    let (least, most) = (below(madr.least), below(madr.most));
    let inside = rate.clamp(madr.least, madr.most);
    (below(inside) - least) / (most - least)
}

pub(in crate::metrics) const TIME_INTEGRATED: Measure = Measure::new(
    "tit",
    "time integrated time to collision",
    "s²",
    Danger::High,
    "tau minus ttc_lane, integrated from now on (Minderhoud and Bovy 2001)",
    |e| of_exposure(e, |x| x.integrated),
)
.reading_ahead();

pub(in crate::metrics) const TIME_EXPOSED: Measure = Measure::new(
    "tet",
    "time exposed time to collision",
    "s",
    Danger::High,
    "time with ttc_lane below tau, from now on (Minderhoud and Bovy 2001)",
    |e| of_exposure(e, |x| x.exposed),
)
.reading_ahead();

#[cfg(test)]
mod tests {
    use super::*;

    use crate::metrics::limits::Limits;

    const MADR: Madr = Limits::SHIPPED.madr;

    fn probability(rate: f64) -> f64 {
        super::probability(rate, &MADR)
    }

    #[test]
    fn the_distribution_is_truncated() {
        assert_eq!(probability(4.0), 0.0);
        assert_eq!(probability(20.0), 1.0);
        // The bounds lie nearly alike around the mean.
        assert!((probability(MADR.mean) - 0.5).abs() < 1e-3);
        // One deviation below the mean: Φ(−1) = 0.158655, Φ(−3.0143) = 0.001288, Φ(3.0214) = 0.998742.
        let expected = (0.158_655 - 0.001_288) / (0.998_742 - 0.001_288);
        assert!((probability(MADR.mean - MADR.deviation) - expected).abs() < 1e-5);
    }
}

//! Crash potential index: how likely, over the rest of the recording, the brakes are too weak.
//!
//! CPI = mean over the steps from now on, at which both are there, of P(MADR < DRAC); a step without a DRAC
//! counts as 0. The maximum available deceleration rate MADR is a truncated normal distribution. Source: Cunto
//! and Saccomanno 2008.

use std::f64::consts::SQRT_2;

use super::super::{Danger, Encounter, Measure, Mirrored, Reading};
use crate::metrics::limits::Madr;

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "cpi",
    name: "crash potential index",
    unit: "",
    danger: Danger::High,
    mirrored: Mirrored::Kept,
    reads_ahead: true,
    source: "mean probability from now on that DRAC exceeds the brakes (Cunto and Saccomanno 2008)",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    let exposure = encounter.ask(|c, other, index| c.exposure(other, index));
    exposure.map(|e| e.crash / f64::from(e.steps.max(1))).into()
}

/// Probability that the brakes give less than `rate`, m/s².
pub(super) fn probability(rate: f64, madr: &Madr) -> f64 {
    let below = |x: f64| 0.5 * libm::erfc((madr.mean - x) / (madr.deviation * SQRT_2));
    let (least, most) = (below(madr.least), below(madr.most));
    let inside = rate.clamp(madr.least, madr.most);
    (below(inside) - least) / (most - least)
}

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

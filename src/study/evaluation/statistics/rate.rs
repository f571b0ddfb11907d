//! Rates of events over time or distance, with intervals for events that are independent and for those that are not.

use statrs::distribution::{ContinuousCDF, Gamma};

use super::Interval;
use super::interval::{FEWEST, ends, resampled};

/// The exact interval of 95 % of the mean of a Poisson distribution of which `events` were seen.
///
/// Its ends are the quantiles 0.025 of Γ(events, 1) and 0.975 of Γ(events + 1, 1); of no events 0 and 3.69. (The rule of three,
/// 3.00, is its one-sided sister.) F. Garwood, "Fiducial limits for the Poisson distribution", Biometrika 28 (1936).
#[must_use]
pub fn poisson(events: u64) -> Interval {
    let quantile = |shape: f64, p: f64| Gamma::new(shape, 1.0).map_or(0.0, |of| of.inverse_cdf(p));
    let events = events as f64;
    Interval {
        low: if events > 0.0 {
            quantile(events, 0.025)
        } else {
            0.0
        },
        high: quantile(events + 1.0, 0.975),
    }
}

/// The interval of 95 % of a rate, from the events and the exposure of each recording; `None` without exposure.
///
/// It is the wider at each end of [`poisson`], which takes events as independent, and, of [`FEWEST`] recordings and more, of
/// the bootstrap over recordings: drivers, roads and hours of one have much in common, and then the first is too narrow. Where
/// no or few recordings have an event, the bootstrap says nothing, and the first holds. The lower end is no lower than the exact one of
/// as many events as recordings have any.
#[must_use]
pub fn rate_interval(recordings: &[(u64, f64)]) -> Option<Interval> {
    let add = |(events, exposure): (u64, f64), one: &(u64, f64)| (events + one.0, exposure + one.1);
    let (events, exposure) = recordings.iter().fold((0, 0.0), add);
    if exposure <= 0.0 {
        return None;
    }
    let alone = poisson(events);
    let alone = Interval {
        low: alone.low / exposure,
        high: alone.high / exposure,
    };
    if recordings.len() < FEWEST as usize {
        return Some(alone);
    }
    let mut drawn = Vec::new();
    resampled(recordings.len(), |places| {
        let all = places.map(|place| recordings[place]);
        let (events, exposure) = all.fold((0, 0.0), |sum, one| add(sum, &one));
        drawn.extend((exposure > 0.0).then(|| events as f64 / exposure));
    });
    // The bootstrap may draw no recording with events; that there is one is known.
    let with_events = recordings.iter().filter(|(events, _)| *events > 0).count();
    let fewest = poisson(with_events as u64).low / exposure;
    Some(ends(drawn).map_or(alone, |together| Interval {
        low: alone.low.min(together.low.max(fewest)),
        high: alone.high.max(together.high),
    }))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// scipy 1.17: `chi2.ppf(0.025, 2*n)/2` and `chi2.ppf(0.975, 2*n + 2)/2`.
    #[test]
    fn as_scipy_has_it() {
        for (events, low, high) in [
            (0, 0.0, 3.688_879_454_113_936),
            (1, 0.025_317_807_984_289_876, 5.571_643_390_938_898),
            (10, 4.795_388_696_132_433_5, 18.390_356_042_017_78),
            (100, 81.363_991_250_923_14, 121.626_793_792_426_38),
            (1_000_000, 998_040.983_340_293_9, 1_001_961.911_945_432_2),
        ] {
            let found = poisson(events);
            let near = |value: f64, wanted: f64| (value - wanted).abs() <= 1e-9 * wanted;
            assert!(
                near(found.low, low) && near(found.high, high),
                "{events}: {found:?}"
            );
        }
    }

    #[test]
    fn events_that_come_together_widen_the_interval() {
        let even: Vec<(u64, f64)> = (0..40).map(|_| (2, 1.0)).collect();
        let rows: Vec<(u64, f64)> = (0..40)
            .map(|i| (if i % 8 == 0 { 16 } else { 0 }, 1.0))
            .collect();
        let (even, clustered) = (rate_interval(&even).unwrap(), rate_interval(&rows).unwrap());
        let exact = poisson(80);
        assert_eq!(even.low, exact.low / 40.0);
        assert_eq!(even.high, exact.high / 40.0);
        assert!(clustered.high > 1.3 * even.high && clustered.low < 0.7 * even.low);
        // All in one of many: the bootstrap often draws none, and one is known.
        let mut alone = [(0, 1.0); 20];
        alone[0].0 = 8;
        assert_eq!(rate_interval(&alone).unwrap().low, poisson(1).low / 20.0);
        // Too few to draw from, none seen, nowhere driven.
        assert_eq!(rate_interval(&[(16, 1.0)]).unwrap().high, poisson(16).high);
        let none = rate_interval(&[(0, 10.0); 20]).unwrap();
        assert!(none.low == 0.0 && (none.high - 0.018_444).abs() < 1e-5);
        assert_eq!(rate_interval(&[]), None);
    }
}

//! The interval of a share of answers, with the scenario as the unit.

use super::bootstrap::ratio_interval;
use super::{Interval, shown, wilson, wilson_of_share};

/// The interval of 95 % of a share of answers, from the hits and all answers of each scenario; `None` with fewer than
/// [`super::FEWEST`] scenarios.
///
/// Where a scenario has several answers, which are not independent, the bootstrap over scenarios; else Wilson's.
#[must_use]
pub fn scenario_interval(scenarios: &[(u32, u32)]) -> Option<Interval> {
    let answered = scenarios.iter().filter(|(_, all)| *all > 0);
    let answered: Vec<(u32, u32)> = answered.copied().collect();
    let clustered = answered.iter().any(|(_, all)| *all > 1);
    let drawn = clustered.then(|| ratio_interval(&answered)).flatten();
    let sum = |(hits, all): (u32, u32), one: &(u32, u32)| (hits + one.0, all + one.1);
    let counts = answered.iter().fold((0, 0), sum);
    share_interval(
        drawn,
        counts,
        u32::try_from(answered.len()).unwrap_or(u32::MAX),
    )
}

/// The interval of a share of answers about so many scenarios: the one that was drawn, else Wilson's. The bootstrap
/// cannot vary where all answers are right, or none is; there Wilson's takes the scenarios as observations.
#[must_use]
pub fn share_interval(
    drawn: Option<Interval>,
    (hits, all): (u32, u32),
    scenarios: u32,
) -> Option<Interval> {
    let interval = match drawn {
        Some(interval) if interval.low < interval.high => Some(interval),
        Some(_) => wilson_of_share(f64::from(hits) / f64::from(all), scenarios),
        None => wilson(hits, all),
    };
    shown(interval, scenarios)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn with_one_answer_each_it_is_wilsons() {
        let single: Vec<(u32, u32)> = (0..40).map(|n| (u32::from(n % 5 != 0), 1)).collect();
        assert_eq!(scenario_interval(&single), wilson(32, 40));
        assert_eq!(scenario_interval(&single[..9]), None, "nine are too few");
        assert_eq!(scenario_interval(&[]), None);
    }

    #[test]
    fn more_answers_about_the_same_scenarios_make_it_no_narrower() {
        let of = |samples: u32| -> Interval {
            let all: Vec<(u32, u32)> = (0..40)
                .map(|n| (samples * u32::from(n % 5 != 0), samples))
                .collect();
            scenario_interval(&all).unwrap()
        };
        assert_eq!(of(2), of(8));
        // By answers it would be half as wide.
        let by_answers = wilson(256, 320).unwrap();
        let width = |interval: Interval| interval.high - interval.low;
        assert!(width(of(8)) > 1.5 * width(by_answers));
        // The bootstrap cannot vary where all are right.
        assert_eq!(scenario_interval(&[(3, 3); 20]), wilson(20, 20));
    }
}

//! Statistics of yes-or-no answers and of events: intervals, tests, agreement and calibration, each with its formula and source.

mod best_of;
mod calibration;
mod interval;
mod kappa;
mod permutation;
mod rate;

pub use best_of::{Gain, PairedCounts, gains};
pub use calibration::{Bin, Calibration, auc};
pub use interval::{
    FEWEST, Interval, RESAMPLES, SEED, ShareIntervals, SplitMix, f1_interval, if_enough, intervals,
    mean_interval, quantile, ratio_interval, scenario_interval, share_interval, share_intervals,
    wilson, wilson_of_share,
};
pub use kappa::{AllRight, AnswerAgreement, Kappa, cohen, fleiss, majority};
pub use permutation::{DRAWS, EXACT_BELOW, EXACT_UP_TO, McNemar, PairedTest, fisher_p_value, holm};
pub use rate::{poisson, rate_interval};

/// The quantile of the standard normal distribution that two-sided intervals of 95 % need.
const Z: f64 = 1.959_963_984_540_054;

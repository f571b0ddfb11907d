//! Statistics of yes-or-no answers: intervals, tests, agreement and calibration, each with its formula and source.

mod auc;
mod best_of;
mod bootstrap;
mod calibration;
mod hypergeometric;
mod interval;
mod kappa;
mod mcnemar;
mod permutation;
mod proportion;
mod quantile;
mod random;
mod raters;
mod samples;

pub use auc::auc;
pub use best_of::{Gain, PairedCounts, gains};
pub use bootstrap::{
    RESAMPLES, ShareIntervals, f1_interval, intervals, mean_interval, ratio_interval,
    share_intervals,
};
pub use calibration::{Bin, Calibration};
pub use hypergeometric::part_of;
pub use interval::{FEWEST, Interval, shown, wilson, wilson_of_share};
pub use kappa::Kappa;
pub use mcnemar::{EXACT_BELOW, McNemar, holm};
pub use permutation::{DRAWS, EXACT_UP_TO, PairedTest};
pub use proportion::{scenario_interval, share_interval};
pub use quantile::quantile;
pub use random::{SEED, SplitMix};
pub use raters::{cohen, fleiss};
pub use samples::{AllRight, AnswerAgreement, majority};

/// The quantile of the standard normal distribution that two-sided intervals of 95 % need.
const Z: f64 = 1.959_963_984_540_054;

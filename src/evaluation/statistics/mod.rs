//! Statistics of yes-or-no answers: intervals, tests, agreement and calibration, each with its formula and source.

mod bootstrap;
mod calibration;
mod hypergeometric;
mod interval;
mod kappa;
mod mcnemar;
mod quantile;
mod samples;

pub use bootstrap::{RESAMPLES, SEED, f1_interval};
pub use calibration::{Bin, Calibration};
pub use hypergeometric::part_of;
pub use interval::{FEWEST, Interval, shown, wilson, wilson_of_share};
pub use kappa::Kappa;
pub use mcnemar::{EXACT_BELOW, McNemar, holm};
pub use quantile::quantile;
pub use samples::{AnswerAgreement, majority};

/// The quantile of the standard normal distribution that two-sided intervals of 95 % need.
const Z: f64 = 1.959_963_984_540_054;

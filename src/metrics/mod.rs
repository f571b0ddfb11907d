//! Safety measures: one file each, a registry, and series over steps and obstacles.
//!
//! Everything here but [`crate::metrics::paper`] uses the real shapes and the ego's own frame. A measure without a value
//! says why; no NaN and no infinity leaves this module.

mod distance;
mod encounter;
mod headline;
pub mod paper;
mod reading;
mod registry;
mod relation;
mod risk;
mod series;
mod thresholds;
mod time_to_collision;

pub use encounter::Encounter;
pub use headline::{Headline, Nearest};
pub use reading::{NoValue, Reading};
pub use registry::{Danger, MEASURES, Measure, measure};
pub use relation::{Direction, Relation};
pub use risk::{RISK_LEVELS, RiskLevel, RiskTable};
pub use series::Series;
pub use thresholds::{Threshold, thresholds};
pub use time_to_collision::HORIZON;

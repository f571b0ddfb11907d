//! Safety measures: one file each, a registry, and series over steps and obstacles.
//!
//! Everything here but [`crate::metrics::paper`] uses the real shapes, and the ego's own frame or its route. A
//! measure without a value says why; no NaN and no infinity leaves this module. Turning, moving or mirroring a
//! scene, or starting it at another time step, changes no measure but the sign of those that count to the left.

mod along;
mod contact;
mod contact_speed;
mod context;
mod distance;
mod encounter;
mod frame;
mod headline;
mod limit_table;
pub mod limits;
mod measure;
mod measure_list;
mod pair;
pub mod paper;
mod reading;
mod recorded;
mod registry;
mod relation;
mod risk;
mod risk_levels;
mod risk_scores;
mod scene_measures;
mod series;
mod severity;
mod thresholds;
mod time_to_collision;
mod worst_case;

pub use along::{LaneBody, LaneSet, Road};
pub use contact::Contact;
pub use context::Context;
pub use encounter::Encounter;
pub use headline::{Headline, Nearest};
pub use limit_table::{LIMITS, Limit};
pub use measure::{Danger, Measure, Mirrored};
pub use measure_list::MeasureList;
pub use reading::{NoValue, Reading};
pub use registry::{MEASURES, measure};
pub use relation::{Direction, Relation, side_of_centre};
pub use risk::UNROUNDED_RISK;
pub use risk_levels::{RISK_LEVELS, RiskLevel, RiskTable};
pub use risk_scores::{RiskConvention, ScoreAt};
pub use scene_measures::{SCENE_MEASURES, SceneMeasure};
pub use series::Series;
pub use severity::{
    CriticalMoment, Grade, Hazard, Moments, PairMoments, SEVERITY_NAMES, critical_moments,
};
pub use thresholds::{Change, Threshold, ThresholdError, Thresholds};
pub use time_to_collision::HORIZON;

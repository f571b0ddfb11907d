//! Safety measures: one file each, a registry, and series over steps and obstacles.
//!
//! Everything here but [`crate::metrics::paper`] uses the real shapes, and the ego's own frame or its route. A
//! measure without a value says why; no NaN and no infinity leaves this module. Turning, moving or mirroring a
//! scene, or starting it at another time step, changes no measure but the sign of those that count to the left.

mod along;
mod contact;
mod context;
pub mod limits;
mod measure;
pub mod paper;
mod plane;
mod recorded;
mod registry;
mod relation;
mod risk;
mod scene_measures;
mod series;
mod severity;
mod thresholds;

pub use along::{LaneBody, LaneSet, Road};
pub use contact::Contact;
pub use context::{Context, Encounter};
pub use limits::{LIMITS, Limit};
pub use measure::{Danger, Measure, Mirrored};
pub use plane::HORIZON;
pub use registry::{MEASURES, MeasureList, NoValue, Reading, measure};
pub use relation::{Direction, Relation, side_of_centre};
pub use risk::{RISK_LEVELS, RiskConvention, RiskLevel, RiskTable, ScoreAt, UNROUNDED_RISK};
pub use scene_measures::{Headline, Nearest, SCENE_MEASURES, SceneMeasure};
pub use series::Series;
pub use severity::{
    CriticalMoment, Grade, Hazard, Moments, PairMoments, SEVERITY_NAMES, critical_moments,
};
pub use thresholds::{Change, Threshold, ThresholdError, Thresholds};

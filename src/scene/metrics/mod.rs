//! Safety measures: a file and a row of [`crate::metrics::MEASURES`] each, and series over steps and obstacles.
//!
//! Everything here but [`crate::metrics::paper`] uses the real shapes, and the ego's own frame or its route. A
//! measure without a value says why; no NaN and no infinity leaves this module. Turning, moving or mirroring a
//! scene, or starting it at another time step, changes no measure but the sign of those that count to the left.

mod along;
mod contact;
mod context;
mod impact;
mod injury;
pub mod limits;
mod measure;
mod own;
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
pub use impact::{ContactSide, DEEP, Impact, ImpactRecord, sides};
pub use limits::{LIMITS, Limit};
pub use measure::{Danger, Measure, Mirrored};
pub use own::{OwnMeasure, OwnMeasures, OwnMistake, STATES, measures, own_formulas};
pub use plane::HORIZON;
pub use recorded::conflict::Passing;
pub use registry::{MeasureList, NoValue, Reading, measure};
pub use relation::{Direction, Relation, side_of_centre};
pub use risk::{
    RISK_LEVELS, RiskAspect, RiskConvention, RiskLevel, RiskTable, ScoreAt, UNROUNDED_RISK,
};
pub use scene_measures::{Headline, Nearest, SCENE_MEASURES, SceneMeasure};
pub use series::Series;
pub use severity::{
    CriticalMoment, DrivenPath, Grade, Hazard, Moments, PairMoments, SEVERITY_NAMES,
    critical_moments,
};
pub use thresholds::{Change, Threshold, ThresholdError, Thresholds};

use along::{exposure, following, rss};
use recorded::{conflict, manoeuvre};

/// Every measure that is shipped, in the order of columns; [`measures`] has those of the user, too.
pub const MEASURES: &[Measure] = &[
    plane::DISTANCE,
    plane::TIME_TO_COLLISION,
    risk::MEASURE,
    relation::GAP_LONG,
    relation::GAP_LAT,
    relation::TTC_LONG,
    relation::TTC_LAT,
    relation::V_REL_LONG,
    relation::V_REL_LAT,
    relation::A_REL_LONG,
    relation::A_REL_LAT,
    conflict::CLOSEST_DISTANCE,
    conflict::TIME_TO_CLOSEST,
    conflict::FIRST_OVERLAP,
    impact::CONTACT_SPEED,
    impact::DELTA_V,
    impact::DELTA_V_OTHER,
    impact::P_SERIOUS,
    impact::IMPACT_ANGLE,
    impact::IMPACT_OVERLAP,
    plane::WORST_CASE_TTC,
    following::HEADWAY,
    following::TIME_GAP,
    following::TIME_HEADWAY,
    following::LANE_TTC,
    following::LONGITUDINAL_ACCELERATION,
    following::LATERAL_ACCELERATION,
    following::DRAC,
    following::BRAKE_THREAT,
    following::STEER_THREAT,
    exposure::TIME_EXPOSED,
    exposure::TIME_INTEGRATED,
    exposure::CRASH_POTENTIAL,
    conflict::ENCROACHMENT_TIME,
    conflict::POST_ENCROACHMENT_TIME,
    manoeuvre::BRAKE,
    manoeuvre::KICK_DOWN,
    manoeuvre::STEER,
    manoeuvre::REACT,
    rss::LONGITUDINAL_DISTANCE,
    rss::LONGITUDINAL_MARGIN,
    rss::LATERAL_DISTANCE,
    rss::LATERAL_MARGIN,
    rss::RSS_MARGIN,
];

//! Traffic rules: which hold along a way, and which of them a drive broke.
//!
//! The rules are those formalised for CommonRoad: general ones (R-G) by Maierhofer, Rettinger, Mayer and Althoff,
//! Formalization of Interstate Traffic Rules in Temporal Logic, IV 2020, and those of intersections (R-IN) by
//! Maierhofer, Moosbrugger and Althoff, Formalization of Intersection Traffic Rules in Temporal Logic, IV 2022. What a
//! map does not say is not guessed: a rule that cannot be decided is reported as such.
//!
//! [`Regulations`] are the facts of the map along a way: speed limits, lights, stop signs, and at each intersection
//! the lanes that have to be given way to. The planner obeys them, and [`RuleReport`] holds any drive to them.

mod distance;
mod junction;
mod regulations;
mod report;
mod right_of_way;
mod stopping;

pub use junction::{Passage, Rival, Turn};
pub use regulations::{LimitedStretch, Regulations};
pub use report::{
    Finding, Rule, RuleReport, RuleStatus, STANDING, STOP_SECONDS, Violation, YIELD_AFTER,
    YIELD_BEFORE,
};
pub use right_of_way::SignRank;
pub use stopping::{LightLine, StopSignLine};

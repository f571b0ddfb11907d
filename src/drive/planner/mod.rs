//! A sampling-based motion planner along a reference path.
//!
//! Source: Werling, Ziegler, Kammel and Thrun, Optimal Trajectory Generation for Dynamic Street Scenarios in a Frenet
//! Frame, ICRA 2010. Candidates are polynomials along and across the path; those that a kinematic single-track vehicle
//! cannot drive, that leave the road or that touch an obstacle's predicted body are rejected, and the cheapest
//! remaining one is driven. The rules of the road are a cost that outweighs all others but not a contact: where none of
//! the candidates obeys, the one that breaks them least is driven. The planner is deterministic: the same input gives
//! the same plan.

mod emergency;
mod evaluate;
mod feasibility;
mod forecast;
mod lower_bound;
mod pace;
mod plan;
mod profile;
mod reference_track;
mod settings;
mod state;
#[cfg(test)]
mod tests;
mod traffic;

pub use emergency::Emergency;
pub use evaluate::{Candidate, Cost, Rejection};
pub use feasibility::{Bound, Broken, Feasibility, FeasibilityError, Feasible, Tolerance};
pub use forecast::{Forecast, ForecastCache, Forecaster};
pub use pace::{Arrival, Hold, LegalSpeed};
pub use plan::{Cancel, Memory, Plan, Planner};
pub use profile::Polynomial;
pub use reference_track::{ReferenceTrack, ReferenceTrackError};
pub use settings::{MOST_STEPS, RuleMode, Sampling, Settings, Weights};
pub use state::{CurvatureSpeedLimit, Limit, Limits, VehicleState};
pub use traffic::{Body, Road, Traffic, occupancy_sets};

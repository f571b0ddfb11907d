//! A sampling-based motion planner along a reference path.
//!
//! Source: Werling, Ziegler, Kammel and Thrun, Optimal Trajectory Generation for Dynamic Street Scenarios in a Frenet
//! Frame, ICRA 2010. Candidates are polynomials along and across the path; those that a kinematic single-track vehicle
//! cannot drive, that leave the road or that touch an obstacle's predicted body are rejected, and the cheapest
//! remaining one is driven. The rules of the road are a cost that outweighs all others but not a contact: where none of
//! the candidates obeys, the one that breaks them least is driven. The planner is deterministic: the same input gives
//! the same plan.

mod best_first;
mod brake;
mod cancel;
mod candidate;
mod close_traffic;
mod curvature_speed_limit;
mod emergency;
mod evaluate;
mod feasibility;
mod forecast;
mod forecast_cache;
mod goal;
mod lateral;
mod limits;
mod lower_bound;
mod motion;
mod obligation;
mod occupancy_sets;
mod pace;
mod place;
mod plan;
mod polynomial;
mod profile;
mod reference_track;
mod road;
mod samples;
mod settings;
mod smooth;
mod state;
mod states;
#[cfg(test)]
mod tests;
mod traffic;

pub use cancel::Cancel;
pub use candidate::{Candidate, Cost, Rejection};
pub use curvature_speed_limit::CurvatureSpeedLimit;
pub use emergency::Emergency;
pub use feasibility::{Bound, Broken, Feasibility, FeasibilityError, Feasible, Tolerance};
pub use forecast::{Forecast, Forecaster};
pub use forecast_cache::ForecastCache;
pub use goal::Arrival;
pub use limits::{Limit, Limits};
pub use occupancy_sets::occupancy_sets;
pub use pace::{Hold, LegalSpeed};
pub use plan::{Memory, Plan, Planner};
pub use polynomial::Polynomial;
pub use reference_track::{ReferenceTrack, ReferenceTrackError};
pub use road::Road;
pub use settings::{MOST_STEPS, RuleMode, Sampling, Settings, Weights};
pub use state::VehicleState;
pub use traffic::{Body, Traffic};

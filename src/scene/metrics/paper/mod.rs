//! The convention of the paper's published tables, defects and all; never the default.
//!
//! *From Words to Collisions* (Gao et al.) published its measures as `relative_metrics.csv`, those within 30 m as
//! `close_relative_metrics.csv`, and risk scores of one example as `risk_scores_*.csv`. This module computes the
//! same numbers from the same scenarios, so that results can be held against the published ones. It keeps what
//! the published tables do, which the measures of [`crate::metrics`] do not:
//!
//! - every participant, the ego too, is 4.508 m long and 1.610 m wide, and its box is never turned: centres that are
//!   less than one length apart along the ego's heading overlap along it, and the same across it with the width;
//! - the ego's heading, velocity and acceleration are those written in its recording, where the heading is 0 at
//!   standstill
//!   and velocity and acceleration are one step ahead of the position;
//! - accelerations are compared along the axes of the map, not of the ego;
//! - who overlaps along an axis has a time of 0 along it, whether it comes closer or not;
//! - the risk score takes its thresholds from the published code, which are not those of the published prompt, grades
//!   the
//!   rounded numbers, truncates instead of rounding, and gives `Behind` the weight of a diagonal.
//!
//! There is a row for every state of the trajectory of a dynamic obstacle at whose time step the ego has a row. The
//! initial states, which lie before the trajectories, have none, and static obstacles and those without a trajectory
//! have none.

mod direction;
mod motion;
mod relation;
mod risk;
mod row;

pub use direction::{Across, Along, Direction};
pub use motion::{AcrossMotion, AlongMotion};
pub use relation::{LENGTH, Relation, WIDTH};
pub use risk::Risk;
pub use row::{RADIUS, Row, TooLarge, rows};

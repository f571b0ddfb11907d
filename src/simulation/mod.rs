//! The closed loop: the planner drives the ego through the recorded traffic, which does not react to it.

mod collision;
mod drive;
mod ego;
mod outcome;

pub use collision::{Collision, Face};
pub use drive::{Cycle, Drive, DriveError, Settings, drive, drive_watched};
pub use outcome::Outcome;

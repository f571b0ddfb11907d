//! The closed loop: the planner drives the ego through the recorded traffic, which does not react to it.

mod collision;
mod drive;
mod driver;
mod ego;
mod outcome;
mod solution;

pub use collision::{Collision, Face};
pub use drive::{Cycle, Drive, DriveError, Settings, drive, drive_watched};
pub use driver::{Driver, Look, Noted, Stretch};
pub use outcome::Outcome;

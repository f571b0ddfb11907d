//! A planner's drive of the ego: who drives, what became of it, and records of it for programs.

mod choice;
mod driven;
mod hard;
mod monitored;
mod record;
mod rules;
mod standing;

pub use choice::{BUILT_IN, PlannerChoice, RECORDED};
pub use driven::{DriveOptions, DrivenScenario, drive, drive_each, drive_entry, median};
pub use hard::{Hardness, Solver, hardness};
pub use monitored::{MonitorAnswerRecord, MonitorRecord};
pub use record::{
    BeyondVehicleRecord, DriveRecord, ExternalDriveRecord, PlannerFaultRecord, ReactionRecord,
    UndrivableRecord, thousandths,
};
pub use rules::{RuleRecord, ViolationRecord};
pub use standing::{
    BeyondBaselines, DriveFigures, Standing, StandingRecord, beyond_baselines, standings, telling,
};

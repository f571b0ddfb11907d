//! Drivers: models of a person at the wheel, who see only the past and brake along the ego's own path.
//!
//! A file and a row of `DRIVERS` each: formula, parameters, source, and what it was not made for. They drive on a
//! straight road of numbers (`family`) and through recorded traffic with exact bodies (`Ride`); the same model
//! decides in both. `Preventability` asks all of them about one contact or near miss.

mod competent;
pub mod family;
mod field;
mod fuzzy;
mod ideal;
mod last_second;
mod model;
mod preventability;
mod record;
mod ride;
mod rss;
mod surprise;

pub(crate) use field::Lookout;
pub use field::{Field, Place};
pub use model::{Driver, DriverModel, NotMadeFor, Now, Parameter, Seen};
pub use preventability::{DriverOutcome, DriverResult, DriverVerdict, Preventability};
pub use record::{DriverRecord, ParameterRecord, PreventabilityRecord, VerdictRecord};
pub use ride::{Ride, RideState, Spot, Touch};

/// Every driver, in the order of columns.
pub const DRIVERS: &[DriverModel] = &[
    competent::MODEL,
    last_second::MODEL,
    rss::MODEL,
    fuzzy::MODEL,
    surprise::MODEL,
    ideal::MODEL,
];

/// The driver with this id.
///
/// # Errors
/// There is none; the message names those that there are.
pub fn driver(id: &str) -> Result<&'static DriverModel, String> {
    let found = DRIVERS.iter().find(|driver| driver.id == id);
    found.ok_or_else(|| {
        nearmiss_base::system::unknown("driver", id, DRIVERS.iter().map(|driver| driver.id))
    })
}

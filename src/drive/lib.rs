//! Drivers, planner, closed loop and generator: how an ego or an attacker drives.

/// Models of a person at the wheel.
pub mod driver;
/// Making a safe scenario dangerous: attackers, the gate, avoidability.
pub mod generation;
/// A sampling-based motion planner.
pub mod planner;
/// The closed loop: the planner drives the ego through a scenario.
pub mod simulation;

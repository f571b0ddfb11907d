//! Figures of drives that two planners are compared by.

use super::driven::DrivenScenario;
use nearmiss_drive::simulation::CollisionKind;

/// A figure of a drive; nothing where the drive has none.
pub type Measured = fn(&DrivenScenario) -> Option<f64>;

/// What is compared beside the outcomes, with the decimals that are shown.
pub const FIGURES: [(&str, &str, usize, Measured); 6] = [
    ("near_misses", "near misses", 2, |d| {
        d.near_misses.map(|n| n as f64)
    }),
    ("largest_deceleration", "strongest braking, m/s²", 2, |d| {
        Some(d.drive.largest_deceleration())
    }),
    ("mean_jerk", "mean jerk, m/s³", 2, |d| {
        d.drive.jerk().map(|j| j.0)
    }),
    ("max_jerk", "largest jerk, m/s³", 2, |d| {
        d.drive.jerk().map(|j| j.1)
    }),
    ("seconds_to_goal", "time to goal, s", 2, |d| {
        d.drive.seconds_to_goal()
    }),
    ("median_cycle_ms", "cycle, ms", 2, |d| {
        d.milliseconds().map(|(median, _)| median)
    }),
];

/// Collisions by kind.
pub const KINDS: [(&str, CollisionKind); 3] = [
    ("  ran into another", CollisionKind::RanInto),
    ("  rear-ended", CollisionKind::RearEnded),
    ("  side", CollisionKind::Side),
];

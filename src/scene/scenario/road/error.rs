//! Why there is no route.

use nearmiss_base::geometry::ReferencePathError;

/// Why there is no route.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RouteError {
    /// The scenario has no road.
    #[error("no lanelets")]
    NoRoad,
    /// The initial state does not say where.
    #[error("the start has no position")]
    NoStart,
    /// The start is on no lanelet that may be driven.
    #[error("the start is not on a drivable lanelet{}", closest(.nearest))]
    StartOffRoad {
        /// The nearest lanelet, and how far it is in metres.
        nearest: Option<(i64, f64)>,
    },
    /// The start points against the driving direction of every lanelet there.
    #[error("the start points against the direction of lanelet {}", list(.lanelets))]
    AgainstDirection {
        /// The lanelets there.
        lanelets: Vec<i64>,
    },
    /// No goal is on a lanelet that may be driven.
    #[error("no goal is on a drivable lanelet{}", missing(.unknown))]
    GoalOffRoad {
        /// Lanelets that the goals name and that are not in the network.
        unknown: Vec<i64>,
    },
    /// No way leads there.
    #[error("no route from lanelet {} to lanelet {}", list(.from), list(.to))]
    Unreachable {
        /// Lanelets at the start.
        from: Vec<i64>,
        /// Lanelets of the goals.
        to: Vec<i64>,
    },
    /// The recorded positions are not on lanelets.
    #[error("no position is on a drivable lanelet")]
    NeverOnRoad,
    /// The recorded positions jump between lanelets that are not connected.
    #[error("the positions jump from lanelet {from} to lanelet {to}, which are not connected")]
    Jumps {
        /// The lanelet before.
        from: i64,
        /// The lanelet after.
        to: i64,
    },
    /// No smooth path follows the lanelets.
    #[error("no smooth path follows lanelets {}: {source}", list(.lanelets))]
    NoPath {
        /// The lanelets.
        lanelets: Vec<i64>,
        /// Why.
        source: ReferencePathError,
    },
}

/// Ids in words; many are cut short.
fn list(ids: &[i64]) -> String {
    let mut words: Vec<String> = ids.iter().take(8).map(i64::to_string).collect();
    if ids.len() > words.len() {
        words.push("…".into());
    }
    words.join(", ")
}

fn closest(nearest: &Option<(i64, f64)>) -> String {
    nearest.map_or_else(String::new, |(id, distance)| {
        format!("; the nearest lanelet is {id}, {distance:.2} m away")
    })
}

fn missing(ids: &[i64]) -> String {
    if ids.is_empty() {
        String::new()
    } else {
        format!("; no lanelet {}", list(ids))
    }
}

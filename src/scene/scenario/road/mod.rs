//! The lanelet network as a road: what lies where, lanes, the graph, routes, the drivable area.

mod graph;
mod lane;
mod lane_relation;
mod matching;
mod route;

pub use graph::{DirectedLanelet, Direction, LaneGraph, Side};
pub use lane::Lane;
pub use lane_relation::{LaneRelation, LaneRelations};
pub use matching::DrivableArea;
pub(super) use matching::Index;
pub use route::{Destination, Leg, Route, RouteError};

/// Costs and distances that differ by less are alike, metres: rounding must not choose between them.
const COST_TOLERANCE: f64 = 1e-6;

/// Place of the item with the least cost; of several alike the first, so that rounding does not choose.
fn least<T>(items: &[T], cost: impl Fn(&T) -> f64) -> Option<usize> {
    let mut best: Option<(usize, f64)> = None;
    for (place, item) in items.iter().enumerate() {
        let cost = cost(item);
        if best.is_none_or(|(_, least)| cost < least - COST_TOLERANCE) {
            best = Some((place, cost));
        }
    }
    best.map(|(place, _)| place)
}

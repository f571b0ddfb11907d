//! Sizes of road users in data sets that give none: usual ones of their class.

use nearmiss_scene::scenario::ObstacleType;

/// Vehicles longer than this are trucks, metres, in data sets that have one class for all.
pub const LONG: f64 = 7.5;

/// Length and width that are assumed, metres.
pub fn usual(kind: ObstacleType) -> (f64, f64) {
    match kind {
        ObstacleType::Car | ObstacleType::Taxi | ObstacleType::PriorityVehicle => (4.6, 1.9),
        ObstacleType::Truck => (8.5, 2.5),
        ObstacleType::Bus => (12.0, 2.6),
        ObstacleType::Motorcycle => (2.1, 0.8),
        ObstacleType::Bicycle => (1.8, 0.7),
        ObstacleType::Pedestrian => (0.6, 0.6),
        ObstacleType::Train => (30.0, 2.7),
        _ => (1.0, 1.0),
    }
}

/// What was assumed, by kind, as in `car 4.6 m × 1.9 m`.
pub fn in_words(kinds: impl IntoIterator<Item = ObstacleType>) -> String {
    let mut kinds: Vec<ObstacleType> = kinds.into_iter().collect();
    kinds.sort_unstable();
    kinds.dedup();
    let each = kinds.iter().map(|kind| {
        let (length, width) = usual(*kind);
        format!("{} {length} m × {width} m", kind.name())
    });
    each.collect::<Vec<_>>().join(", ")
}

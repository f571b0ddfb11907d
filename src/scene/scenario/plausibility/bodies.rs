//! Obstacle bodies: implausible sizes, and bodies away from the obstacle's position.

use super::lines::self_crossing;
use crate::scenario::{Obstacle, ObstacleRole, ObstacleType};
use nearmiss_base::geometry::{Bounds, Point, Shape};

/// Bounds for an unknown type, metres: from negligible to larger than any building.
const ANYTHING: Sizes = Sizes::of(0.01, 10_000.0, 0.01, 10_000.0);

/// A body farther from its obstacle's position, metres, and farther than it is large, is elsewhere.
const ELSEWHERE: f64 = 10.0;

/// The least and the most length and width, metres.
#[derive(Debug, Clone, Copy)]
struct Sizes {
    length: (f64, f64),
    width: (f64, f64),
}

impl Sizes {
    const fn of(shortest: f64, longest: f64, narrowest: f64, widest: f64) -> Self {
        Self {
            length: (shortest, longest),
            width: (narrowest, widest),
        }
    }

    /// Wide enough for all that recordings of traffic hold: special vehicles, loads, boxes around groups.
    fn usual(kind: ObstacleType) -> Self {
        match kind {
            ObstacleType::Car | ObstacleType::Taxi => Self::of(1.0, 15.0, 0.5, 4.0),
            ObstacleType::Truck => Self::of(1.5, 40.0, 0.8, 8.0),
            ObstacleType::Bus => Self::of(2.0, 40.0, 0.8, 6.0),
            ObstacleType::PriorityVehicle => Self::of(1.0, 40.0, 0.4, 8.0),
            ObstacleType::ParkedVehicle => Self::of(0.5, 40.0, 0.2, 10.0),
            ObstacleType::Motorcycle | ObstacleType::Bicycle => Self::of(0.4, 6.0, 0.1, 3.0),
            ObstacleType::Pedestrian => Self::of(0.1, 5.0, 0.1, 5.0),
            ObstacleType::Train => Self::of(1.0, 1_000.0, 0.5, 8.0),
            ObstacleType::Unknown => Self::of(0.05, 100.0, 0.05, 100.0),
            _ => ANYTHING,
        }
    }
}

/// Implausible properties of an obstacle's body.
pub(super) fn check(obstacle: &Obstacle, say: &mut impl FnMut(String)) {
    let Some(footprint) = &obstacle.footprint else {
        return;
    };
    let shape = footprint.shape();
    if let Some((a, b)) = crossing(shape) {
        say(format!(
            "outline crosses itself after corners {} and {}; its convex hull is used",
            a + 1,
            b + 1
        ));
    }
    if !matches!(obstacle.role, ObstacleRole::Static | ObstacleRole::Dynamic) {
        return;
    }
    size(obstacle, shape, say);
    let corners = footprint.corners();
    let Some(around) = Bounds::from_points(corners) else {
        return;
    };
    let off = around.squared_distance(&Point::origin()).sqrt();
    let large = (around.max - around.min).norm();
    if off > ELSEWHERE.max(large) {
        say(format!(
            "body is {off:.0} m from its position; shapes are relative to the obstacle's position"
        ));
    }
}

fn size(obstacle: &Obstacle, shape: &Shape, say: &mut impl FnMut(String)) {
    // A rectangle may be turned against its obstacle.
    let (length, width) = match shape {
        Shape::Rectangle { length, width, .. } => (*length, *width),
        other => other.size(),
    };
    let (sizes, kind) = (Sizes::usual(obstacle.kind), obstacle.kind);
    let fits = |value: f64, (least, most): (f64, f64)| (least..=most).contains(&value);
    let size = format!("{length:.2} m × {width:.2} m");
    if !fits(length, sizes.length) || !fits(width, sizes.width) {
        // Of a body without a direction, only its extent matters.
        let turned = matches!(shape, Shape::Polygon { .. } | Shape::Group(_))
            && fits(width, sizes.length)
            && fits(length, sizes.width);
        if !turned {
            say(format!("{size} is implausible for a {kind}; used as is"));
        }
        return;
    }
    let long = matches!(
        kind,
        ObstacleType::Car
            | ObstacleType::Taxi
            | ObstacleType::Truck
            | ObstacleType::Bus
            | ObstacleType::Motorcycle
            | ObstacleType::Bicycle
    );
    if long && matches!(shape, Shape::Rectangle { .. }) && width > 1.2 * length {
        say(format!(
            "{size}: wider than long; are length and width swapped?"
        ));
    }
}

/// Two edges of one of the polygons in a shape that cross.
pub(super) fn crossing(shape: &Shape) -> Option<(usize, usize)> {
    match shape {
        Shape::Polygon { vertices } => self_crossing(vertices, true),
        Shape::Group(members) => members.iter().find_map(crossing),
        _ => None,
    }
}

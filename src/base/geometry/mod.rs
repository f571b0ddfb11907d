//! Plane geometry: poses, footprints with exact distances, polylines and polygons.
//!
//! Lengths are metres, angles radians (counter-clockwise, 0 along +x), times seconds.
//! This is the only module that knows parry's own vector types.

mod area;
mod footprint;
mod frenet;
mod polygon;
mod polyline;
mod pose;
mod reference_path;
mod shape;
mod spatial_index;
mod spline;
mod sweep;

pub use area::{Area, Outside};
pub use footprint::{Contact, Footprint, Gap, Placed, Tip};
pub use frenet::{Frenet, FrenetError, FrenetMotion, LateralProfile, PlaneMotion};
pub use polygon::{
    Bounds, contains, convex_hull, convex_overlap, part_within, ring_within, within_at,
};
pub use polyline::{Polyline, Projection, distance_to_segment};
pub use pose::{Pose, angle_between, normalize_angle};
pub use reference_path::{PathFrame, PathPoint, ReferencePath, ReferencePathError};
pub use shape::{SemiTrailer, Shape, ShapeError, Truck};
pub use spatial_index::{BoxTree, Rings};
pub use sweep::Sweep;

/// A point in the plane, metres.
pub type Point = nalgebra::Point2<f64>;
/// A displacement (m), velocity (m/s) or acceleration (m/s²) in the plane.
pub type Vector = nalgebra::Vector2<f64>;

#[cfg(test)]
mod frenet_tests;
#[cfg(test)]
mod sweep_tests;

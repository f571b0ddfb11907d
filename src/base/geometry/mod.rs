//! Plane geometry: poses, footprints with exact distances, polylines and polygons.
//!
//! Lengths are metres, angles radians (counter-clockwise, 0 along +x), times seconds.
//! This is the only module that knows parry's own vector types.

mod angle;
mod area;
mod box_tree;
mod clip;
mod convert;
mod convex;
mod cover;
mod footprint;
mod frenet;
mod frenet_motion;
mod gap;
mod polygon;
mod polyline;
mod pose;
mod projection;
mod reference_path;
mod rings;
mod shape;
mod spline;
mod truck;
mod way;

pub use angle::{angle_between, normalize_angle};
pub use area::{Area, Outside};
pub use box_tree::BoxTree;
pub use clip::{part_within, ring_within, within_at};
pub use convex::{convex_hull, convex_overlap};
pub use footprint::{Contact, Footprint, Placed};
pub use frenet::{Frenet, FrenetError, LateralProfile};
pub use frenet_motion::{FrenetMotion, PlaneMotion};
pub use gap::{Gap, Tip};
pub use polygon::{Bounds, contains};
pub use polyline::{Polyline, Projection, distance_to_segment};
pub use pose::Pose;
pub use reference_path::{PathFrame, PathPoint, ReferencePath, ReferencePathError};
pub use rings::Rings;
pub use shape::{Shape, ShapeError};
pub use truck::{SemiTrailer, Truck};
pub use way::Way;

/// A point in the plane, metres.
pub type Point = nalgebra::Point2<f64>;
/// A displacement (m), velocity (m/s) or acceleration (m/s²) in the plane.
pub type Vector = nalgebra::Vector2<f64>;

#[cfg(test)]
mod frenet_tests;
#[cfg(test)]
mod way_tests;

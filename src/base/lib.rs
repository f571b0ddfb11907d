//! Geometry and the operating system: what everything stands on.

/// Poses, footprints, polylines, polygons, with exact distances.
pub mod geometry;
/// The operating system: what it says, in plain words, and files that users name.
pub mod system;

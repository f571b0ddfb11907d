//! Checks that shapes enclose an area, and builds trucks and footprints from them.

use super::SourceLocation;
use crate::commonroad::ReadError;
use nearmiss_base::geometry::{Footprint, Point, SemiTrailer, Shape, Truck};

/// A shape that encloses something; `None` if the format lets it be left out.
///
/// # Errors
/// It encloses nothing, and cannot be left out.
pub fn checked(at: &impl SourceLocation, shape: Shape) -> Result<Option<Shape>, ReadError> {
    match shape.check() {
        Ok(()) => Ok(Some(shape)),
        Err(error) => at.leave_out(&error).map(|()| None),
    }
}

/// Shapes as one; nothing, with a diagnostic, where there is none.
pub fn union(at: &impl SourceLocation, shapes: Vec<Shape>) -> Option<Shape> {
    if shapes.is_empty() {
        at.warn("no shape; it covers nothing");
    }
    Shape::union(shapes)
}

/// The body of an obstacle, ready to be measured; `None` if the format lets it be left out.
///
/// # Errors
/// It cannot be measured, and cannot be left out.
pub fn footprint(
    at: &impl SourceLocation,
    shape: Option<Shape>,
) -> Result<Option<Footprint>, ReadError> {
    match shape.map(Footprint::new).transpose() {
        Ok(footprint) => Ok(footprint),
        Err(error) => at.leave_out(&error).map(|()| None),
    }
}

/// A polygon; the last corner of a closed ring is left out.
pub fn polygon(mut vertices: Vec<Point>) -> Shape {
    if vertices.len() > 3 && vertices.first() == vertices.last() {
        vertices.pop();
    }
    Shape::Polygon { vertices }
}

/// A truck of length, width, wheelbase, distance from the rear to the rear axle, length of the cabin, and distance
/// from the rear axle to the hitch, metres. Its origin is at the rear axle where `shift` says nothing.
pub fn truck(dimensions: [f64; 6], shift: Option<f64>) -> Truck {
    let [
        length,
        width,
        wheelbase,
        rear_to_rear_axle,
        cabin_length,
        rear_axle_to_hitch,
    ] = dimensions;
    Truck {
        length,
        width,
        wheelbase,
        rear_to_rear_axle,
        cabin_length,
        rear_axle_to_hitch,
        origin_x_shift: shift.unwrap_or(rear_to_rear_axle - length / 2.0),
    }
}

/// A truck in line with its trailer, which has a length, a width, a wheelbase, and a distance from its front to the
/// hitch, metres.
pub fn semi_trailer_truck(tractor: Truck, trailer: [f64; 4]) -> Shape {
    let [length, width, wheelbase, front_to_hitch] = trailer;
    let trailer = SemiTrailer {
        length,
        width,
        wheelbase,
        front_to_hitch,
    };
    Shape::SemiTrailerTruck {
        tractor,
        trailer,
        hitch_angle: 0.0,
    }
}

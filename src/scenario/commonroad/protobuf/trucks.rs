//! Trucks and semi-trailer trucks of 2024.

use super::messages::{SemiTrailerTruckShape, TruckShape};
use super::report::{At, Report};
use super::values::size;
use crate::geometry::{SemiTrailer, Shape, Truck};
use crate::scenario::commonroad::ReadError;

/// A truck by its dimensions.
pub(super) fn truck(
    report: &Report,
    at: &At<'_>,
    message: &TruckShape,
) -> Result<Truck, ReadError> {
    let dimensions = report.need(at, "truck_dims", message.truck_dims.as_ref())?;
    let of = at.field("truck_dims");
    let size = |name, value| size(report, &of, name, value);
    Ok(Truck {
        length: size("length", dimensions.length)?,
        width: size("width", dimensions.width)?,
        wheelbase: size("wheelbase", dimensions.wheelbase)?,
        rear_to_rear_axle: size(
            "dist_from_rear_to_rear_axle",
            dimensions.dist_from_rear_to_rear_axle,
        )?,
        cabin_length: size("cabin_length", dimensions.cabin_length)?,
        rear_axle_to_hitch: size(
            "dist_from_rear_axle_to_hitch",
            dimensions.dist_from_rear_axle_to_hitch,
        )?,
        origin_x_shift: super::values::size(report, at, "origin_x_shift", message.origin_x_shift)?,
    })
}

/// A tractor with its trailer; the schema has no hitch angle, so that the two are in line.
pub(super) fn semi_trailer_truck(
    report: &mut Report,
    at: &At<'_>,
    message: &SemiTrailerTruckShape,
) -> Result<Shape, ReadError> {
    let tractor = report.need(at, "truck_shape", message.truck_shape.as_ref())?;
    let trailer = report.need(at, "trailer_dims", message.trailer_dims.as_ref())?;
    let of = at.field("trailer_dims");
    let tractor = truck(report, &at.field("truck_shape"), tractor)?;
    let size = |name, value| size(report, &of, name, value);
    let trailer = SemiTrailer {
        length: size("length", trailer.length)?,
        width: size("width", trailer.width)?,
        wheelbase: size("wheelbase", trailer.wheelbase)?,
        front_to_hitch: size("dist_from_front_to_hitch", trailer.dist_from_front_to_hitch)?,
    };
    report.warn(
        at,
        "protobuf has no hitch angle; the trailer is taken to be in line",
    );
    Ok(Shape::SemiTrailerTruck {
        tractor,
        trailer,
        hitch_angle: 0.0,
    })
}

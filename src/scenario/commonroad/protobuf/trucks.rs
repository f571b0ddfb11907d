//! Trucks and semi-trailer trucks of 2024.

use super::messages::{SemiTrailerTruckShape, TruckShape};
use super::report::{At, Report};
use super::values::number;
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
    let number = |name, value| number(report, &of, name, value);
    Ok(Truck {
        length: number("length", dimensions.length)?,
        width: number("width", dimensions.width)?,
        wheelbase: number("wheelbase", dimensions.wheelbase)?,
        rear_to_rear_axle: number(
            "dist_from_rear_to_rear_axle",
            dimensions.dist_from_rear_to_rear_axle,
        )?,
        cabin_length: number("cabin_length", dimensions.cabin_length)?,
        rear_axle_to_hitch: number(
            "dist_from_rear_axle_to_hitch",
            dimensions.dist_from_rear_axle_to_hitch,
        )?,
        origin_x_shift: super::values::number(
            report,
            at,
            "origin_x_shift",
            message.origin_x_shift,
        )?,
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
    let number = |name, value| number(report, &of, name, value);
    let trailer = SemiTrailer {
        length: number("length", trailer.length)?,
        width: number("width", trailer.width)?,
        wheelbase: number("wheelbase", trailer.wheelbase)?,
        front_to_hitch: number("dist_from_front_to_hitch", trailer.dist_from_front_to_hitch)?,
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

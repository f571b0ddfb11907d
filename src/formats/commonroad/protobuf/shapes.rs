//! Regions and body shapes.

use super::messages::shape::Shape as Content;
use super::messages::{self, SemiTrailerTruckShape, ShapeGroup, TruckShape};
use super::report::FieldPath;
use crate::commonroad::ReadError;
use crate::commonroad::builder::{self, SourceLocation, checked};
use nearmiss_base::geometry::{Point, Shape, Truck};

/// Groups inside groups, deeper than any file needs.
const DEEPEST_GROUP: usize = 4;

/// Decoder of a shape message, which differs between versions.
pub(super) type Decode = fn(&FieldPath<'_>, &messages::Shape) -> Result<Option<Shape>, ReadError>;

/// The body of an obstacle of 2024; nothing, with a diagnostic, where there is no shape in it.
pub(super) fn body(at: &FieldPath<'_>, body: &messages::Shape) -> Result<Option<Shape>, ReadError> {
    let shape = match &body.shape {
        Some(Content::GroupOrTruck(bytes)) => {
            let at = at.field("truck_shape");
            Shape::Truck(truck(&at, &at.decode(bytes)?)?)
        }
        Some(Content::SemiTrailerTruck(bytes)) => {
            let at = at.field("semi_trailer_truck_shape");
            semi_trailer_truck(&at, &at.decode(bytes)?)?
        }
        _ => return region(at, body),
    };
    checked(at, shape)
}

/// A region of the world, or a body of 2020a; nothing, with a diagnostic, where there is no shape in it.
pub(super) fn region(
    at: &FieldPath<'_>,
    region: &messages::Shape,
) -> Result<Option<Shape>, ReadError> {
    match &region.shape {
        None | Some(Content::SemiTrailerTruck(_)) => Ok(builder::union(at, Vec::new())),
        Some(content) => inside(at, content, 0),
    }
}

fn inside(at: &FieldPath<'_>, content: &Content, depth: usize) -> Result<Option<Shape>, ReadError> {
    let shape = match content {
        Content::Rectangle(message) => rectangle(&at.field("rectangle"), message)?,
        Content::Circle(message) => circle(&at.field("circle"), message)?,
        Content::Polygon(message) => polygon(&at.field("polygon"), message)?,
        Content::GroupOrTruck(_) if depth == DEEPEST_GROUP => {
            let message = format!("groups of shapes are nested deeper than {DEEPEST_GROUP}");
            return Err(at.fail(message));
        }
        Content::GroupOrTruck(bytes) => {
            let at = at.field("shape_group");
            return group(&at, &at.decode(bytes)?, depth).map(Some);
        }
        Content::SemiTrailerTruck(_) => return Err(at.fail("a truck is not a region")),
    };
    checked(at, shape)
}

fn group(at: &FieldPath<'_>, group: &ShapeGroup, depth: usize) -> Result<Shape, ReadError> {
    let mut members = Vec::with_capacity(group.shapes.len());
    for (i, member) in group.shapes.iter().enumerate() {
        let at = at.nth("shapes", i);
        let content = member
            .shape
            .as_ref()
            .ok_or_else(|| at.fail("a member of a group without a shape"))?;
        members.extend(inside(&at, content, depth + 1)?);
    }
    Shape::union(members).ok_or_else(|| at.fail("a group without shapes"))
}

fn rectangle(at: &FieldPath<'_>, message: &messages::Rectangle) -> Result<Shape, ReadError> {
    let orientation = message.orientation.unwrap_or(0.0);
    Ok(Shape::Rectangle {
        length: at.size("length", message.length)?,
        width: at.size("width", message.width)?,
        center: center(at, message.center.as_ref())?,
        orientation: at.field("orientation").finite(orientation)?,
        origin_x_shift: 0.0,
    })
}

fn circle(at: &FieldPath<'_>, message: &messages::Circle) -> Result<Shape, ReadError> {
    Ok(Shape::Circle {
        radius: at.size("radius", message.radius)?,
        center: center(at, message.center.as_ref())?,
    })
}

fn center(at: &FieldPath<'_>, center: Option<&messages::Point>) -> Result<Point, ReadError> {
    Ok(at
        .optional_point("center", center)?
        .unwrap_or_else(Point::origin))
}

fn polygon(at: &FieldPath<'_>, message: &messages::Polygon) -> Result<Shape, ReadError> {
    let vertices = message
        .vertices
        .iter()
        .enumerate()
        .map(|(i, v)| at.nth("vertices", i).point(v));
    Ok(builder::polygon(vertices.collect::<Result<_, _>>()?))
}

/// A truck by its dimensions.
fn truck(at: &FieldPath<'_>, message: &TruckShape) -> Result<Truck, ReadError> {
    let dimensions = at.need("truck_dims", message.truck_dims.as_ref())?;
    let shift = at.size("origin_x_shift", message.origin_x_shift)?;
    let at = at.field("truck_dims");
    let dimensions = [
        at.size("length", dimensions.length)?,
        at.size("width", dimensions.width)?,
        at.size("wheelbase", dimensions.wheelbase)?,
        at.size(
            "dist_from_rear_to_rear_axle",
            dimensions.dist_from_rear_to_rear_axle,
        )?,
        at.size("cabin_length", dimensions.cabin_length)?,
        at.size(
            "dist_from_rear_axle_to_hitch",
            dimensions.dist_from_rear_axle_to_hitch,
        )?,
    ];
    Ok(builder::truck(dimensions, Some(shift)))
}

/// A tractor with its trailer; the schema has no hitch angle, so that the two are in line.
fn semi_trailer_truck(
    at: &FieldPath<'_>,
    message: &SemiTrailerTruckShape,
) -> Result<Shape, ReadError> {
    let tractor = at.need("truck_shape", message.truck_shape.as_ref())?;
    let tractor = truck(&at.field("truck_shape"), tractor)?;
    let trailer = at.need("trailer_dims", message.trailer_dims.as_ref())?;
    let of = at.field("trailer_dims");
    let trailer = [
        of.size("length", trailer.length)?,
        of.size("width", trailer.width)?,
        of.size("wheelbase", trailer.wheelbase)?,
        of.size("dist_from_front_to_hitch", trailer.dist_from_front_to_hitch)?,
    ];
    at.warn("protobuf has no hitch angle; the trailer is assumed to be in line");
    Ok(builder::semi_trailer_truck(tractor, trailer))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use prost::Message;

    use super::super::report::Report;
    use super::*;

    fn read(shape: Content, decode: Decode) -> (Result<Option<Shape>, ReadError>, Vec<String>) {
        let report = Report::about("x.pb");
        let shape = messages::Shape { shape: Some(shape) };
        let shape = decode(&FieldPath::root(&report, "shape"), &shape);
        let said = report.into_diagnostics();
        (shape, said.iter().map(ToString::to_string).collect())
    }

    #[test]
    fn a_body_of_2024_is_centred() {
        let rectangle = messages::Rectangle {
            length: Some(4.0),
            width: Some(2.0),
            ..Default::default()
        };
        // The same bytes are a region of 2020a.
        for decode in [body, region] {
            let (shape, said) = read(Content::Rectangle(rectangle), decode);
            assert_eq!(shape.unwrap(), Some(Shape::rectangle(4.0, 2.0)));
            assert!(said.is_empty(), "{said:?}");
        }
    }

    #[test]
    fn trucks_have_all_their_dimensions() {
        let dims = messages::TruckDims {
            length: Some(5.1),
            width: Some(2.55),
            wheelbase: Some(3.6),
            dist_from_rear_to_rear_axle: Some(0.5),
            cabin_length: Some(2.5),
            dist_from_rear_axle_to_hitch: Some(0.45),
        };
        let mut truck = TruckShape {
            truck_dims: Some(dims),
            origin_x_shift: Some(-1.7),
        };
        let alone = |truck: TruckShape| Content::GroupOrTruck(truck.encode_to_vec());
        let (shape, said) = read(alone(truck), body);
        assert!(matches!(shape.unwrap(), Some(Shape::Truck(t)) if t.rear_axle_to_hitch == 0.45));
        assert!(said.is_empty(), "{said:?}");
        let trailer = messages::TrailerDims {
            length: Some(13.6),
            width: Some(2.5),
            wheelbase: Some(7.8),
            dist_from_front_to_hitch: Some(0.9),
        };
        let both = SemiTrailerTruckShape {
            truck_shape: Some(truck),
            trailer_dims: Some(trailer),
        };
        let (shape, said) = read(Content::SemiTrailerTruck(both.encode_to_vec()), body);
        assert!(matches!(
            shape.unwrap(),
            Some(Shape::SemiTrailerTruck { .. })
        ));
        assert!(said[0].contains("semi_trailer_truck_shape"), "{said:?}");
        truck.truck_dims = Some(messages::TruckDims {
            cabin_length: None,
            ..dims
        });
        let error = read(alone(truck), body).0.unwrap_err().to_string();
        assert!(error.contains("cabin_length"), "{error}");
    }

    #[test]
    fn nothing_is_named() {
        let report = Report::about("x.pb");
        let shape = region(
            &FieldPath::root(&report, "shape"),
            &messages::Shape::default(),
        );
        assert_eq!(shape.unwrap(), None);
        assert_eq!(report.into_diagnostics().len(), 1);
    }

    #[test]
    fn a_ring_may_be_closed_and_has_a_corner_at_least_thrice() {
        let corner = |x, y| messages::Point {
            x: Some(x),
            y: Some(y),
            z: None,
        };
        let ring = [
            corner(0.0, 0.0),
            corner(1.0, 0.0),
            corner(1.0, 1.0),
            corner(0.0, 0.0),
        ];
        let polygon = |corners: &[messages::Point]| {
            Content::Polygon(messages::Polygon {
                vertices: corners.to_vec(),
            })
        };
        let (closed, _) = read(polygon(&ring), region);
        let Some(Shape::Polygon { vertices }) = closed.unwrap() else {
            panic!("not a polygon");
        };
        assert_eq!(vertices.len(), 3);
        let (error, _) = read(polygon(&ring[..2]), region);
        assert!(error.unwrap_err().message.contains("2 corners"));
    }
}

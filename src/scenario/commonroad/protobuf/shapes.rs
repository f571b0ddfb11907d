//! Regions and bodies.

use super::messages::{self, Body, BodyShape, Region, RegionShape};
use super::report::{At, Report};
use super::trucks::{semi_trailer_truck, truck};
use super::values::{finite, point, size};
use crate::geometry::{Footprint, Point, Shape};
use crate::scenario::commonroad::ReadError;

/// Groups inside groups, deeper than any file needs.
const DEEPEST_GROUP: usize = 4;

/// A message that describes the body of an obstacle, in the obstacle's own frame.
pub(super) trait BodyMessage:
    prost::Message + Default + std::fmt::Debug + PartialEq
{
    /// Its shape; nothing, with a diagnostic, where there is none that can be held.
    fn shape(&self, report: &mut Report, at: &At<'_>) -> Result<Option<Shape>, ReadError>;
}

impl BodyMessage for Region {
    fn shape(&self, report: &mut Report, at: &At<'_>) -> Result<Option<Shape>, ReadError> {
        region(report, at, self)
    }
}

impl BodyMessage for Body {
    fn shape(&self, report: &mut Report, at: &At<'_>) -> Result<Option<Shape>, ReadError> {
        let shape = match &self.shape {
            None => return Ok(nothing(report, at)),
            Some(BodyShape::Rectangle(r)) => rectangle(report, &at.field("rectangle"), r)?,
            Some(BodyShape::Circle(c)) => circle(report, &at.field("circle"), c)?,
            Some(BodyShape::Polygon(p)) => polygon(report, &at.field("polygon"), p)?,
            Some(BodyShape::Truck(t)) => Shape::Truck(truck(report, &at.field("truck_shape"), t)?),
            Some(BodyShape::SemiTrailerTruck(t)) => {
                semi_trailer_truck(report, &at.field("semi_trailer_truck_shape"), t)?
            }
        };
        checked(report, at, shape).map(Some)
    }
}

/// The body of an obstacle, ready to be measured; one that encloses nothing is an error of the file.
pub(super) fn footprint<B: BodyMessage>(
    report: &mut Report,
    at: &At<'_>,
    body: &B,
) -> Result<Option<Footprint>, ReadError> {
    let Some(shape) = body.shape(report, at)? else {
        return Ok(None);
    };
    let made = Footprint::new(shape);
    made.map(Some).map_err(|e| report.fail(at, e.to_string()))
}

/// A region of the world, or a body of 2020a; nothing, with a diagnostic, where there is no shape in it.
pub(super) fn region(
    report: &mut Report,
    at: &At<'_>,
    region: &Region,
) -> Result<Option<Shape>, ReadError> {
    if region.shape.is_none() {
        return Ok(nothing(report, at));
    }
    inside(report, at, region, 0).map(Some)
}

fn inside(report: &Report, at: &At<'_>, region: &Region, depth: usize) -> Result<Shape, ReadError> {
    let shape = match &region.shape {
        None => return Err(report.fail(at, "a member of a group without a shape")),
        Some(RegionShape::Rectangle(r)) => rectangle(report, &at.field("rectangle"), r)?,
        Some(RegionShape::Circle(c)) => circle(report, &at.field("circle"), c)?,
        Some(RegionShape::Polygon(p)) => polygon(report, &at.field("polygon"), p)?,
        Some(RegionShape::Group(_)) if depth == DEEPEST_GROUP => {
            return Err(report.fail(
                at,
                format!("groups of shapes are nested deeper than {DEEPEST_GROUP}"),
            ));
        }
        Some(RegionShape::Group(group)) => {
            let at = at.field("shape_group");
            let members = group.shapes.iter().enumerate();
            let members = members.map(|(i, s)| inside(report, &at.nth("shapes", i), s, depth + 1));
            let members = members.collect::<Result<Vec<_>, _>>()?;
            let union = Shape::union(members);
            return union.ok_or_else(|| report.fail(&at, "a group without shapes"));
        }
    };
    checked(report, at, shape)
}

fn checked(report: &Report, at: &At<'_>, shape: Shape) -> Result<Shape, ReadError> {
    shape.check().map_err(|e| report.fail(at, e.to_string()))?;
    Ok(shape)
}

fn nothing(report: &mut Report, at: &At<'_>) -> Option<Shape> {
    report.warn(at, "no shape in it; it covers nothing");
    None
}

fn rectangle(
    report: &Report,
    at: &At<'_>,
    message: &messages::Rectangle,
) -> Result<Shape, ReadError> {
    let turned = message
        .orientation
        .map(|o| finite(report, &at.field("orientation"), o));
    Ok(Shape::Rectangle {
        length: size(report, at, "length", message.length)?,
        width: size(report, at, "width", message.width)?,
        center: center(report, at, message.center.as_ref())?,
        orientation: turned.transpose()?.unwrap_or(0.0),
        origin_x_shift: 0.0,
    })
}

fn circle(report: &Report, at: &At<'_>, message: &messages::Circle) -> Result<Shape, ReadError> {
    Ok(Shape::Circle {
        radius: size(report, at, "radius", message.radius)?,
        center: center(report, at, message.center.as_ref())?,
    })
}

fn center(
    report: &Report,
    at: &At<'_>,
    center: Option<&messages::Point>,
) -> Result<Point, ReadError> {
    center.map_or(Ok(Point::origin()), |c| {
        point(report, &at.field("center"), c)
    })
}

fn polygon(report: &Report, at: &At<'_>, message: &messages::Polygon) -> Result<Shape, ReadError> {
    let vertices = message.vertices.iter().enumerate();
    let vertices = vertices.map(|(i, v)| point(report, &at.nth("vertices", i), v));
    let mut vertices = vertices.collect::<Result<Vec<_>, _>>()?;
    // Some files close the ring.
    if vertices.len() > 3 && vertices.first() == vertices.last() {
        vertices.pop();
    }
    Ok(Shape::Polygon { vertices })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use prost::Message;

    use super::*;

    fn read<B: BodyMessage>(body: &B) -> (Result<Option<Shape>, ReadError>, Vec<String>) {
        let mut report = Report::about("x.pb");
        let shape = body.shape(&mut report, &At::root("shape"));
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
        let body = Body {
            shape: Some(BodyShape::Rectangle(rectangle)),
        };
        let (shape, said) = read(&body);
        assert_eq!(shape.unwrap(), Some(Shape::rectangle(4.0, 2.0)));
        assert!(said.is_empty(), "{said:?}");
        // The same bytes are a region of 2020a.
        let region = Region::decode(body.encode_to_vec().as_slice()).unwrap();
        assert_eq!(read(&region).0.unwrap(), Some(Shape::rectangle(4.0, 2.0)));
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
        let mut truck = messages::TruckShape {
            truck_dims: Some(dims),
            origin_x_shift: Some(-1.7),
        };
        let body = |truck| Body {
            shape: Some(BodyShape::Truck(truck)),
        };
        let (shape, said) = read(&body(truck));
        assert!(matches!(shape.unwrap(), Some(Shape::Truck(t)) if t.rear_axle_to_hitch == 0.45));
        assert!(said.is_empty(), "{said:?}");
        let trailer = messages::TrailerDims {
            length: Some(13.6),
            width: Some(2.5),
            wheelbase: Some(7.8),
            dist_from_front_to_hitch: Some(0.9),
        };
        let both = messages::SemiTrailerTruckShape {
            truck_shape: Some(truck),
            trailer_dims: Some(trailer),
        };
        let (shape, said) = read(&Body {
            shape: Some(BodyShape::SemiTrailerTruck(both)),
        });
        assert!(matches!(
            shape.unwrap(),
            Some(Shape::SemiTrailerTruck { .. })
        ));
        assert!(said[0].contains("semi_trailer_truck_shape"), "{said:?}");
        truck.truck_dims = Some(messages::TruckDims {
            cabin_length: None,
            ..dims
        });
        let error = read(&body(truck)).0.unwrap_err().to_string();
        assert!(error.contains("cabin_length"), "{error}");
    }

    #[test]
    fn nothing_is_named() {
        let (shape, said) = read(&Region::default());
        assert_eq!((shape.unwrap(), said.len()), (None, 1));
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
        let region = |corners: &[messages::Point]| Region {
            shape: Some(RegionShape::Polygon(messages::Polygon {
                vertices: corners.to_vec(),
            })),
        };
        let (closed, _) = read(&region(&ring));
        let Some(Shape::Polygon { vertices }) = closed.unwrap() else {
            panic!("not a polygon");
        };
        assert_eq!(vertices.len(), 3);
        let (error, _) = read(&region(&ring[..2]));
        assert!(error.unwrap_err().message.contains("2 corners"));
    }
}

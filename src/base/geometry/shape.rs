//! Shapes as scenarios describe them: rectangles, circles, polygons, trucks with trailers, groups.
//!
//! Trucks and semi-trailers by the dimensions that CommonRoad gives them since 2026.

use std::borrow::Cow;

use serde::Serialize;
use serde::ser::SerializeStruct;

use super::{Point, Pose, Vector};

/// A region fixed to an object, in the object's own frame (x forward, y left, metres).
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Shape {
    /// A box; `length` along its own x, `width` along its own y.
    Rectangle {
        /// Metres, positive.
        length: f64,
        /// Metres, positive.
        width: f64,
        /// Centre in the object's frame.
        center: Point,
        /// Turn against the object's frame, radians.
        orientation: f64,
        /// Where the object's origin lies on the box, along the box's own x from its centre, metres.
        /// The box itself lies as far the other way.
        origin_x_shift: f64,
    },
    /// A disc.
    Circle {
        /// Metres, positive.
        radius: f64,
        /// Centre in the object's frame.
        center: Point,
    },
    /// A simple polygon, at least three vertices, not closed.
    Polygon {
        /// The corners in order.
        vertices: Vec<Point>,
    },
    /// A tractor with a trailer that turns about the hitch: two boxes.
    SemiTrailerTruck {
        /// In front.
        tractor: Truck,
        /// Turn of the trailer against the tractor, radians, counter-clockwise.
        hitch_angle: f64,
        /// Behind.
        trailer: SemiTrailer,
    },
    /// A truck, or the tractor of a semi-trailer truck: one box.
    #[serde(untagged)]
    Truck(Truck),
    /// The union of several shapes.
    #[serde(untagged, serialize_with = "group")]
    Group(Vec<Shape>),
}

fn group<S: serde::Serializer>(shapes: &[Shape], to: S) -> Result<S::Ok, S::Error> {
    let mut group = to.serialize_struct("Group", 2)?;
    group.serialize_field("kind", "group")?;
    group.serialize_field("shapes", shapes)?;
    group.end()
}

/// The frame of a rectangle's own centre in the object's frame.
pub(super) fn box_frame(center: &Point, orientation: f64, origin_x_shift: f64) -> Pose {
    let unshifted = Pose {
        position: *center,
        heading: orientation,
    };
    Pose {
        position: unshifted.to_world(&Point::new(-origin_x_shift, 0.0)),
        heading: orientation,
    }
}

/// Why numbers do not make a shape.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// A length, width or radius is not a positive finite number.
    #[error("{what} is {value}; expected a positive number of metres")]
    NotPositive {
        /// Which dimension.
        what: &'static str,
        /// What it was.
        value: f64,
    },
    /// A polygon has fewer than three different corners.
    #[error("a polygon of {count} corners; at least 3 are needed")]
    TooFewCorners {
        /// How many there are.
        count: usize,
    },
    /// The corners of a polygon lie on one line or on one point.
    #[error("the corners of the polygon are collinear")]
    Flat,
    /// A polygon has more corners than can be prepared in reasonable time.
    #[error("a polygon of {count} corners; at most {MOST_CORNERS} are supported")]
    TooManyCorners {
        /// How many there are.
        count: usize,
    },
    /// A group has no members.
    #[error("a shape group without shapes")]
    EmptyGroup,
}

/// # Errors
/// `value` is not a positive finite number.
pub(super) fn positive(what: &'static str, value: f64) -> Result<(), ShapeError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(ShapeError::NotPositive { what, value })
    }
}

/// Preparing a polygon for measuring takes time quadratic in its corners.
const MOST_CORNERS: usize = 1000;

/// Thinner than this, in parts of its length, points count as lying on a line.
const FLAT: f64 = 1e-9;

/// Whether points lie on a line, or as good as.
pub(super) fn is_flat(points: &[Point]) -> bool {
    let Some(first) = points.first() else {
        return true;
    };
    let farthest = points
        .iter()
        .map(|p| p - first)
        .max_by(|a, b| a.norm().total_cmp(&b.norm()));
    let along = farthest.unwrap_or_default();
    let length = along.norm();
    let width = |p: &Point| along.perp(&(p - first)).abs();
    // Written so that numbers too large to multiply count as flat.
    !points.iter().any(|p| width(p) > FLAT * length * length)
}

/// Corners of the polygon that stands for a circle where an outline is drawn.
const CIRCLE_CORNERS: usize = 16;

impl Shape {
    /// A box centred on the object, in line with it.
    #[must_use]
    pub fn rectangle(length: f64, width: f64) -> Self {
        Self::Rectangle {
            length,
            width,
            center: Point::origin(),
            orientation: 0.0,
            origin_x_shift: 0.0,
        }
    }

    /// Several shapes as one, groups flattened; `None` for none.
    #[must_use]
    pub fn union(shapes: Vec<Self>) -> Option<Self> {
        let mut members = Vec::with_capacity(shapes.len());
        for shape in shapes {
            match shape {
                Self::Group(inner) => members.extend(inner),
                other => members.push(other),
            }
        }
        match members.len() {
            0 | 1 => members.pop(),
            _ => Some(Self::Group(members)),
        }
    }

    /// The shape in terms of rectangles, circles, polygons and groups of them.
    #[must_use]
    pub fn plain(&self) -> Cow<'_, Self> {
        match self {
            Self::Truck(truck) => Cow::Owned(truck.rectangle()),
            Self::SemiTrailerTruck {
                tractor,
                trailer,
                hitch_angle,
            } => Cow::Owned(Self::Group(vec![
                tractor.rectangle(),
                trailer.rectangle(tractor, *hitch_angle),
            ])),
            _ => Cow::Borrowed(self),
        }
    }

    /// The same shape with the trailer of a semi-trailer truck turned by `angle`, radians;
    /// nothing where no part of it turns.
    #[must_use]
    pub fn hitched_at(&self, angle: f64) -> Option<Self> {
        match self {
            Self::SemiTrailerTruck {
                tractor, trailer, ..
            } => Some(Self::SemiTrailerTruck {
                tractor: *tractor,
                trailer: *trailer,
                hitch_angle: angle,
            }),
            _ => None,
        }
    }

    /// Checks that the shape encloses an area.
    ///
    /// # Errors
    /// A dimension that is not positive and finite, or a polygon of fewer than three corners.
    pub fn check(&self) -> Result<(), ShapeError> {
        match self {
            Self::Rectangle { length, width, .. } => {
                positive("length", *length)?;
                positive("width", *width)
            }
            Self::Circle { radius, .. } => positive("radius", *radius),
            Self::Polygon { vertices } if vertices.len() < 3 => Err(ShapeError::TooFewCorners {
                count: vertices.len(),
            }),
            Self::Polygon { vertices } if vertices.len() > MOST_CORNERS => {
                Err(ShapeError::TooManyCorners {
                    count: vertices.len(),
                })
            }
            Self::Polygon { vertices } if is_flat(vertices) => Err(ShapeError::Flat),
            Self::Polygon { .. } => Ok(()),
            Self::Truck(truck) => truck.check(),
            Self::SemiTrailerTruck {
                tractor, trailer, ..
            } => tractor.check().and_then(|()| trailer.check()),
            Self::Group(members) if members.is_empty() => Err(ShapeError::EmptyGroup),
            Self::Group(members) => members.iter().try_for_each(Self::check),
        }
    }

    /// Outlines in the object's frame, one closed ring (first corner not repeated) a part.
    #[must_use]
    pub fn outlines(&self) -> Vec<Vec<Point>> {
        match self {
            Self::Rectangle {
                length,
                width,
                center,
                orientation,
                origin_x_shift,
            } => {
                let frame = box_frame(center, *orientation, *origin_x_shift);
                let (l, w) = (length / 2.0, width / 2.0);
                let ring = [(l, w), (-l, w), (-l, -w), (l, -w)];
                vec![
                    ring.iter()
                        .map(|&(x, y)| frame.to_world(&Point::new(x, y)))
                        .collect(),
                ]
            }
            Self::Circle { radius, center } => {
                let corner = |i: usize| {
                    let (sin, cos) =
                        (std::f64::consts::TAU * i as f64 / CIRCLE_CORNERS as f64).sin_cos();
                    Point::new(center.x + radius * cos, center.y + radius * sin)
                };
                vec![(0..CIRCLE_CORNERS).map(corner).collect()]
            }
            Self::Polygon { vertices } => vec![vertices.clone()],
            Self::Group(members) => members.iter().flat_map(Self::outlines).collect(),
            Self::Truck(_) | Self::SemiTrailerTruck { .. } => self.plain().outlines(),
        }
    }

    /// The centroid of its area, in the object's frame; where parts overlap, both count. It turns with the shape, which
    /// the middle of a box around it does not.
    #[must_use]
    pub fn centroid(&self) -> Option<Point> {
        let rings = self.outlines();
        // From a corner, so that no digits are lost far from the origin.
        let origin = *rings.first()?.first()?;
        let (mut moment, mut area) = (Vector::zeros(), 0.0);
        for ring in &rings {
            let corners = ring.iter().map(|p| p - origin);
            let next = corners.clone().cycle().skip(1);
            let (mut of_ring, mut twice) = (Vector::zeros(), 0.0);
            for (a, b) in corners.zip(next) {
                let cross = a.perp(&b);
                of_ring += (a + b) * cross / 6.0;
                twice += cross;
            }
            // Whichever way round the corners are told.
            moment += of_ring * f64::signum(twice);
            area += twice.abs() / 2.0;
        }
        (area > 0.0).then(|| origin + moment / area)
    }

    /// Length and width of the smallest box in line with the object that holds the shape, metres.
    #[must_use]
    pub fn size(&self) -> (f64, f64) {
        if let Self::Circle { radius, .. } = self {
            return (2.0 * radius, 2.0 * radius);
        }
        let bounds = super::Bounds::from_points(self.outlines().iter().flatten());
        bounds.map_or((0.0, 0.0), |b| (b.max.x - b.min.x, b.max.y - b.min.y))
    }
}

/// A truck or a tractor. Lengths in metres, along the vehicle.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(tag = "kind", rename = "truck")]
pub struct Truck {
    /// From end to end.
    pub length: f64,
    /// Across.
    pub width: f64,
    /// Between the axles.
    pub wheelbase: f64,
    /// From the rear end to the rear axle.
    pub rear_to_rear_axle: f64,
    /// Of the driver's cabin.
    pub cabin_length: f64,
    /// From the rear axle to the hitch; positive towards the front.
    pub rear_axle_to_hitch: f64,
    /// Where the position of a state lies, from the middle of the truck; negative towards the rear.
    /// The rear axle by custom.
    pub origin_x_shift: f64,
}

/// The trailer of a semi-trailer truck. Lengths in metres, along the trailer.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct SemiTrailer {
    /// From end to end.
    pub length: f64,
    /// Across.
    pub width: f64,
    /// From the hitch to its axles.
    pub wheelbase: f64,
    /// From its front to the hitch.
    pub front_to_hitch: f64,
}

impl Truck {
    /// Checks that the truck has an extent.
    ///
    /// # Errors
    /// A dimension that is not positive and finite.
    pub fn check(&self) -> Result<(), ShapeError> {
        positive("length of the truck", self.length)?;
        positive("width of the truck", self.width)
    }

    /// Its body in the frame of its states.
    #[must_use]
    pub fn rectangle(&self) -> Shape {
        Shape::Rectangle {
            length: self.length,
            width: self.width,
            center: Point::origin(),
            orientation: 0.0,
            origin_x_shift: self.origin_x_shift,
        }
    }

    /// Where the hitch is, in the frame of its states: along x, metres.
    #[must_use]
    pub fn hitch(&self) -> f64 {
        let rear_axle = self.rear_to_rear_axle - self.length / 2.0 - self.origin_x_shift;
        rear_axle + self.rear_axle_to_hitch
    }
}

impl SemiTrailer {
    /// Checks that the trailer has an extent.
    ///
    /// # Errors
    /// A dimension that is not positive and finite.
    pub fn check(&self) -> Result<(), ShapeError> {
        positive("length of the trailer", self.length)?;
        positive("width of the trailer", self.width)
    }

    /// Its body in the frame of the tractor's states, turned by `angle` radians about the hitch.
    #[must_use]
    pub fn rectangle(&self, tractor: &Truck, angle: f64) -> Shape {
        let hitch = Pose::new(tractor.hitch(), 0.0, angle);
        Shape::Rectangle {
            length: self.length,
            width: self.width,
            center: hitch.to_world(&Point::new(self.front_to_hitch - self.length / 2.0, 0.0)),
            orientation: angle,
            origin_x_shift: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use std::f64::consts::FRAC_PI_2;

    use crate::geometry::Bounds;

    fn semi_trailer_truck(hitch_angle: f64) -> Shape {
        let tractor = Truck {
            length: 6.0,
            width: 2.5,
            wheelbase: 3.6,
            rear_to_rear_axle: 1.0,
            cabin_length: 2.5,
            rear_axle_to_hitch: 0.5,
            origin_x_shift: -2.0,
        };
        let trailer = SemiTrailer {
            length: 13.0,
            width: 2.5,
            wheelbase: 7.8,
            front_to_hitch: 1.0,
        };
        Shape::SemiTrailerTruck {
            tractor,
            trailer,
            hitch_angle,
        }
    }

    #[test]
    fn the_origin_is_the_rear_axle_and_the_trailer_follows() {
        // Rear axle at 0: the tractor covers -1 to 5, the hitch is at 0.5, the trailer covers -11.5 to 1.5.
        let straight = semi_trailer_truck(0.0);
        let bounds = Bounds::from_points(straight.outlines().iter().flatten()).unwrap();
        assert!((bounds.min.x + 11.5).abs() < 1e-12 && (bounds.max.x - 5.0).abs() < 1e-12);
        assert!((straight.size().0 - 16.5).abs() < 1e-12);
    }

    #[test]
    fn the_trailer_turns_about_the_hitch() {
        // Turned by a right angle the trailer, which trails, lies to the right of the hitch.
        let bent = semi_trailer_truck(0.0).hitched_at(FRAC_PI_2).unwrap();
        let trailer = &bent.outlines()[1];
        let bounds = Bounds::from_points(trailer).unwrap();
        assert!((bounds.min.y + 12.0).abs() < 1e-12 && (bounds.max.y - 1.0).abs() < 1e-12);
        assert!((bounds.center().x - 0.5).abs() < 1e-12);
        assert!(Shape::rectangle(4.0, 2.0).hitched_at(0.1).is_none());
    }

    /// The corners that commonroad-io 2026.1 computes for the same dimensions and state.
    #[test]
    fn an_external_reference_case() {
        let tractor = Truck {
            length: 5.1,
            width: 2.55,
            wheelbase: 3.6,
            rear_to_rear_axle: 0.5,
            cabin_length: 2.5,
            rear_axle_to_hitch: 0.45,
            origin_x_shift: -1.7,
        };
        let trailer = SemiTrailer {
            length: 13.6,
            width: 2.5,
            wheelbase: 7.8,
            front_to_hitch: 0.9,
        };
        let shape = Shape::SemiTrailerTruck {
            tractor,
            trailer,
            hitch_angle: -0.35,
        };
        let pose = Pose::new(12.0, -3.0, 0.6);
        let expected = [
            [
                (14.787_757_21, 0.452_033_421),
                (16.227_595_517, -1.652_572_397),
            ],
            [
                (12.645_299_792, -1.509_731_662),
                (13.263_809_69, -3.932_012_716),
            ],
        ];
        for (ring, [front_left, front_right]) in shape.outlines().iter().zip(expected) {
            for (corner, (x, y)) in [(ring[0], front_left), (ring[3], front_right)] {
                let at = pose.to_world(&corner);
                assert!(
                    (at - Point::new(x, y)).norm() < 1e-8,
                    "{at} is not ({x}, {y})"
                );
            }
        }
    }

    #[test]
    fn a_truck_without_extent_is_refused() {
        let Shape::SemiTrailerTruck { mut tractor, .. } = semi_trailer_truck(0.0) else {
            panic!("made as one");
        };
        tractor.width = 0.0;
        assert!(Shape::Truck(tractor).check().is_err());
    }
}

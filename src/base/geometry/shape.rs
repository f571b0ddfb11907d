//! Shapes as scenarios describe them: rectangles, circles, polygons, trucks, groups.

use std::borrow::Cow;

use serde::Serialize;
use serde::ser::SerializeStruct;

use super::{Point, Pose, SemiTrailer, Truck, Vector};

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

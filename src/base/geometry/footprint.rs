//! A shape prepared for exact distances, nearest points and times of contact, with parry doing the geometry.

use std::sync::Arc;

use parry2d_f64::math;
use parry2d_f64::query::{self, ClosestPoints, ShapeCastOptions, ShapeCastStatus};
use parry2d_f64::shape::{SharedShape, TriMesh};
use parry2d_f64::transformation::hertel_mehlhorn;

use super::shape::{box_frame, is_flat};
use super::{Point, Pose, Shape, ShapeError, Vector};

/// A checked [`Shape`], prepared for measuring distances. Cheap to clone.
#[derive(Clone)]
pub struct Footprint {
    shape: Arc<Shape>,
    pub(super) collider: SharedShape,
    reach: f64,
    /// A point inside each convex part, in the object's frame.
    pub(super) inner_points: Arc<[Point]>,
    corners: Arc<[Point]>,
}

/// A footprint at a pose.
#[derive(Debug, Clone, Copy)]
pub struct Placed<'a> {
    /// The footprint.
    pub footprint: &'a Footprint,
    /// Where.
    pub pose: Pose,
}

/// When two moving footprints touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Contact {
    /// They overlap or touch already.
    Now,
    /// They first touch after this many seconds.
    In(f64),
    /// They do not touch within the horizon.
    NotWithinHorizon,
}

impl Footprint {
    /// Prepares `shape`.
    ///
    /// # Errors
    /// See [`Shape::check`]. A polygon that cannot be cut into triangles (it crosses itself)
    /// is replaced by its convex hull.
    pub fn new(shape: Shape) -> Result<Self, ShapeError> {
        shape.check()?;
        let mut parts = Vec::new();
        collect(&shape, &mut parts)?;
        let inner_points = parts
            .iter()
            .map(|(frame, part)| {
                let middle = frame.transform_point(part.mass_properties(1.0).local_com);
                Point::new(middle.x, middle.y)
            })
            .collect();
        let collider = if parts.len() == 1 && parts[0].0 == math::Pose::identity() {
            parts.remove(0).1
        } else {
            SharedShape::compound(parts)
        };
        let corners: Arc<[Point]> = shape.outlines().into_iter().flatten().collect();
        let reach = match &shape {
            Shape::Circle { radius, center } => center.coords.norm() + radius,
            _ => corners.iter().map(|p| p.coords.norm()).fold(0.0, f64::max),
        };
        Ok(Self {
            shape: Arc::new(shape),
            collider,
            reach,
            inner_points,
            corners,
        })
    }

    /// The shape this was made from.
    #[must_use]
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Its convex parts, each with its place in the object's frame.
    pub(super) fn parts(&self) -> Vec<(math::Pose, &dyn parry2d_f64::shape::Shape)> {
        match self.collider.as_compound() {
            Some(compound) => {
                let parts = compound.shapes().iter();
                parts.map(|(place, part)| (*place, &**part)).collect()
            }
            None => vec![(math::Pose::identity(), &*self.collider)],
        }
    }

    /// Corners of its outlines in the object's frame, metres; for a circle, points on it.
    #[must_use]
    pub fn corners(&self) -> &[Point] {
        &self.corners
    }

    /// Distance of the farthest point from the object's origin, metres.
    #[must_use]
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// This footprint standing at `pose`.
    #[must_use]
    pub fn at(&self, pose: Pose) -> Placed<'_> {
        Placed {
            footprint: self,
            pose,
        }
    }
}

impl std::fmt::Debug for Footprint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.shape.fmt(f)
    }
}

impl PartialEq for Footprint {
    fn eq(&self, other: &Self) -> bool {
        self.shape == other.shape
    }
}

impl Placed<'_> {
    /// Exact distance between the two regions, metres; 0 when they touch or overlap.
    #[must_use]
    pub fn distance(&self, other: &Placed<'_>) -> f64 {
        // Both regions are convex or compounds of convex parts, which parry measures all.
        query::distance(
            &super::pose(&self.pose),
            &*self.footprint.collider,
            &super::pose(&other.pose),
            &*other.footprint.collider,
        )
        .map_or(f64::MAX, |d| d.distance)
    }

    /// How far the two regions are in each other, metres: the shortest way apart of their convex parts; 0 where they are
    /// apart.
    #[must_use]
    pub fn overlap(&self, other: &Placed<'_>) -> f64 {
        let contact = query::contact(
            &super::pose(&self.pose),
            &*self.footprint.collider,
            &super::pose(&other.pose),
            &*other.footprint.collider,
            0.0,
        )
        .ok()
        .flatten();
        contact.map_or(0.0, |contact| (-contact.dist).max(0.0))
    }

    /// When the two first touch if both keep their velocities (m/s) and headings.
    ///
    /// Exact for convex parts: the shape is swept, not sampled in time.
    #[must_use]
    pub fn contact(
        &self,
        velocity: &Vector,
        other: &Placed<'_>,
        other_velocity: &Vector,
        horizon: f64,
    ) -> Contact {
        let between = other.pose.position - self.pose.position;
        let closing = velocity - other_velocity;
        // Discs around both that do not meet in time spare the exact sweep.
        let speed = closing.norm_squared();
        let nearest = if speed > 0.0 {
            (between.dot(&closing) / speed).clamp(0.0, horizon)
        } else {
            0.0
        };
        let reach = self.footprint.reach + other.footprint.reach;
        if (between - closing * nearest).norm() > reach {
            return Contact::NotWithinHorizon;
        }
        // A cast of shapes that do not move relative to each other, or move apart, finds nothing.
        if between.norm() <= reach && self.distance(other) <= 0.0 {
            return Contact::Now;
        }
        let hit = query::cast_shapes(
            &super::pose(&self.pose),
            super::vector(velocity),
            &*self.footprint.collider,
            &super::pose(&other.pose),
            super::vector(other_velocity),
            &*other.footprint.collider,
            ShapeCastOptions::with_max_time_of_impact(horizon),
        );
        match hit {
            Ok(Some(hit)) if hit.status == ShapeCastStatus::PenetratingOrWithinTargetDist => {
                Contact::Now
            }
            Ok(Some(hit)) => Contact::In(hit.time_of_impact),
            Ok(None) | Err(_) => Contact::NotWithinHorizon,
        }
    }

    /// Outlines in the world, one ring (not closed) a part.
    #[must_use]
    pub fn outlines(&self) -> Vec<Vec<Point>> {
        let mut rings = self.footprint.shape.outlines();
        for p in rings.iter_mut().flatten() {
            *p = self.pose.to_world(p);
        }
        rings
    }

    /// The stretch that the region covers along `axis` (a unit vector), measured from `origin`, metres.
    #[must_use]
    pub fn extent(&self, origin: &Point, axis: &Vector) -> (f64, f64) {
        stretch(&self.footprint.shape, &self.pose, origin, axis)
    }
}

fn stretch(shape: &Shape, pose: &Pose, origin: &Point, axis: &Vector) -> (f64, f64) {
    let along = |p: &Point| (pose.to_world(p) - origin).dot(axis);
    let join = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
    match shape {
        Shape::Circle { radius, center } => {
            let middle = along(center);
            (middle - radius, middle + radius)
        }
        Shape::Rectangle {
            length,
            width,
            center,
            orientation,
            origin_x_shift,
        } => {
            let frame = box_frame(center, *orientation, *origin_x_shift);
            let middle = along(&frame.position);
            let (sin, cos) = (pose.heading + frame.heading).sin_cos();
            let (forward, left) = (Vector::new(cos, sin), Vector::new(-sin, cos));
            let half = length / 2.0 * forward.dot(axis).abs() + width / 2.0 * left.dot(axis).abs();
            (middle - half, middle + half)
        }
        Shape::Group(members) => members
            .iter()
            .map(|m| stretch(m, pose, origin, axis))
            .reduce(join)
            .unwrap_or((0.0, 0.0)),
        other => other
            .outlines()
            .iter()
            .flatten()
            .map(|p| (along(p), along(p)))
            .reduce(join)
            .unwrap_or((0.0, 0.0)),
    }
}

fn collect(shape: &Shape, parts: &mut Vec<(math::Pose, SharedShape)>) -> Result<(), ShapeError> {
    match shape {
        Shape::Rectangle {
            length,
            width,
            center,
            orientation,
            origin_x_shift,
        } => {
            let frame = super::pose(&box_frame(center, *orientation, *origin_x_shift));
            parts.push((frame, SharedShape::cuboid(length / 2.0, width / 2.0)));
        }
        Shape::Circle { radius, center } => {
            let frame = math::Pose::from_translation(super::point(center));
            parts.push((frame, SharedShape::ball(*radius)));
        }
        Shape::Polygon { vertices } => {
            let corners: Vec<_> = vertices.iter().map(super::point).collect();
            let hull = |points: &[math::Vector]| {
                let corners: Vec<Point> = points.iter().map(|p| Point::new(p.x, p.y)).collect();
                // Cutting may leave slivers without area.
                (!is_flat(&corners))
                    .then(|| SharedShape::convex_hull(points))
                    .flatten()
            };
            let mut pieces: Vec<SharedShape> = match TriMesh::from_polygon(corners.clone()) {
                Some(mesh) => hertel_mehlhorn(mesh.vertices(), mesh.indices())
                    .iter()
                    .filter_map(|piece| hull(piece))
                    .collect(),
                None => Vec::new(),
            };
            if pieces.is_empty() {
                pieces.extend(hull(&corners));
            }
            if pieces.is_empty() {
                return Err(ShapeError::Flat);
            }
            parts.extend(pieces.into_iter().map(|p| (math::Pose::identity(), p)));
        }
        Shape::Group(members) => {
            for member in members {
                collect(member, parts)?;
            }
        }
        Shape::Truck(_) | Shape::SemiTrailerTruck { .. } => collect(&shape.plain(), parts)?,
    }
    Ok(())
}

/// One end of a measured gap.
#[derive(Debug, Clone, Copy)]
pub enum Tip<'a> {
    /// A point of the world.
    Point(Point),
    /// A body at its pose.
    Body(Placed<'a>),
}

/// The gap between two things.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Exact distance, metres; 0 where they touch or overlap.
    pub metres: f64,
    /// The nearest points of the first and of the second; both in the middle where they touch.
    pub ends: (Point, Point),
}

impl Gap {
    /// The gap from one thing to another.
    #[must_use]
    pub fn between(from: &Tip<'_>, to: &Tip<'_>) -> Self {
        match (from, to) {
            (Tip::Point(a), Tip::Point(b)) => Self::of_points(*a, *b),
            (Tip::Body(body), Tip::Point(p)) => Self::of_points(nearest(body, p), *p),
            (Tip::Point(p), Tip::Body(body)) => Self::of_points(*p, nearest(body, p)),
            (Tip::Body(a), Tip::Body(b)) => Self::of_bodies(a, b),
        }
    }

    fn of_points(a: Point, b: Point) -> Self {
        Self {
            metres: (b - a).norm(),
            ends: (a, b),
        }
    }

    fn of_bodies(a: &Placed<'_>, b: &Placed<'_>) -> Self {
        let found = query::closest_points(
            &super::pose(&a.pose),
            &*a.footprint.collider,
            &super::pose(&b.pose),
            &*b.footprint.collider,
            f64::MAX,
        );
        match found {
            Ok(ClosestPoints::WithinMargin(p, q)) => {
                let ends = (Point::new(p.x, p.y), Point::new(q.x, q.y));
                // The same number as everywhere else.
                Self {
                    metres: a.distance(b),
                    ends,
                }
            }
            _ => {
                let middle = nalgebra::center(&a.pose.position, &b.pose.position);
                Self {
                    metres: a.distance(b),
                    ends: (middle, middle),
                }
            }
        }
    }
}

/// The point of a body that is nearest to `p`; `p` itself inside.
fn nearest(body: &Placed<'_>, p: &Point) -> Point {
    let pose = super::pose(&body.pose);
    let found = body
        .footprint
        .collider
        .project_point(&pose, super::point(p), true);
    Point::new(found.point.x, found.point.y)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::super::{Footprint, Pose, Shape};
    use super::*;

    fn car() -> Footprint {
        Footprint::new(Shape::rectangle(4.0, 2.0)).unwrap()
    }

    #[test]
    fn boxes_are_measured_edge_to_edge() {
        let car = car();
        let here = car.at(Pose::new(0.0, 0.0, 0.0));
        assert!((here.distance(&car.at(Pose::new(10.0, 0.0, 0.0))) - 6.0).abs() < 1e-9);
        let turned = car.at(Pose::new(10.0, 0.0, std::f64::consts::FRAC_PI_2));
        assert!((here.distance(&turned) - 7.0).abs() < 1e-9);
        assert_eq!(here.distance(&car.at(Pose::new(3.0, 1.0, 0.4))), 0.0);
        // Corner to corner: 3 across and 4 along.
        let diagonal = car.at(Pose::new(8.0, 5.0, 0.0));
        assert!((here.distance(&diagonal) - 5.0).abs() < 1e-9);
    }

    #[test]
    fn contact_is_swept_and_exact() {
        let car = car();
        let here = car.at(Pose::new(0.0, 0.0, 0.0));
        let there = car.at(Pose::new(14.0, 0.0, 0.0));
        let still = Vector::zeros();
        match here.contact(&Vector::new(5.0, 0.0), &there, &still, 10.0) {
            Contact::In(t) => assert!((t - 2.0).abs() < 1e-6, "{t}"),
            other => panic!("{other:?}"),
        }
        assert_eq!(
            here.contact(&Vector::new(-5.0, 0.0), &there, &still, 10.0),
            Contact::NotWithinHorizon
        );
        let over = car.at(Pose::new(1.0, 0.0, 0.0));
        assert_eq!(
            here.contact(&Vector::new(1.0, 0.0), &over, &still, 1.0),
            Contact::Now
        );
    }

    #[test]
    fn a_concave_polygon_keeps_its_notch() {
        let corners = [(0., 0.), (4., 0.), (4., 4.), (2., 1.), (0., 4.)];
        let vertices = corners.map(|(x, y)| Point::new(x, y)).to_vec();
        let notch = Footprint::new(Shape::Polygon { vertices }).unwrap();
        let dot = Footprint::new(Shape::Circle {
            radius: 0.1,
            center: Point::origin(),
        })
        .unwrap();
        let at = notch.at(Pose::new(0.0, 0.0, 0.0));
        assert!(at.distance(&dot.at(Pose::new(2.0, 3.0, 0.0))) > 0.5);
        assert_eq!(at.distance(&dot.at(Pose::new(2.0, 0.5, 0.0))), 0.0);
    }

    #[test]
    fn groups_are_measured_against_groups_and_swept() {
        let part = |x: f64| Shape::Rectangle {
            length: 2.0,
            width: 1.0,
            center: Point::new(x, 0.0),
            orientation: 0.0,
            origin_x_shift: 0.0,
        };
        let truck = Footprint::new(Shape::Group(vec![part(0.0), part(-4.0)])).unwrap();
        let (here, there) = (Pose::new(0.0, 0.0, 0.0), Pose::new(10.0, 0.0, 0.0));
        let (front, back) = (truck.at(there), truck.at(here));
        // From the front part of one to the trailing part of the other.
        assert!((back.distance(&front) - 4.0).abs() < 1e-9);
        match back.contact(&Vector::new(2.0, 0.0), &front, &Vector::zeros(), 10.0) {
            Contact::In(t) => assert!((t - 2.0).abs() < 1e-6, "{t}"),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn extents_follow_the_axis() {
        let car = car();
        let placed = car.at(Pose::new(5.0, 1.0, std::f64::consts::FRAC_PI_2));
        let (from, to) = placed.extent(&Point::origin(), &Vector::new(1.0, 0.0));
        assert!((from - 4.0).abs() < 1e-9 && (to - 6.0).abs() < 1e-9);
    }

    #[test]
    fn nonsense_is_refused() {
        assert!(Footprint::new(Shape::rectangle(0.0, 1.0)).is_err());
        assert!(Footprint::new(Shape::rectangle(f64::NAN, 1.0)).is_err());
        assert!(Footprint::new(Shape::Group(vec![])).is_err());
    }

    #[test]
    fn distances_that_can_be_worked_out_by_hand() {
        let car = Footprint::new(Shape::rectangle(4.0, 2.0)).unwrap();
        let here = Tip::Body(car.at(Pose::new(0.0, 0.0, 0.0)));
        // Centres 10 m apart: 2 m of each car are in between.
        let ahead = Gap::between(&here, &Tip::Body(car.at(Pose::new(10.0, 0.0, 0.0))));
        assert!((ahead.metres - 6.0).abs() < 1e-9);
        assert!((ahead.ends.0.x - 2.0).abs() < 1e-6 && (ahead.ends.1.x - 8.0).abs() < 1e-6);
        // From the corner (2, 1): 3 across and 4 up.
        let point = Gap::between(&here, &Tip::Point(Point::new(5.0, 5.0)));
        assert!((point.metres - 5.0).abs() < 1e-9);
        assert!((point.ends.0 - Point::new(2.0, 1.0)).norm() < 1e-9);
        let back = Gap::between(&Tip::Point(Point::new(5.0, 5.0)), &here);
        assert_eq!((back.ends.0, back.ends.1), (point.ends.1, point.ends.0));
        // Points: 3, 4, 5 again.
        let points = Gap::between(
            &Tip::Point(Point::new(1.0, 1.0)),
            &Tip::Point(Point::new(4.0, 5.0)),
        );
        assert!((points.metres - 5.0).abs() < 1e-12);
        // Inside, and overlapping.
        let inside = Gap::between(&here, &Tip::Point(Point::new(1.0, 0.5)));
        assert_eq!(inside.metres, 0.0);
        let over = Gap::between(&here, &Tip::Body(car.at(Pose::new(3.0, 0.5, 0.3))));
        assert_eq!(over.metres, 0.0);
    }
}

//! Areas made of many overlapping rings, such as a road of lanelets: what is wholly on them, and what sticks out.

use std::ops::ControlFlow;

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::simplify::SimplifyShape;
use i_overlay::float::single::SingleFloatOverlay;
use i_overlay::mesh::float::outline::offset::OutlineOffset;
use i_overlay::mesh::float::style::{LineJoin, OutlineStyle};
use parry2d_f64::query;
use parry2d_f64::shape::Segment;
use rstar::primitives::Line;
use rstar::{AABB, RTree};

use super::shape::box_frame;
use super::{Bounds, Placed, Point, Shape, Vector};

/// The union of rings, with small gaps between them closed. Never changed, fast to ask.
#[derive(Debug, Clone)]
pub struct Area {
    /// Coordinates are taken from here, so that far from the origin no digits are lost.
    origin: Point,
    /// Outer contours counter-clockwise, holes clockwise, around the origin.
    contours: Vec<Contour>,
    edges: RTree<Line<[f64; 2]>>,
}

type Contour = Vec<[f64; 2]>;

/// The parts of a body outside an area; empty for a body farther away than the Earth is large.
#[derive(Debug, Clone, PartialEq)]
pub struct Outside {
    /// The parts, as rings (not closed); a disc counts as the polygon of its outline.
    pub pieces: Vec<Vec<Point>>,
    /// Their size, m².
    pub size: f64,
    /// Their farthest corner from the area.
    pub farthest: Point,
    /// How far that corner is from the area, metres.
    pub distance: f64,
}

/// A body that sticks out by less than this is on the area, metres: corners of contours are rounded that much.
pub(super) const SLACK: f64 = 1e-3;

/// Coordinates beyond this are off the Earth, metres: its circumference is 4e7 m.
const FARTHEST: f64 = 1e8;

impl Area {
    /// The union of `rings` (not closed, any orientation, crossing themselves or not), in which gaps
    /// between them of up to `gap` metres are closed. Rings that leave the Earth are left out.
    ///
    /// Closing (dilation and erosion by half the gap) adds no point farther than that from a ring,
    /// and leaves straight outer borders where they are.
    #[must_use]
    pub fn union<'a>(rings: impl IntoIterator<Item = &'a [Point]>, gap: f64) -> Self {
        let rings = rings.into_iter().filter(|r| r.iter().all(on_earth));
        let mut origin = None;
        let mut parts: Vec<Contour> = Vec::new();
        for ring in rings {
            let Some(first) = ring.first() else { continue };
            let origin = *origin.get_or_insert(*first);
            let local = ring.iter().map(|p| local(&origin, p)).collect::<Contour>();
            // Each ring alone first, so that rings of both orientations do not cancel where they overlap.
            parts.extend(
                local
                    .simplify_shape_as::<i64>(FillRule::NonZero)
                    .into_iter()
                    .flatten(),
            );
        }
        let nothing: Vec<Contour> = Vec::new();
        let mut shapes =
            parts.overlay_as::<i64>(&nothing, OverlayRule::Subject, FillRule::Positive);
        if gap > 0.0 {
            for offset in [gap / 2.0, -gap / 2.0] {
                let style = OutlineStyle::new(offset).line_join(LineJoin::Miter(0.5));
                shapes = shapes.outline_as::<i64>(&style);
            }
        }
        let contours: Vec<Contour> = shapes.into_iter().flatten().collect();
        let edges = contours.iter().flat_map(|contour| {
            let next = contour.iter().cycle().skip(1);
            contour.iter().zip(next).map(|(a, b)| Line::new(*a, *b))
        });
        Self {
            origin: origin.unwrap_or_else(Point::origin),
            edges: RTree::bulk_load(edges.collect()),
            contours,
        }
    }

    /// The border: outer contours counter-clockwise, holes clockwise, not closed.
    pub fn border(&self) -> impl Iterator<Item = Vec<Point>> {
        self.contours.iter().map(|c| self.world(c))
    }

    /// Whether `p` is on the area, its border included up to rounding.
    #[must_use]
    pub fn contains(&self, p: &Point) -> bool {
        let at = local(&self.origin, p);
        self.encloses(at) || {
            let near = self.edges.nearest_neighbor_with_distance_2(at);
            near.is_some_and(|(_, squared)| squared <= SLACK * SLACK)
        }
    }

    /// By the crossings of the ray towards +x.
    fn encloses(&self, [x, y]: [f64; 2]) -> bool {
        let mut inside = false;
        let ray = AABB::from_corners([x, y], [f64::MAX, y]);
        let _ = self.edges.locate_in_envelope_intersecting_int(ray, |edge| {
            let ([ax, ay], [bx, by]) = (edge.from, edge.to);
            if (ay > y) != (by > y) && x < ax + (y - ay) / (by - ay) * (bx - ax) {
                inside = !inside;
            }
            ControlFlow::<()>::Continue(())
        });
        inside
    }

    /// Whether all of `body` is on the area, with a tolerance of a millimetre.
    #[must_use]
    pub fn covers(&self, body: &Placed<'_>) -> bool {
        let around = body.bounds();
        let corners = [&around.min, &around.max].map(|p| local(&self.origin, p));
        let around = AABB::from_corners(corners[0], corners[1]);
        let cut = self
            .edges
            .locate_in_envelope_intersecting_int(around, |edge| {
                let [from, to] = [edge.from, edge.to].map(|c| self.origin + Vector::from(c));
                if body.is_cut_by(&from, &to, SLACK) {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            });
        // No border runs through it, so one point speaks for each part.
        let enclosed = |p: Point| self.encloses(local(&self.origin, &p));
        cut.is_continue() && body.inner_points().all(enclosed)
    }

    /// The parts of `body` that are not on the area; `None` if the area covers it.
    #[must_use]
    pub fn outside(&self, body: &Placed<'_>) -> Option<Outside> {
        if self.covers(body) {
            return None;
        }
        if !on_earth(&body.pose.position) {
            return Some(Outside {
                pieces: Vec::new(),
                size: 0.0,
                farthest: body.pose.position,
                distance: FARTHEST,
            });
        }
        let rings = body.outlines().into_iter();
        let rings: Vec<Contour> = rings
            .map(|ring| ring.iter().map(|p| local(&self.origin, p)).collect())
            .collect();
        let pieces =
            rings.overlay_as::<i64>(&self.contours, OverlayRule::Difference, FillRule::NonZero);
        let pieces: Vec<Contour> = pieces.into_iter().flatten().collect();
        let size = pieces.iter().map(signed_size).sum();
        let distance = |at: &[f64; 2]| {
            let near = self.edges.nearest_neighbor_with_distance_2(*at);
            near.map_or(0.0, |(_, squared)| squared.sqrt())
        };
        let corners = pieces.iter().flatten().map(|c| (c, distance(c)));
        let (farthest, distance) = corners.max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(Outside {
            farthest: self.origin + Vector::from(*farthest),
            distance,
            size,
            pieces: pieces.iter().map(|c| self.world(c)).collect(),
        })
    }

    fn world(&self, contour: &Contour) -> Vec<Point> {
        let points = contour.iter().map(|c| self.origin + Vector::from(*c));
        points.collect()
    }
}

fn on_earth(p: &Point) -> bool {
    p.x.abs() <= FARTHEST && p.y.abs() <= FARTHEST
}

fn local(origin: &Point, p: &Point) -> [f64; 2] {
    [p.x - origin.x, p.y - origin.y]
}

/// Size of a contour, m²; negative for a hole.
fn signed_size(contour: &Contour) -> f64 {
    let next = contour.iter().cycle().skip(1);
    let crosses = contour
        .iter()
        .zip(next)
        .map(|(a, b)| a[0] * b[1] - a[1] * b[0]);
    crosses.sum::<f64>() / 2.0
}

impl Placed<'_> {
    /// A box in line with the axes around the body.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        if let Shape::Rectangle {
            length,
            width,
            center,
            orientation,
            origin_x_shift,
        } = self.footprint.shape()
        {
            let (sin, cos) = (self.pose.heading + orientation).sin_cos();
            let (l, w) = (length / 2.0, width / 2.0);
            let half = Vector::new(l * cos.abs() + w * sin.abs(), l * sin.abs() + w * cos.abs());
            let middle = box_frame(center, *orientation, *origin_x_shift).position;
            let middle = self.pose.to_world(&middle);
            return Bounds {
                min: middle - half,
                max: middle + half,
            };
        }
        let half = Vector::repeat(self.footprint.reach());
        Bounds {
            min: self.pose.position - half,
            max: self.pose.position + half,
        }
    }

    /// Whether `p` is inside the body or on its border.
    #[must_use]
    pub fn holds(&self, p: &Point) -> bool {
        let at = super::point(p);
        let body = &self.footprint.collider;
        body.contains_point(&super::pose(&self.pose), at)
    }

    /// Whether the line from `from` to `to` runs deeper than `slack` metres inside the body.
    pub(super) fn is_cut_by(&self, from: &Point, to: &Point, slack: f64) -> bool {
        match self.footprint.shape() {
            Shape::Rectangle {
                length,
                width,
                center,
                orientation,
                origin_x_shift,
            } => {
                let (sin, cos) = (self.pose.heading + orientation).sin_cos();
                let middle = box_frame(center, *orientation, *origin_x_shift).position;
                let middle = self.pose.to_world(&middle);
                let half = Vector::new(length / 2.0 - slack, width / 2.0 - slack);
                let [from, to] = [from, to].map(|p| {
                    let off = p - middle;
                    Vector::new(off.x * cos + off.y * sin, off.y * cos - off.x * sin)
                });
                runs_through(&from, &to, &half)
            }
            Shape::Circle { radius, center } => {
                let middle = self.pose.to_world(center);
                super::curve::distance_to_segment(&middle, from, to) < radius - slack
            }
            _ => {
                let line = Segment::new(super::point(from), super::point(to));
                let touch = query::contact(
                    &super::pose(&self.pose),
                    &*self.footprint.collider,
                    &super::pose(&super::Pose::new(0.0, 0.0, 0.0)),
                    &line,
                    0.0,
                );
                matches!(touch, Ok(Some(contact)) if contact.dist < -slack)
            }
        }
    }

    /// A point inside each convex part of the body.
    pub(super) fn inner_points(&self) -> impl Iterator<Item = Point> {
        let inner = self.footprint.inner_points.iter();
        inner.map(|p| self.pose.to_world(p))
    }

    /// Whether the body and the simple polygon `ring` (not closed) share more than borders.
    #[must_use]
    pub fn overlaps_ring(&self, ring: &[Point]) -> bool {
        let around = self.bounds();
        let near = |a: &Point, b: &Point| {
            a.x.min(b.x) <= around.max.x
                && a.x.max(b.x) >= around.min.x
                && a.y.min(b.y) <= around.max.y
                && a.y.max(b.y) >= around.min.y
        };
        let next = ring.iter().cycle().skip(1);
        let mut edges = ring.iter().zip(next);
        edges.any(|(a, b)| near(a, b) && self.is_cut_by(a, b, SLACK))
            || self.inner_points().any(|p| super::contains(ring, &p))
    }
}

/// Whether a line has a point inside the box of these half sizes around the origin (Liang and Barsky, 1984).
fn runs_through(from: &Vector, to: &Vector, half: &Vector) -> bool {
    let along = to - from;
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        if along[axis].abs() < f64::MIN_POSITIVE {
            if from[axis].abs() >= half[axis] {
                return false;
            }
            continue;
        }
        let ends = [-half[axis], half[axis]].map(|h| (h - from[axis]) / along[axis]);
        enter = enter.max(ends[0].min(ends[1]));
        leave = leave.min(ends[0].max(ends[1]));
    }
    enter < leave
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::geometry::{Footprint, Pose, Shape};

    fn ring(corners: &[(f64, f64)]) -> Vec<Point> {
        corners.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    fn block(x: f64, y: f64, length: f64, width: f64) -> Vec<Point> {
        ring(&[
            (x, y),
            (x + length, y),
            (x + length, y + width),
            (x, y + width),
        ])
    }

    fn union(rings: &[Vec<Point>], gap: f64) -> Area {
        Area::union(rings.iter().map(Vec::as_slice), gap)
    }

    fn car() -> Footprint {
        Footprint::new(Shape::rectangle(4.0, 2.0)).unwrap()
    }

    #[test]
    fn small_gaps_are_closed_and_wide_ones_are_not() {
        for far in [0.0, 1e5] {
            let lanes = |gap: f64| {
                [
                    block(far, far, 50.0, 3.5),
                    block(far, far + 3.5 + gap, 50.0, 3.5),
                ]
            };
            let across = Pose::new(far + 25.0, far + 3.5, 0.4);
            assert!(union(&lanes(0.0), 0.1).covers(&car().at(across)));
            assert!(union(&lanes(0.09), 0.1).covers(&car().at(across)));
            assert!(!union(&lanes(0.2), 0.1).covers(&car().at(across)));
            assert!(
                union(&lanes(-0.3), 0.1).covers(&car().at(across)),
                "overlapping lanes"
            );
        }
    }

    #[test]
    fn outer_borders_stay_where_they_are() {
        let area = union(
            &[block(0.0, 0.0, 50.0, 3.5), block(0.0, 3.55, 50.0, 3.5)],
            0.1,
        );
        let car = car();
        assert!(
            area.covers(&car.at(Pose::new(10.0, 1.0, 0.0))),
            "side on the border"
        );
        assert!(
            area.covers(&car.at(Pose::new(2.0, 1.0, 0.0))),
            "in the corner"
        );
        assert!(!area.covers(&car.at(Pose::new(10.0, 0.998, 0.0))));
        let out = area.outside(&car.at(Pose::new(10.0, 0.5, 0.0))).unwrap();
        assert!(
            (out.size - 2.0).abs() < 1e-3 && (out.distance - 0.5).abs() < 1e-3,
            "{out:?}"
        );
        assert!(area.outside(&car.at(Pose::new(10.0, 1.5, 0.0))).is_none());
    }

    #[test]
    fn orientation_crossing_and_holes() {
        let mut clockwise = block(5.0, 0.0, 20.0, 4.0);
        clockwise.reverse();
        let twisted = ring(&[(20.0, 0.0), (40.0, 4.0), (40.0, 0.0), (20.0, 4.0)]);
        let area = union(&[block(0.0, 0.0, 20.0, 4.0), clockwise, twisted], 0.0);
        assert!(area.covers(&car().at(Pose::new(12.0, 2.0, 0.1))));
        assert!(area.contains(&Point::new(38.0, 2.0)) && !area.contains(&Point::new(30.0, 3.5)));
        let frame = [
            block(0.0, 0.0, 30.0, 5.0),
            block(0.0, 25.0, 30.0, 5.0),
            block(0.0, 0.0, 5.0, 30.0),
            block(25.0, 0.0, 5.0, 30.0),
        ];
        let square = union(&frame, 0.1);
        assert!(!square.contains(&Point::new(15.0, 15.0)));
        assert!(
            !square.covers(&car().at(Pose::new(15.0, 15.0, 0.0))),
            "wholly in the hole"
        );
        assert!(square.covers(&car().at(Pose::new(2.5, 15.0, 1.57))));
        assert_eq!(square.border().count(), 2);
    }

    #[test]
    fn every_kind_of_body() {
        let area = union(&[block(0.0, 0.0, 50.0, 4.0)], 0.1);
        let disc = Footprint::new(Shape::Circle {
            radius: 1.0,
            center: Point::origin(),
        })
        .unwrap();
        let wedge = Shape::Polygon {
            vertices: ring(&[(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)]),
        };
        let wedge = Footprint::new(wedge).unwrap();
        let pair = Shape::Group(vec![
            Shape::rectangle(2.0, 1.0),
            Shape::Rectangle {
                length: 2.0,
                width: 1.0,
                center: Point::new(0.0, 60.0),
                orientation: 0.0,
                origin_x_shift: 0.0,
            },
        ]);
        let pair = Footprint::new(pair).unwrap();
        for body in [&disc, &wedge] {
            assert!(area.covers(&body.at(Pose::new(10.0, 2.0, 0.0))));
            assert!(area.covers(&body.at(Pose::new(10.0, 1.0, 0.0))));
            assert!(!area.covers(&body.at(Pose::new(10.0, 0.9, 0.0))));
            assert!(!area.covers(&body.at(Pose::new(10.0, -9.0, 0.0))));
        }
        assert!(
            !area.covers(&pair.at(Pose::new(10.0, 2.0, 0.0))),
            "one part is far off"
        );
    }

    #[test]
    fn nothing_covers_nothing() {
        let empty = union(&[], 0.1);
        assert!(!empty.covers(&car().at(Pose::new(0.0, 0.0, 0.0))));
        assert!(
            empty
                .outside(&car().at(Pose::new(0.0, 0.0, 0.0)))
                .unwrap()
                .size
                > 7.9
        );
        let lost = union(
            &[block(1e300, 0.0, 1.0, 1.0), vec![], ring(&[(0.0, 0.0); 4])],
            0.1,
        );
        assert!(!lost.contains(&Point::new(5.0, 5.0)));
    }
}

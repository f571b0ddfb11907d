//! Bodies against borders: whether a line runs through a placed footprint, and points that are inside it.

use parry2d_f64::query;
use parry2d_f64::shape::Segment;

use super::shape::box_frame;
use super::{Bounds, Placed, Point, Shape, Vector, convert};

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
        let at = convert::point(p);
        let body = &self.footprint.collider;
        body.contains_point(&convert::pose(&self.pose), at)
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
                super::polyline::distance_to_segment(&middle, from, to) < radius - slack
            }
            _ => {
                let line = Segment::new(convert::point(from), convert::point(to));
                let touch = query::contact(
                    &convert::pose(&self.pose),
                    &*self.footprint.collider,
                    &convert::pose(&super::Pose::new(0.0, 0.0, 0.0)),
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
        edges.any(|(a, b)| near(a, b) && self.is_cut_by(a, b, super::area::SLACK))
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

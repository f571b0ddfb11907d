//! Simple polygons and bounding boxes in line with the axes.

use super::Point;
use super::polyline::distance_to_segment;

/// A box in line with the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Lower left corner.
    pub min: Point,
    /// Upper right corner.
    pub max: Point,
}

impl Bounds {
    /// The smallest box around `points`; `None` for no points.
    pub fn from_points<'a>(points: impl IntoIterator<Item = &'a Point>) -> Option<Self> {
        points.into_iter().fold(None, |bounds, p| {
            Some(bounds.map_or(Self { min: *p, max: *p }, |b: Self| Self {
                min: Point::new(b.min.x.min(p.x), b.min.y.min(p.y)),
                max: Point::new(b.max.x.max(p.x), b.max.y.max(p.y)),
            }))
        })
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: Point::new(self.min.x.min(other.min.x), self.min.y.min(other.min.y)),
            max: Point::new(self.max.x.max(other.max.x), self.max.y.max(other.max.y)),
        }
    }

    /// Whether `p` is inside or on the border.
    #[must_use]
    pub fn contains(&self, p: &Point) -> bool {
        p.x >= self.min.x && p.x <= self.max.x && p.y >= self.min.y && p.y <= self.max.y
    }

    /// Whether the two boxes share a point.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.x <= other.max.x
            && self.max.x >= other.min.x
            && self.min.y <= other.max.y
            && self.max.y >= other.min.y
    }

    /// The square of the distance from `p` to the box, m²; 0 inside.
    #[must_use]
    pub fn squared_distance(&self, p: &Point) -> f64 {
        let x = (self.min.x - p.x).max(p.x - self.max.x).max(0.0);
        let y = (self.min.y - p.y).max(p.y - self.max.y).max(0.0);
        x * x + y * y
    }

    /// The middle.
    #[must_use]
    pub fn center(&self) -> Point {
        nalgebra::center(&self.min, &self.max)
    }
}

/// How far from an edge a point is still on it, metres: files have no finer digits.
const ON_EDGE: f64 = 1e-6;

/// Whether `p` is inside the polygon `ring` (not closed) or on its border, by winding number.
///
/// The border belongs to the polygon, so that no point falls between two neighbours. Where the ring
/// overlaps itself, both layers are inside.
#[must_use]
pub fn contains(ring: &[Point], p: &Point) -> bool {
    let mut winding = 0;
    let mut previous = match ring.last() {
        Some(last) => last,
        None => return false,
    };
    for corner in ring {
        let near_y =
            p.y >= previous.y.min(corner.y) - ON_EDGE && p.y <= previous.y.max(corner.y) + ON_EDGE;
        if near_y {
            let upward = corner.y > previous.y;
            let crosses = (corner.y > p.y) != (previous.y > p.y);
            let side = (corner - previous).perp(&(p - previous));
            if crosses && (side > 0.0) == upward {
                winding += if upward { 1 } else { -1 };
            }
            if distance_to_segment(p, previous, corner) <= ON_EDGE {
                return true;
            }
        }
        previous = corner;
    }
    winding != 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_concave_ring() {
        let ring =
            [(0., 0.), (4., 0.), (4., 4.), (2., 1.), (0., 4.)].map(|(x, y)| Point::new(x, y));
        assert!(contains(&ring, &Point::new(0.5, 2.0)));
        assert!(!contains(&ring, &Point::new(2.0, 2.0)), "in the notch");
        assert!(!contains(&[], &Point::new(0.0, 0.0)));
    }

    #[test]
    fn the_border_belongs_to_both_neighbours() {
        let slanted = |i: f64| Point::new(0.3 + 0.7 * i, 0.1 + 1.3 * i);
        let left = [slanted(0.0), slanted(1.0), Point::new(-5.0, 1.0)];
        let right = [slanted(1.0), slanted(0.0), Point::new(5.0, 1.0)];
        for i in 0..=1000 {
            let joint = slanted(f64::from(i) / 1000.0);
            assert!(contains(&left, &joint) && contains(&right, &joint), "{i}");
        }
        let off = Point::new(0.3 - 1e-5, 0.1);
        assert!(!contains(&right, &off));
    }

    #[test]
    fn where_a_ring_overlaps_itself_it_is_inside() {
        let ring = [
            (0., 0.),
            (6., 0.),
            (6., 2.),
            (2., 2.),
            (2., -2.),
            (4., -2.),
            (4., 4.),
            (0., 4.),
        ]
        .map(|(x, y)| Point::new(x, y));
        assert!(contains(&ring, &Point::new(3.0, 1.0)) && contains(&ring, &Point::new(1.0, 1.0)));
        assert!(!contains(&ring, &Point::new(5.0, 3.0)));
    }
}

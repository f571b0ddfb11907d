//! Simple polygons and bounding boxes in line with the axes.

use super::Point;

/// A box in line with the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Lower left corner.
    pub min: Point,
    /// Upper right corner.
    pub max: Point,
}

impl Bounds {
    /// The smallest box around `points`; nothing for no points.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a Point>) -> Option<Self> {
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

    /// The middle.
    #[must_use]
    pub fn center(&self) -> Point {
        nalgebra::center(&self.min, &self.max)
    }
}

/// Whether `p` is inside the simple polygon `ring` (not closed), by crossing number.
///
/// A point on an edge counts as inside for the lower and left edges only, so that
/// a point on the joint of two neighbours is in one of them.
#[must_use]
pub fn contains(ring: &[Point], p: &Point) -> bool {
    let mut inside = false;
    let mut previous = match ring.last() {
        Some(last) => last,
        None => return false,
    };
    for corner in ring {
        if (corner.y > p.y) != (previous.y > p.y) {
            let t = (p.y - corner.y) / (previous.y - corner.y);
            if p.x < corner.x + t * (previous.x - corner.x) {
                inside = !inside;
            }
        }
        previous = corner;
    }
    inside
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
}

//! Where the ego and another body touch at a step, or on the way to it from the step before.

use super::MapRequest;
use nearmiss_base::geometry::{Point, contains};
use nearmiss_scene::metrics;

/// A place where the ego touches another body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// The other's id.
    pub obstacle: i64,
    /// The middle of what both cover.
    pub at: Point,
    /// Whether the other is a region that an obstacle may cover or not.
    pub is_possible: bool,
}

/// Every contact.
pub(super) fn all(request: &MapRequest<'_>) -> Vec<Contact> {
    let step = request.step;
    let Some(scene) = request.subject.scene else {
        return Vec::new();
    };
    let touching = scene.participants().filter_map(|other| {
        let contact = metrics::Contact::at(scene, &other, step)?;
        let (mut ego, mut placed) = (scene.ego_at(step)?, other.placed_at(step)?);
        if !contact.overlaps {
            (ego.pose, placed.pose) = (contact.ego, contact.other);
        }
        Some(Contact {
            obstacle: other.obstacle.id,
            at: between(&ego.outlines().concat(), &placed.outlines().concat()),
            is_possible: other.obstacle.is_occupancy_at(step),
        })
    });
    touching.collect()
}

/// The middle of what two outlines have in common, by their corners and crossings; of bodies that only touch, between
/// them.
fn between(a: &[Point], b: &[Point]) -> Point {
    let mut common: Vec<Point> = a.iter().filter(|p| contains(b, p)).copied().collect();
    common.extend(b.iter().filter(|p| contains(a, p)));
    common.extend(crossings(a, b));
    if common.is_empty() {
        common.extend(nearest(a, b));
    }
    let count = common.len().max(1) as f64;
    let sum = common.iter().fold(Point::origin(), |s, p| s + p.coords);
    sum / count
}

/// Where edges cross.
fn crossings(a: &[Point], b: &[Point]) -> Vec<Point> {
    let edges = |ring: &[Point]| -> Vec<(Point, Point)> {
        let next = ring.iter().cycle().skip(1);
        ring.iter().copied().zip(next.copied()).collect()
    };
    let mut found = Vec::new();
    for (p, q) in edges(a) {
        for (r, s) in edges(b) {
            let (d, e, between) = (q - p, s - r, r - p);
            let cross = d.perp(&e);
            if cross.abs() < 1e-12 {
                continue;
            }
            let (t, u) = (between.perp(&e) / cross, between.perp(&d) / cross);
            if (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u) {
                found.push(p + d * t);
            }
        }
    }
    found
}

/// The two nearest corners.
fn nearest(a: &[Point], b: &[Point]) -> Vec<Point> {
    let pairs = a.iter().flat_map(|p| b.iter().map(move |q| (*p, *q)));
    let far = |(p, q): &(Point, Point)| (p - q).norm();
    let pair = pairs.min_by(|x, y| far(x).total_cmp(&far(y)));
    pair.map_or_else(Vec::new, |(p, q)| vec![p, q])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mark_is_where_the_bodies_overlap() {
        let ring = |corners: [(f64, f64); 4]| corners.map(|(x, y)| Point::new(x, y));
        let square =
            |x: f64, y: f64| ring([(x, y), (x + 4.0, y), (x + 4.0, y + 4.0), (x, y + 4.0)]);
        let near = |a: Point, b: Point| (a - b).norm() < 1e-9;
        assert!(near(
            between(&square(0.0, 0.0), &square(3.0, 3.0)),
            Point::new(3.5, 3.5)
        ));
        // A bar across: no corner of either lies in the other.
        let bar = ring([(-2.0, 1.0), (6.0, 1.0), (6.0, 2.0), (-2.0, 2.0)]);
        assert!(near(between(&square(0.0, 0.0), &bar), Point::new(2.0, 1.5)));
    }
}

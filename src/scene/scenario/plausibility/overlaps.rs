//! Checks for bodies that overlap at the first step.

use super::{ElementRef, Findings};
use crate::scenario::{Obstacle, ObstacleRole, ObstacleType, Scenario};
use nearmiss_base::geometry::{Point, convex_hull, convex_overlap};

/// Bodies are shrunk to this share of their size before they are held against each other: grazing is possible.
const CORE: f64 = 0.8;

/// One body at the first step.
struct Body<'a> {
    obstacle: &'a Obstacle,
    place: usize,
    middle: Point,
    reach: f64,
}

/// Tells of obstacles that overlap where the scenario begins.
pub(super) fn check(scenario: &Scenario, found: &mut Findings) {
    let step = scenario.steps().start;
    let all = scenario.obstacles.iter().enumerate();
    let mut bodies: Vec<Body<'_>> = all
        .filter(|(_, o)| matches!(o.role, ObstacleRole::Static | ObstacleRole::Dynamic))
        // Where an obstacle may be, others may be, too.
        .filter(|(_, o)| !o.is_occupancy_at(step))
        .filter_map(|(place, obstacle)| {
            Some(Body {
                obstacle,
                place,
                middle: obstacle.motion_at(step)?.pose.position,
                reach: obstacle.footprint_at(step)?.reach(),
            })
        })
        .collect();
    let begin = |body: &Body<'_>| body.middle.x - body.reach;
    bodies.sort_by(|a, b| begin(a).total_cmp(&begin(b)));
    for (i, a) in bodies.iter().enumerate() {
        let end = a.middle.x + a.reach;
        let later = bodies[i + 1..].iter();
        for b in later.take_while(|b| begin(b) <= end) {
            if !may(a.obstacle, b.obstacle) || !inside(a, b, step) {
                continue;
            }
            let (first, second) = if a.place < b.place { (a, b) } else { (b, a) };
            found.warn(
                ElementRef::Obstacle(second.place),
                format!(
                    "obstacle {}: overlaps obstacle {} at time step {step}",
                    second.obstacle.id, first.obstacle.id
                ),
            );
        }
    }
}

/// Whether two obstacles must not overlap: roadside objects may, and groups of pedestrians.
fn may(a: &Obstacle, b: &Obstacle) -> bool {
    let moves = |o: &Obstacle| o.role == ObstacleRole::Dynamic;
    let walks = |o: &Obstacle| o.kind == ObstacleType::Pedestrian;
    (moves(a) || moves(b)) && !(walks(a) && walks(b))
}

fn inside(a: &Body<'_>, b: &Body<'_>, step: i64) -> bool {
    let apart = (a.middle - b.middle).norm();
    let placed = a.obstacle.placed_at(step).zip(b.obstacle.placed_at(step));
    apart <= a.reach + b.reach
        // The hulls of bodies that are not convex may overlap where the bodies do not.
        && placed.is_some_and(|(a, b)| a.distance(&b) <= 0.0)
        && core(a.obstacle, step)
            .zip(core(b.obstacle, step))
            .is_some_and(|(a, b)| convex_overlap(&a, &b))
}

/// The hull of an obstacle's body, shrunk to its middle.
fn core(obstacle: &Obstacle, step: i64) -> Option<Vec<Point>> {
    let corners: Vec<Point> = obstacle
        .placed_at(step)?
        .outlines()
        .into_iter()
        .flatten()
        .collect();
    let mut hull = convex_hull(&corners);
    let sum = hull
        .iter()
        .map(|p| p.coords)
        .sum::<nearmiss_base::geometry::Vector>();
    let middle = Point::from(sum / hull.len().max(1) as f64);
    for corner in &mut hull {
        *corner = middle + (*corner - middle) * CORE;
    }
    Some(hull)
}

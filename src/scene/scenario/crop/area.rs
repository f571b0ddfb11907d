//! What lies within so many metres of a way or a point: obstacles, lanelets, signs, lights, intersections.

use std::collections::HashSet;

use nearmiss_base::geometry::{Bounds, Point, contains, distance_to_segment};

use crate::scenario::{
    Intersection, Lanelet, LaneletNetwork, Obstacle, Position, Prediction, Referable,
};

/// The area within so many metres of a way.
pub(super) struct Near {
    /// At least one point.
    way: Vec<Point>,
    metres: f64,
    /// The box around the area.
    bounds: Bounds,
}

impl Near {
    /// The area around a way or a point; nothing without points.
    pub fn new(way: Vec<Point>, metres: f64) -> Option<Self> {
        let Bounds { min, max } = Bounds::from_points(&way)?;
        let bounds = Bounds {
            min: Point::new(min.x - metres, min.y - metres),
            max: Point::new(max.x + metres, max.y + metres),
        };
        Some(Self {
            way,
            metres,
            bounds,
        })
    }

    /// Whether a point is inside.
    pub fn holds(&self, p: &Point) -> bool {
        self.bounds.contains(p) && self.is_within(p, self.metres)
    }

    fn is_within(&self, p: &Point, metres: f64) -> bool {
        let legs = self.way.windows(2);
        (self.way[0] - p).norm() <= metres || { legs }
            .any(|leg| distance_to_segment(p, &leg[0], &leg[1]) <= metres)
    }

    /// Whether a polygon (not closed) reaches into it.
    fn meets_ring(&self, ring: &[Point]) -> bool {
        let around = Bounds::from_points(ring);
        if !around.is_some_and(|around| around.overlaps(&self.bounds)) {
            return false;
        }
        let edges = || ring.iter().zip(ring.iter().cycle().skip(1));
        let touched = |p: &Point| {
            contains(ring, p) || edges().any(|(a, b)| distance_to_segment(p, a, b) <= self.metres)
        };
        ring.iter().any(|p| self.holds(p)) || self.way.iter().any(touched)
    }

    /// Whether the body of an obstacle is ever inside, or a region that it may cover.
    pub fn meets_obstacle(&self, obstacle: &Obstacle) -> bool {
        let meets = |rings: Vec<Vec<Point>>| rings.iter().any(|ring| self.meets_ring(ring));
        let reach = obstacle.footprint.as_ref().map_or(0.0, |f| f.reach());
        let mut motions = obstacle.track().iter();
        let body = motions.any(|(step, motion)| {
            let at = motion.pose.position;
            self.is_within(&at, self.metres + reach)
                && match obstacle.placed_at(step) {
                    Some(placed) => meets(placed.outlines()),
                    None => self.holds(&at),
                }
        });
        let regions = match &obstacle.prediction {
            Prediction::Occupancies(regions) => regions.as_slice(),
            _ => &[],
        };
        // Without a state the shape says where in the world it is.
        let standing = || match (&obstacle.initial, &obstacle.footprint) {
            (None, Some(footprint)) => meets(footprint.shape().outlines()),
            _ => false,
        };
        body || regions.iter().any(|one| meets(one.region.outlines())) || standing()
    }

    /// What of a position of a goal is inside, with the lanelets that are left.
    pub fn position(&self, position: &Position, network: &LaneletNetwork) -> Option<Position> {
        let kept = || Some(position.clone());
        match position {
            Position::Point(point) => self.holds(point).then(kept)?,
            Position::Region(shape) => {
                let mut rings = shape.outlines().into_iter();
                rings.any(|ring| self.meets_ring(&ring)).then(kept)?
            }
            Position::Lanelets(ids) => {
                let there = ids.iter().filter(|id| network.lanelet(**id).is_some());
                let left: Vec<i64> = there.copied().collect();
                (!left.is_empty()).then_some(Position::Lanelets(left))
            }
        }
    }

    /// The road inside: lanelets that reach into the area, what they refer to, and what nothing referred to inside it.
    pub fn network(&self, network: &LaneletNetwork) -> LaneletNetwork {
        let all = network.lanelets.iter();
        let mut lanelets: Vec<Lanelet> = all
            .filter(|lanelet| self.meets_ring(&lanelet.ring()))
            .cloned()
            .collect();
        let stays = |before: &HashSet<i64>, after: &HashSet<i64>, id: i64, at: Option<&Point>| {
            after.contains(&id) || !before.contains(&id) && at.is_some_and(|at| self.holds(at))
        };
        let signs_of =
            |all: &[Lanelet]| -> HashSet<i64> { all.iter().flat_map(Lanelet::all_signs).collect() };
        let (before, after) = (signs_of(&network.lanelets), signs_of(&lanelets));
        let mut signs = network.signs.clone();
        signs.retain(|sign| stays(&before, &after, sign.id, sign.position.as_ref()));
        let lights_of = |all: &[Lanelet]| -> HashSet<i64> {
            all.iter().flat_map(Lanelet::all_lights).collect()
        };
        let (before, after) = (lights_of(&network.lanelets), lights_of(&lanelets));
        let mut lights = network.lights.clone();
        lights.retain(|light| stays(&before, &after, light.id, light.position.as_ref()));
        let known = Referable::new(&lanelets, &signs, &lights);
        // What is gone is told in numbers.
        let untold = &mut |_| {};
        let mut intersections = network.intersections.clone();
        for intersection in &mut intersections {
            leave_ways(intersection, network, &lanelets);
            intersection.keep_references(&known, untold);
        }
        intersections.retain(|intersection| !intersection.incomings.is_empty());
        for lanelet in &mut lanelets {
            lanelet.keep_references(&known, untold);
        }
        let mut inner = LaneletNetwork::new(lanelets, signs, lights, intersections);
        let areas = network.areas.iter();
        inner.areas = areas
            .filter(|ring| self.meets_ring(ring))
            .cloned()
            .collect();
        inner
    }
}

/// Leaves out where a road leads whose lanelet to there is gone.
fn leave_ways(intersection: &mut Intersection, network: &LaneletNetwork, kept: &[Lanelet]) {
    let is_kept = |id: &i64| kept.iter().any(|lanelet| lanelet.id == *id);
    for road in &mut intersection.incomings {
        let (left, gone): (Vec<i64>, Vec<i64>) = road.lanelets.iter().partition(|id| is_kept(id));
        let next = |ids: &[i64]| -> HashSet<i64> {
            let lanelets = ids.iter().filter_map(|id| network.lanelet(*id));
            lanelets.flat_map(|l| &l.successors).copied().collect()
        };
        let (reached, missed) = (next(&left), next(&gone));
        for ids in [&mut road.right, &mut road.straight, &mut road.left] {
            ids.retain(|id| reached.contains(id) || !missed.contains(id));
        }
    }
}

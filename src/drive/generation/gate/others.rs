//! Other obstacles at a step: bodies, or the occupancy sets of set-based predictions.

use nearmiss_base::geometry::{Footprint, Placed, Point, Pose, Way};
use nearmiss_scene::scenario::{Obstacle, ObstacleRole, Prediction, Scenario, Steps, driven_way};

/// A region in which an obstacle is for a while.
#[derive(Debug, Clone)]
struct Region {
    obstacle: i64,
    time: Steps,
    body: Footprint,
    middle: Point,
    reach: f64,
}

/// The regions of all obstacles that have some.
#[derive(Debug, Clone)]
pub(super) struct Regions(Vec<Region>);

impl Regions {
    /// Those of a scenario; regions that enclose nothing are left out.
    pub fn new(scenario: &Scenario) -> Self {
        let mut regions = Vec::new();
        for obstacle in &scenario.obstacles {
            let Prediction::Occupancies(occupancies) = &obstacle.prediction else {
                continue;
            };
            for occupancy in occupancies {
                let Ok(body) = Footprint::new(occupancy.region.clone()) else {
                    continue;
                };
                let corners = body.corners();
                let sum = corners.iter().fold(Point::origin(), |s, p| s + p.coords);
                let middle = sum / corners.len().max(1) as f64;
                let reach = corners.iter().map(|p| (p - middle).norm());
                regions.push(Region {
                    obstacle: obstacle.id,
                    time: occupancy.time,
                    reach: reach.fold(0.0, f64::max),
                    middle,
                    body,
                });
            }
        }
        Self(regions)
    }

    fn overlapped<'s>(&'s self, body: &'s Placed<'_>, step: i64) -> impl Iterator<Item = i64> + 's {
        let there = self.0.iter().filter(move |r| {
            (r.time.from..=r.time.to).contains(&step)
                && (r.middle - body.pose.position).norm() <= r.reach + body.footprint.reach()
        });
        let here = Pose::new(0.0, 0.0, 0.0);
        let hit = there.filter(move |r| body.distance(&r.body.at(here)) <= 0.0);
        hit.map(|r| r.obstacle)
    }
}

/// Whether two bodies overlap or touch: exact distance 0.
pub(super) fn touch(a: &Placed<'_>, b: &Placed<'_>) -> bool {
    let far = a.footprint.reach() + b.footprint.reach();
    (a.pose.position - b.pose.position).norm_squared() <= far * far && a.distance(b) <= 0.0
}

/// The obstacles that a body touches at a step or on the way there from where it was a step before, without itself.
pub(super) fn overlapped<'s>(
    scenario: &'s Scenario,
    regions: &'s Regions,
    before: Option<Placed<'s>>,
    body: &'s Placed<'_>,
    itself: i64,
    step: i64,
) -> impl Iterator<Item = i64> + 's {
    let others = scenario
        .obstacles
        .iter()
        .filter(move |o| {
            matches!(o.role, ObstacleRole::Static | ObstacleRole::Dynamic) && o.id != itself
        })
        .filter(move |o| !o.is_occupancy_at(step));
    let way = before.map(|before| Way::new(before, *body));
    let on_the_way = move |other: &Obstacle, there: Placed<'_>| {
        let before = other.placed_at(step.checked_sub(1)?)?;
        let touch = way?.first_touch(&driven_way(before, there, scenario.dt())?)?;
        (touch > 0.0).then_some(touch)
    };
    let bodies = others.filter(move |o| {
        o.placed_at(step)
            .is_some_and(|p| touch(body, &p) || on_the_way(o, p).is_some())
    });
    let regions = regions.overlapped(body, step);
    bodies
        .map(|o| o.id)
        .chain(regions.filter(move |id| *id != itself))
}

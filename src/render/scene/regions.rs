//! Regions of the world: goals, buildings and the like, and where an obstacle may be.

use super::{Basemap, GoalArea, MapRequest, Viewport};
use nearmiss_base::geometry::{Point, Shape};
use nearmiss_scene::scenario::{ObstacleRole, Prediction};

/// What a region is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RegionKind {
    /// What stands beside the road at all times.
    Environment,
    /// Where an obstacle may be at the step.
    Occupancy,
}

/// A region of the world.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// What it is.
    pub kind: RegionKind,
    /// Its obstacle's place among those that are pointed out.
    pub highlighted: Option<usize>,
    /// Its outlines that are seen, each a ring (not closed).
    pub rings: Vec<Vec<Point>>,
}

impl GoalArea {
    pub(super) fn is_seen(&self, basemap: &Basemap, viewport: &Viewport) -> bool {
        match self {
            Self::Lanelet(place) => viewport.sees(&basemap.surfaces[*place].bounds),
            Self::Region(rings) => viewport.sees_any(rings.iter().flatten()),
            Self::Point(at) => viewport.sees_point(at),
        }
    }
}

/// What stands for ever, and where phantom obstacles and those with occupancy sets may be.
pub(super) fn seen(request: &MapRequest<'_>) -> Vec<Region> {
    let mut found = Vec::new();
    for obstacle in &request.subject.scenario.obstacles {
        let highlighted = request.place(obstacle.id);
        let mut add = |kind, shape: &Shape| {
            let mut rings = shape.outlines();
            rings.retain(|ring| request.viewport.sees_any(ring));
            found.extend((!rings.is_empty()).then_some(Region {
                kind,
                highlighted,
                rings,
            }));
        };
        if obstacle.role == ObstacleRole::Environment
            && let Some(body) = &obstacle.footprint
        {
            add(RegionKind::Environment, body.shape());
        }
        if let Prediction::Occupancies(occupancies) = &obstacle.prediction {
            let step = request.step;
            let now = |from, to| (from..=to).contains(&step);
            let now = occupancies.iter().filter(|o| now(o.time.from, o.time.to));
            now.for_each(|occupancy| add(RegionKind::Occupancy, &occupancy.region));
        }
    }
    found
}

//! Where along the route, and when, a goal is reached.

use nearmiss_base::geometry::{Footprint, Pose, ReferencePath};
use nearmiss_scene::scenario::{Destination, PlanningProblem, Position, Route, Scenario};

/// The stretch of the path on which the goal is reached, and the step until which it has to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// Beginning of the stretch, metres along the path; with a margin.
    pub from: f64,
    /// End of the stretch, metres along the path; with a margin.
    pub to: f64,
    /// The last time step that counts.
    pub step: i64,
}

/// The distance between places along the path that are asked whether they are in the goal, metres.
const SPACING: f64 = 0.5;

/// How far inside the goal is aimed at, where it is long enough, and what is kept from its end, metres.
const INSIDE: f64 = 8.0;
const MARGIN: f64 = 3.0;

impl Arrival {
    /// Of the goal that `route` leads to; nothing where no goal says where.
    #[must_use]
    pub fn new(
        scenario: &Scenario,
        problem: &PlanningProblem,
        route: &Route,
        path: &ReferencePath,
    ) -> Option<Self> {
        let Destination::Goal(place) = route.destination else {
            return None;
        };
        let goal = problem.goals.get(place)?;
        let regions: Vec<Footprint> = goal
            .positions
            .iter()
            .filter_map(|p| match p {
                Position::Region(shape) => Footprint::new(shape.clone()).ok(),
                _ => None,
            })
            .collect();
        let lanelets = goal.lanelets();
        let origin = Pose::new(0.0, 0.0, 0.0);
        let inside = |s: f64| {
            let p = path.pose_at(s).position;
            regions.iter().any(|r| r.at(origin).holds(&p))
                || !lanelets.is_empty()
                    && scenario
                        .network
                        .lanelets_at(&p)
                        .iter()
                        .any(|id| lanelets.contains(id))
        };
        let last = path.project(&route.path.at(route.end).position).ok()?.s;
        let start = path.project(&route.path.at(route.start).position).ok()?.s;
        // The route ends where the goal is reached at the latest; on the smooth path that may be just outside.
        let ends = [0.0, 0.25, SPACING, 2.0 * SPACING, 4.0 * SPACING].map(|back| last - back);
        let to = ends.into_iter().find(|&s| inside(s)).unwrap_or(last);
        let mut from = to;
        while from - SPACING > start && inside(from - SPACING) {
            from -= SPACING;
        }
        let third = (to - from) / 3.0;
        Some(Self {
            from: from + INSIDE.min(third),
            to: to - MARGIN.min(third),
            step: goal.time.to,
        })
    }
}

//! What lies below everything: surfaces, borders, stop lines and goals, built once a scenario; regions of the world.

use std::collections::HashSet;

use nearmiss_base::geometry::{Bounds, Point, Polyline, Shape};
use nearmiss_scene::scenario::{
    Bound, Lanelet, LaneletType, LineMarking, ObstacleRole, Position, Prediction, Scenario,
};

use super::borders::{Border, DrivenSurfaces, borders};
use super::{MapRequest, Viewport};

/// Width of a stripe of a crossing and of the gap beside it, metres.
pub const STRIPE: f64 = 0.5;
/// Metres between the points along the middle of a lane at which it may be crossed.
const MIDDLES_APART: f64 = 2.0;
/// Lines across a surface at most.
const MOST_LINES: f64 = 2000.0;

/// The part of a map that does not depend on time. Lengths are metres in the world.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Basemap {
    /// A surface for each lanelet, in the network's order.
    pub surfaces: Vec<Surface>,
    /// What can be driven on beside the lanelets.
    pub areas: Vec<DrivableArea>,
    /// Borders of lanes, each once though neighbours share it: painted ones, then those of which nothing is said.
    pub borders: Vec<Border>,
    /// Lines to stop at.
    pub stop_lines: Vec<StopLine>,
    /// Regions to reach, of all planning problems.
    pub goals: Vec<GoalArea>,
    /// Where each light of the network stands.
    pub(super) lights: Vec<Option<Point>>,
}

/// What a surface is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfaceKind {
    /// Ordinary traffic.
    Driving,
    /// Buses.
    Bus,
    /// Bicycles.
    Bicycle,
    /// Pedestrians beside the road.
    Sidewalk,
    /// Pedestrians across the road.
    Crossing,
    /// Emergencies.
    Shoulder,
    /// Standing vehicles.
    Parking,
    /// No traffic: the edge of the road.
    Verge,
}

/// The surface of a lanelet.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// The lanelet's id.
    pub lanelet: i64,
    /// What it is for.
    pub kind: SurfaceKind,
    /// Its outline, not closed.
    pub ring: Vec<Point>,
    /// How many of its points are the left edge; the others are the right one.
    pub(super) left_points: usize,
    /// The box around it.
    pub bounds: Bounds,
    /// Whether other lanes cross it, as within a junction.
    pub is_crossed: bool,
    edges: Option<(Polyline, Polyline)>,
}

/// A drivable area beside the lanelets, or around them.
#[derive(Debug, Clone, PartialEq)]
pub struct DrivableArea {
    /// Its outline, not closed.
    pub ring: Vec<Point>,
    /// The box around it.
    pub bounds: Bounds,
}

/// A line to stop at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopLine {
    /// Its ends.
    pub ends: [Point; 2],
    /// Whether it is dashed.
    pub dashed: bool,
}

/// A region to reach.
#[derive(Debug, Clone, PartialEq)]
pub enum GoalArea {
    /// A lanelet, by the place of its surface.
    Lanelet(usize),
    /// A region, by its outlines.
    Region(Vec<Vec<Point>>),
    /// A point.
    Point(Point),
}

impl Basemap {
    /// That of a scenario.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        let network = &scenario.network;
        let lanelets = network.lanelets.iter().enumerate();
        let mut surfaces: Vec<Surface> = lanelets
            .map(|(place, lanelet)| Surface::new(lanelet, network.bounds_of(place)))
            .collect();
        let driven = DrivenSurfaces::new(&surfaces);
        let borders = borders(&network.lanelets, &driven);
        let crossed = surfaces.iter().map(|s| s.is_crossed_by(&driven));
        let crossed: Vec<bool> = crossed.collect();
        for (surface, crossed) in surfaces.iter_mut().zip(crossed) {
            surface.is_crossed = crossed;
        }
        let area = |ring: &Vec<Point>| {
            Some(DrivableArea {
                bounds: Bounds::from_points(ring)?,
                ring: ring.clone(),
            })
        };
        Self {
            areas: network.areas.iter().filter_map(area).collect(),
            borders,
            surfaces,
            stop_lines: network
                .lanelets
                .iter()
                .filter_map(StopLine::from_lanelet)
                .collect(),
            goals: goals(scenario),
            lights: network
                .lights
                .iter()
                .map(|light| network.position_of(light))
                .collect(),
        }
    }
}

impl Basemap {
    /// Where each light of the network stands, in its order.
    pub(crate) fn places_of_lights(&self) -> impl Iterator<Item = Option<Point>> {
        self.lights.iter().copied()
    }
}

impl SurfaceKind {
    fn from_lanelet(lanelet: &Lanelet) -> Self {
        use LaneletType as T;
        let kinds = [
            (T::Crosswalk, Self::Crossing),
            (T::Sidewalk, Self::Sidewalk),
            (T::BicycleLane, Self::Bicycle),
            (T::BusLane, Self::Bus),
            (T::BusStop, Self::Bus),
            (T::Parking, Self::Parking),
            (T::Shoulder, Self::Shoulder),
            (T::Border, Self::Verge),
        ];
        let known = kinds.iter().find(|(t, _)| lanelet.types.contains(t));
        known.map_or(Self::Driving, |(_, kind)| *kind)
    }
}

impl Surface {
    pub(super) fn new(lanelet: &Lanelet, bounds: Bounds) -> Self {
        let line = |bound: &Bound| Polyline::new(bound.points.iter().copied());
        Self {
            lanelet: lanelet.id,
            kind: SurfaceKind::from_lanelet(lanelet),
            ring: lanelet.ring(),
            left_points: lanelet.left.points.len(),
            bounds,
            is_crossed: false,
            edges: line(&lanelet.left).zip(line(&lanelet.right)),
        }
    }

    /// The points of both edges at a part of their lengths, 0 to 1.
    fn line_at(edges: &(Polyline, Polyline), part: f64) -> (Point, Point) {
        let at = |edge: &Polyline| edge.pose_at(part * edge.length()).position;
        (at(&edges.0), at(&edges.1))
    }

    /// Whether it is driven on and its middle runs through other lanes.
    pub(super) fn is_crossed_by(&self, surfaces: &DrivenSurfaces<'_>) -> bool {
        let driven = [SurfaceKind::Driving, SurfaceKind::Bus, SurfaceKind::Bicycle];
        if !driven.contains(&self.kind) {
            return false;
        }
        let middles = self
            .across(MIDDLES_APART, 0.5)
            .map(|(left, right)| nalgebra::center(&left, &right));
        surfaces.are_crossed_by(&middles.collect::<Vec<_>>(), Some(self.lanelet))
    }

    /// Lines from the left to the right edge, about `every` metres; the first one after the part `first` of that.
    pub fn across(&self, every: f64, first: f64) -> impl Iterator<Item = (Point, Point)> + '_ {
        self.edges.iter().flat_map(move |edges| {
            let length = edges.0.length().max(edges.1.length());
            let count = (length / every).ceil().clamp(1.0, MOST_LINES);
            let parts = (0..=count as usize)
                .map(move |i| (i as f64 + first) / count)
                .take_while(|part| *part <= 1.0);
            parts.map(|part| Self::line_at(edges, part))
        })
    }

    /// The stripes of a crossing, about this wide, each a ring.
    #[must_use]
    pub fn stripes(&self, wide: f64) -> Vec<[Point; 4]> {
        let Some(edges) = &self.edges else {
            return Vec::new();
        };
        let length = edges.0.length().max(edges.1.length());
        let count = (length / (2.0 * wide)).round().clamp(1.0, 500.0);
        let stripe = |i: usize| {
            let at = |quarter: f64| Self::line_at(edges, (i as f64 + quarter) / count);
            let ((a, d), (b, c)) = (at(0.25), at(0.75));
            [a, b, c, d]
        };
        (0..count as usize).map(stripe).collect()
    }
}

impl StopLine {
    fn from_lanelet(lanelet: &Lanelet) -> Option<Self> {
        let (from, to) = lanelet.stop_line_ends()?;
        let marking = lanelet.stop_line.as_ref()?.marking;
        Some(Self {
            ends: [from, to],
            dashed: matches!(marking, LineMarking::Dashed | LineMarking::BroadDashed),
        })
    }
}

fn goals(scenario: &Scenario) -> Vec<GoalArea> {
    let network = &scenario.network;
    let (mut found, mut known) = (Vec::new(), HashSet::new());
    let goals = scenario.planning_problems.iter().flat_map(|p| &p.goals);
    for position in goals.flat_map(|goal| &goal.positions) {
        match position {
            Position::Region(region) => found.push(GoalArea::Region(region.outlines())),
            Position::Point(at) => found.push(GoalArea::Point(*at)),
            Position::Lanelets(ids) => {
                let places = ids.iter().filter_map(|id| network.place(*id));
                let new = places.filter(|place| known.insert(*place));
                found.extend(new.map(GoalArea::Lanelet));
            }
        }
    }
    found
}

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

//! Bodies at a step: outlines, fronts, who matters how much.

use super::{MapRequest, Owner, Role};
use nearmiss_base::geometry::{Bounds, Footprint, Point};
use nearmiss_scene::scenario::{
    EgoSource, Motion, Obstacle, ObstacleRole, ObstacleType, SignalState,
};

/// Up to this risk score an obstacle is in danger of a collision, and risky.
const DANGER: f64 = 1.0;
const RISKY: f64 = 2.0;

/// How much a body matters, the least first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Importance {
    /// Any other.
    Other,
    /// It is risky.
    Risky,
    /// It is in danger of a collision.
    Danger,
    /// It is pointed out.
    Highlighted,
    /// It is the ego.
    Ego,
}

/// A body at a step.
#[derive(Debug, Clone)]
pub struct Body<'a> {
    /// Whose it is.
    pub owner: Owner,
    /// What it is shown as.
    pub role: Role,
    /// Its place among those that are pointed out.
    pub highlighted: Option<usize>,
    /// How much it matters.
    pub importance: Importance,
    /// How far it is from the ego, metres, where that is measured.
    pub distance: Option<f64>,
    /// Whether it never moves.
    pub stands: bool,
    /// Whether it drives or walks forwards; walls and posts do not.
    pub has_front: bool,
    /// Outlines in the world, one ring (not closed) a part.
    pub rings: Vec<Vec<Point>>,
    /// The region that it covers, in its own frame.
    pub footprint: &'a Footprint,
    /// Its pose and velocity.
    pub motion: &'a Motion,
    /// From its rear to its front, metres ahead of its position.
    pub along: (f64, f64),
    /// From its right to its left side, metres to the left of its position.
    pub across: (f64, f64),
    /// What it signals: brake lights, indicators and so on; `None` if the file does not say.
    pub signals: Option<&'a SignalState>,
}

impl Body<'_> {
    /// The middle of the box around it.
    #[must_use]
    pub fn center(&self) -> Point {
        let bounds = Bounds::from_points(self.rings.iter().flatten());
        bounds.map_or(self.motion.pose.position, |bounds| bounds.center())
    }

    /// A point of the body's frame in the world: so many metres ahead of its position, and to the left of it.
    #[must_use]
    pub fn point(&self, ahead: f64, left: f64) -> Point {
        self.motion.pose.to_world(&Point::new(ahead, left))
    }

    /// The place at a part of its length, from 0 (the rear) to 1 (the front), metres ahead of its position.
    #[must_use]
    pub fn part(&self, part: f64) -> f64 {
        let (rear, front) = self.along;
        rear + (front - rear) * part
    }

    /// Its length along its heading, metres.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.along.1 - self.along.0
    }
}

/// Everyone but the ego that is seen, those who matter most last.
pub(super) fn others<'a>(request: &MapRequest<'a>) -> Vec<Body<'a>> {
    let obstacles = request.subject.others();
    let mut found: Vec<Body<'a>> = obstacles.filter_map(|o| obstacle(request, o)).collect();
    found.sort_by_key(|body| body.importance);
    found
}

fn obstacle<'a>(request: &MapRequest<'a>, obstacle: &'a Obstacle) -> Option<Body<'a>> {
    // Drawn as a region.
    if obstacle.is_occupancy_at(request.step) {
        return None;
    }
    let motion = obstacle.motion_at(request.step)?;
    let footprint = obstacle.footprint_at(request.step)?;
    let value = |measure| {
        let series = request.series?;
        series.at(measure, obstacle.id, request.step).value()
    };
    let risk: Option<f64> = value("risk");
    let highlighted = request.place(obstacle.id);
    let stands = obstacle.role == ObstacleRole::Static;
    let (importance, role) = match (risk, highlighted) {
        (Some(risk), _) if risk <= DANGER => (Importance::Danger, Role::Danger),
        (_, Some(place)) => (Importance::Highlighted, Role::Highlighted(place)),
        (Some(risk), _) if risk <= RISKY => (Importance::Risky, Role::Warning),
        _ if stands => (Importance::Other, Role::StaticObstacle),
        _ => (Importance::Other, role_of(obstacle.kind)),
    };
    let variation = request.variations.of(obstacle.id);
    let attacks = variation.is_some_and(|both| both.shows_changed);
    Some(Body {
        owner: Owner::Obstacle(obstacle.id),
        role: match request.variations.place_of(obstacle.id) {
            Some(place) if attacks => Role::Attacker(place),
            _ => role,
        },
        highlighted,
        importance,
        distance: value("distance"),
        stands,
        has_front: has_front(obstacle.kind),
        signals: obstacle.signals_at(request.step),
        ..body(request, footprint, motion)?
    })
}

/// The ego, where it is seen.
pub(super) fn ego<'a>(request: &MapRequest<'a>) -> Option<Body<'a>> {
    let scene = request.subject.scene?;
    let motion = scene.ego.track.at(request.step)?;
    let obstacle = match scene.ego.source {
        EgoSource::Obstacle(id) => scene.scenario.obstacle(id),
        _ => None,
    };
    Some(Body {
        signals: obstacle.and_then(|o| o.signals_at(request.step)),
        ..body(request, scene.ego_footprint_at(request.step), motion)?
    })
}

fn body<'a>(
    request: &MapRequest<'a>,
    footprint: &'a Footprint,
    motion: &'a Motion,
) -> Option<Body<'a>> {
    let here = motion.pose.position;
    if !request.viewport.sees_around(&here, footprint.reach()) {
        return None;
    }
    let placed = footprint.at(motion.pose);
    Some(Body {
        owner: Owner::Ego,
        role: Role::Ego,
        highlighted: None,
        importance: Importance::Ego,
        distance: None,
        stands: false,
        has_front: true,
        rings: placed.outlines(),
        footprint,
        motion,
        along: placed.extent(&here, &motion.pose.forward()),
        across: placed.extent(&here, &motion.pose.left()),
        signals: None,
    })
}

fn role_of(kind: ObstacleType) -> Role {
    use ObstacleType::{Bicycle, Bus, Motorcycle, Pedestrian, Train, Truck};
    match kind {
        Truck | Bus | Train => Role::Truck,
        Bicycle | Motorcycle => Role::Cycle,
        Pedestrian => Role::Pedestrian,
        _ => Role::Obstacle,
    }
}

fn has_front(kind: ObstacleType) -> bool {
    use ObstacleType::{Building, ConstructionZone, MedianStrip, Pillar, RoadBoundary};
    !matches!(
        kind,
        Building | ConstructionZone | MedianStrip | Pillar | RoadBoundary
    )
}

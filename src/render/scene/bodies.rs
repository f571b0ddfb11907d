//! Bodies at a step: outlines, fronts, who matters how much; where they touch, were and go.

use nearmiss_base::geometry::{Bounds, Footprint, Point, contains};
use nearmiss_scene::metrics;
use nearmiss_scene::scenario::{
    EgoSource, Motion, Obstacle, ObstacleRole, ObstacleType, SignalState, Track,
};

use super::{MapRequest, Owner, Role, Viewport};

/// Up to this risk score an obstacle is in danger of a collision, and risky.
const DANGER: f64 = 1.0;
const RISKY: f64 = 2.0;

/// Characters along a body that is large enough to show its heading.
const TINY: f64 = 2.5;
/// Characters along a body whose outline of dots shows what it is.
const SMALL: f64 = 4.5;
/// Lengths of cars, metres, and the one that all of them are taken for.
const CARS: std::ops::Range<f64> = 3.0..6.0;
const CAR: f64 = 4.5;

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

    /// Whether it is so small on a map of characters this wide, metres, that an arrow stands for it. All cars are taken
    /// for equally long.
    #[must_use]
    pub fn is_tiny(&self, cell: f64) -> bool {
        self.reach() < TINY * cell
    }

    /// Whether an outline of dots is too coarse to show its shape, where a character is so many metres wide.
    #[must_use]
    pub fn is_small(&self, cell: f64) -> bool {
        self.reach() < SMALL * cell
    }

    fn reach(&self) -> f64 {
        match self.length() {
            length if CARS.contains(&length) => CAR,
            _ => 2.0 * self.footprint.reach(),
        }
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
    let variation = request.variations.get(obstacle.id);
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

/// Whether such a thing drives or walks forwards.
pub fn has_front(kind: ObstacleType) -> bool {
    use ObstacleType::{Building, ConstructionZone, MedianStrip, Pillar, RoadBoundary};
    !matches!(
        kind,
        Building | ConstructionZone | MedianStrip | Pillar | RoadBoundary
    )
}

/// A place where the ego touches another body.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// The other's id.
    pub obstacle: i64,
    /// The middle of what both cover.
    pub at: Point,
    /// The corners of what both cover, a ring (not closed); of bodies that only touch, the two nearest corners.
    pub overlap: Vec<Point>,
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
        let overlap = between(&ego.outlines().concat(), &placed.outlines().concat());
        Some(Contact {
            obstacle: other.obstacle.id,
            at: middle(&overlap),
            overlap,
            is_possible: other.obstacle.is_occupancy_at(step),
        })
    });
    touching.collect()
}

/// What two outlines have in common, by their corners and crossings, around its middle; of bodies that only touch, the
/// nearest of their corners.
fn between(a: &[Point], b: &[Point]) -> Vec<Point> {
    let mut common: Vec<Point> = a.iter().filter(|p| contains(b, p)).copied().collect();
    common.extend(b.iter().filter(|p| contains(a, p)));
    common.extend(crossings(a, b));
    if common.is_empty() {
        common.extend(nearest(a, b));
    }
    let middle = middle(&common);
    let angle = |p: &Point| (p.y - middle.y).atan2(p.x - middle.x);
    common.sort_by(|p, q| angle(p).total_cmp(&angle(q)));
    common
}

fn middle(points: &[Point]) -> Point {
    let count = points.len().max(1) as f64;
    let sum = points.iter().fold(Point::origin(), |s, p| s + p.coords);
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

/// How much of a recorded motion is shown, seconds; `None` for all of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrailSpan {
    /// Of the past.
    pub past: Option<f64>,
    /// Of the recorded future.
    pub future: Option<f64>,
}

impl TrailSpan {
    /// All of it.
    pub const WHOLE: Self = Self {
        past: None,
        future: None,
    };
}

/// A recorded motion around a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trail<'a> {
    /// Whose.
    pub owner: Owner,
    /// Its owner's place among those that are pointed out.
    pub highlighted: Option<usize>,
    /// Steps and motions up to the step and with it.
    pub past: &'a [(i64, Motion)],
    /// The same from the step on.
    pub future: &'a [(i64, Motion)],
}

impl<'a> Trail<'a> {
    fn new(track: &'a Track, request: &MapRequest<'_>, owner: Owner, span: TrailSpan) -> Self {
        let (step, dt) = (request.step, request.subject.scenario.dt());
        let steps = |seconds: f64| (seconds / dt).ceil() as i64;
        let from = span
            .past
            .map_or(i64::MIN, |s| step.saturating_sub(steps(s)));
        let to = span
            .future
            .map_or(i64::MAX, |s| step.saturating_add(steps(s)));
        Self {
            owner,
            highlighted: match owner {
                Owner::Ego => None,
                Owner::Obstacle(id) => request.place(id),
            },
            past: track.during(&(from..=step)),
            future: track.during(&(step..=to)),
        }
    }

    fn is_seen(&self, viewport: &Viewport) -> bool {
        let all = self.past.iter().chain(self.future);
        let bounds = Bounds::from_points(all.map(|(_, motion)| &motion.pose.position));
        bounds.is_some_and(|bounds| viewport.sees(&bounds))
    }
}

/// The positions of recorded motions.
pub(super) fn positions(motions: &[(i64, Motion)]) -> Vec<Point> {
    motions.iter().map(|(_, m)| m.pose.position).collect()
}

/// Trails that are seen, the ego's last.
pub(super) fn seen<'a>(request: &MapRequest<'a>) -> Vec<Trail<'a>> {
    let [other, highlighted] = request.trails;
    let others = request.subject.others().map(|obstacle| {
        let span = match request.place(obstacle.id) {
            Some(_) => highlighted,
            None => other,
        };
        Trail::new(
            obstacle.track(),
            request,
            Owner::Obstacle(obstacle.id),
            span,
        )
    });
    let ego = request
        .subject
        .scene
        .map(|scene| Trail::new(&scene.ego.track, request, Owner::Ego, TrailSpan::WHOLE));
    // Who is still to come has no trail, unless all of it is shown.
    let others = others.filter(|trail| trail.highlighted.is_some() || !trail.past.is_empty());
    let all = others.chain(ego);
    all.filter(|trail| trail.is_seen(&request.viewport))
        .collect()
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
            middle(&between(&square(0.0, 0.0), &square(3.0, 3.0))),
            Point::new(3.5, 3.5)
        ));
        // A bar across: no corner of either lies in the other.
        let bar = ring([(-2.0, 1.0), (6.0, 1.0), (6.0, 2.0), (-2.0, 2.0)]);
        let overlap = between(&square(0.0, 0.0), &bar);
        assert!(near(middle(&overlap), Point::new(2.0, 1.5)));
        let areas = overlap.iter().zip(overlap.iter().cycle().skip(1));
        let twice: f64 = areas.map(|(p, q)| p.coords.perp(&q.coords)).sum();
        assert!((twice - 8.0).abs() < 1e-9, "4 m by 1 m, around it");
    }
}

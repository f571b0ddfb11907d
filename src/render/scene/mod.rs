//! The map at a step as a list of things with roles, in world coordinates: what every backend draws.
//!
//! A [`Basemap`] is built once a scenario; a [`MapScene`] takes from it, and from the traffic at a step, what a
//! [`Viewport`] sees. Lengths are metres, angles radians. Nothing here knows colours, points of a page or cells: a
//! backend maps [`Role`]s to its palette and leaves out what is too small for its resolution.

mod bodies;
mod borders;
mod road;

use nearmiss_base::geometry::{Bounds, Point, Pose, Vector};
use nearmiss_scene::metrics::Series;
use nearmiss_scene::scenario::{Sign, SignalColor};

use super::view::{Subject, Variation, Variations};
pub(crate) use bodies::has_front;
use bodies::positions;

pub use bodies::{Body, Contact, Importance, Trail, TrailSpan};
pub use borders::{Border, DASH, MarkingLine, Paint, offset};
pub use road::{
    Basemap, DrivableArea, GoalArea, Region, RegionKind, STRIPE, StopLine, Surface, SurfaceKind,
};

/// Who or what a thing on the map is about: a backend has a colour for each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The ego.
    Ego,
    /// A moving obstacle.
    Obstacle,
    /// A standing obstacle.
    StaticObstacle,
    /// A truck, a bus or a train.
    Truck,
    /// A bicycle or a motorcycle.
    Cycle,
    /// A pedestrian.
    Pedestrian,
    /// An obstacle that is pointed out, by its place among them.
    Highlighted(usize),
    /// An obstacle in danger of a collision.
    Danger,
    /// A risky obstacle.
    Warning,
    /// An attacker of a variant, as it was changed, by its place among them.
    Attacker(usize),
    /// The attacker of a variant, as it was recorded.
    Recorded,
    /// The recorded ego beside a planned one.
    RecordedEgo,
    /// Where a participant is predicted to go.
    Prediction,
    /// Where it goes at constant velocity.
    ConstantVelocity,
    /// A body that a planner expects.
    PredictedBody,
    /// A planner's candidate that can be driven.
    Feasible,
    /// A planner's candidate that cannot.
    Rejected,
    /// The measuring tape.
    Tape,
}

/// Whom a thing on the map belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Owner {
    /// The ego.
    Ego,
    /// An obstacle, by its id.
    Obstacle(i64),
}

/// What a map is asked to show.
#[derive(Debug, Clone, Copy)]
pub struct MapRequest<'a> {
    /// The scenario, with its ego if it has one.
    pub subject: Subject<'a>,
    /// The part that does not depend on time.
    pub basemap: &'a Basemap,
    /// The time step.
    pub step: i64,
    /// The part of the world that is seen.
    pub viewport: Viewport,
    /// Obstacles that are pointed out.
    pub highlighted: &'a [i64],
    /// Distances and risks of obstacles, where bodies show them.
    pub series: Option<&'a Series>,
    /// Both motions of a variant's attackers.
    pub variations: Variations<'a>,
    /// How much of the motion of others, and of those pointed out, is shown; of the ego's, all.
    pub trails: [TrailSpan; 2],
}

/// What is seen of a scenario at a step.
#[derive(Debug, Clone)]
pub struct MapScene<'a> {
    /// All that does not depend on time, seen or not.
    pub basemap: &'a Basemap,
    /// Surfaces of lanelets.
    pub surfaces: Vec<&'a Surface>,
    /// Drivable areas beside them.
    pub areas: Vec<&'a DrivableArea>,
    /// Borders of lanes.
    pub borders: Vec<&'a Border>,
    /// Lines to stop at.
    pub stop_lines: Vec<&'a StopLine>,
    /// Regions to reach.
    pub goals: Vec<&'a GoalArea>,
    /// Traffic lights.
    pub lights: Vec<Light>,
    /// Traffic signs.
    pub signs: Vec<Post<'a>>,
    /// Buildings and the like, and where an obstacle may be.
    pub regions: Vec<Region>,
    /// Where obstacles and, last, the ego were and will be.
    pub trails: Vec<Trail<'a>>,
    /// Both motions of a variant's attackers.
    pub variation: Vec<Overlay>,
    /// Everyone but the ego, those who matter most last.
    pub bodies: Vec<Body<'a>>,
    /// The ego.
    pub ego: Option<Body<'a>>,
    attackers: Vec<i64>,
    /// Where the ego touches another body.
    pub contacts: Vec<Contact>,
    /// Whether distances to the ego are measured.
    measured: bool,
    /// What is in the middle.
    middle: Point,
    /// Further lines and outlines just above the road, which the caller adds.
    pub underlays: Vec<Overlay>,
    /// The same above trails and below bodies.
    pub overlays: Vec<Overlay>,
    /// The same above everything.
    pub top: Vec<Overlay>,
}

/// A traffic light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Where it stands.
    pub at: Point,
    /// What it shows at the step.
    pub color: SignalColor,
}

/// A traffic sign on its post.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Post<'a> {
    /// Where it stands.
    pub at: Point,
    /// The sign.
    pub sign: &'a Sign,
}

impl<'a> MapScene<'a> {
    /// What is seen.
    #[must_use]
    pub fn new(request: &MapRequest<'a>) -> Self {
        let MapRequest {
            basemap, viewport, ..
        } = request;
        let surfaces = basemap.surfaces.iter();
        let areas = basemap.areas.iter();
        let borders = basemap.borders.iter();
        let stop_lines = basemap.stop_lines.iter();
        let goals = basemap.goals.iter();
        Self {
            basemap,
            surfaces: surfaces.filter(|s| viewport.sees(&s.bounds)).collect(),
            areas: areas.filter(|a| viewport.sees(&a.bounds)).collect(),
            borders: borders.filter(|b| viewport.sees(&b.bounds)).collect(),
            stop_lines: stop_lines.filter(|l| viewport.sees_any(&l.ends)).collect(),
            goals: goals.filter(|g| g.is_seen(basemap, viewport)).collect(),
            lights: request.lights(),
            signs: request.signs(),
            regions: road::seen(request),
            trails: bodies::seen(request),
            variation: of_variation(request),
            bodies: bodies::others(request),
            ego: bodies::ego(request),
            attackers: request
                .variations
                .iter()
                .map(|both| both.changed.id)
                .collect(),
            contacts: request.contacts(),
            measured: request.series.is_some(),
            middle: viewport.frame.position,
            underlays: Vec::new(),
            overlays: Vec::new(),
            top: Vec::new(),
        }
    }
}

/// Obstacles that are named on a map at most, beside those that are pointed out.
pub const MAX_NAMED: usize = 9;

impl<'a> MapScene<'a> {
    /// Whether an owner is an attacker of a variant, changed or not.
    #[must_use]
    pub fn is_attacker(&self, owner: Owner) -> bool {
        self.attacker_place(owner).is_some()
    }

    /// The place of an owner among the attackers of a variant.
    #[must_use]
    pub fn attacker_place(&self, owner: Owner) -> Option<usize> {
        let Owner::Obstacle(owner) = owner else {
            return None;
        };
        self.attackers.iter().position(|id| *id == owner)
    }

    /// Hollow bodies that have names.
    pub fn hollow(&self) -> impl Iterator<Item = (&str, &Outline)> {
        let overlays = self.overlays.iter().chain(&self.variation);
        overlays.filter_map(|overlay| match overlay {
            Overlay::Outline(outline) => Some((outline.name.as_deref()?, outline)),
            Overlay::Path(_) => None,
        })
    }

    /// Who is named, the most important first: the ego, those pointed out, a variant's attacker, and `most` of those
    /// nearest to the ego, or to the middle of the map where there is none.
    #[must_use]
    pub fn named(&self, most: usize) -> Vec<&Body<'a>> {
        let middle = self.ego.as_ref().map_or(self.middle, Body::center);
        let mut others: Vec<(usize, f64, &Body<'a>)> = Vec::new();
        for body in &self.bodies {
            let attacker = self.is_attacker(body.owner).then_some(usize::MAX - 1);
            let place = body.highlighted.or(attacker);
            let far = if self.measured {
                body.distance
            } else {
                Some((body.center() - middle).norm())
            };
            if place.is_some() || far.is_some() {
                let far = far.unwrap_or(f64::MAX);
                others.push((place.unwrap_or(usize::MAX), far, body));
            }
        }
        others.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let first = others.partition_point(|(place, ..)| *place < usize::MAX);
        let others = others.into_iter().take(first + most);
        self.ego
            .iter()
            .chain(others.map(|(.., body)| body))
            .collect()
    }
}

impl<'a> MapRequest<'a> {
    /// The place of an obstacle among those that are pointed out.
    fn place(&self, id: i64) -> Option<usize> {
        self.highlighted.iter().position(|&other| other == id)
    }

    /// Every contact of the ego at the step, seen or not.
    pub(crate) fn contacts(&self) -> Vec<Contact> {
        bodies::all(self)
    }

    fn lights(&self) -> Vec<Light> {
        let lights = self
            .subject
            .scenario
            .network
            .lights
            .iter()
            .zip(&self.basemap.lights)
            .filter_map(|(light, at)| {
                let at = at.filter(|at| self.viewport.sees_point(at))?;
                let color = light.color_at(self.step);
                Some(Light { at, color })
            });
        lights.collect()
    }

    fn signs(&self) -> Vec<Post<'a>> {
        let signs = self
            .subject
            .scenario
            .network
            .signs
            .iter()
            .filter_map(|sign| {
                let at = sign.position.filter(|at| self.viewport.sees_point(at))?;
                Some(Post { at, sign })
            });
        signs.collect()
    }
}

/// A rectangle of the world, turned so that what lies ahead of its frame is up on the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewport {
    /// What is in the middle, and the direction that is up.
    pub frame: Pose,
    /// Half of its width and of its height, metres.
    pub half: (f64, f64),
    /// Up and left on the map, as directions of the world.
    axes: (Vector, Vector),
}

impl Viewport {
    /// The rectangle around a frame; `half` its width and half its height, metres.
    #[must_use]
    pub fn new(frame: Pose, half: (f64, f64)) -> Self {
        Self {
            frame,
            half,
            axes: (frame.forward(), frame.left()),
        }
    }

    /// Where a point is, metres from the middle: x to the right, y up.
    #[must_use]
    pub fn at(&self, p: &Point) -> (f64, f64) {
        let turned = self.turned(&(p - self.frame.position));
        (turned.x, turned.y)
    }

    /// A direction of the world on the map: x to the right, y up.
    #[must_use]
    pub fn turned(&self, v: &Vector) -> Vector {
        Vector::new(-v.dot(&self.axes.1), v.dot(&self.axes.0))
    }

    /// Whether something within `bounds` may be seen.
    #[must_use]
    pub fn sees(&self, bounds: &Bounds) -> bool {
        let half = (bounds.max - bounds.min) / 2.0;
        let reach = |axis: &Vector| (half.x * axis.x).abs() + (half.y * axis.y).abs();
        let (x, y) = self.at(&bounds.center());
        x.abs() <= self.half.0 + reach(&self.axes.1) && y.abs() <= self.half.1 + reach(&self.axes.0)
    }

    /// Whether something around these points may be seen; nothing is around none.
    pub fn sees_any<'a>(&self, points: impl IntoIterator<Item = &'a Point>) -> bool {
        Bounds::from_points(points).is_some_and(|bounds| self.sees(&bounds))
    }

    /// Whether something within `reach` metres of a point may be seen.
    #[must_use]
    pub fn sees_around(&self, p: &Point, reach: f64) -> bool {
        let (x, y) = self.at(p);
        x.abs() <= self.half.0 + reach && y.abs() <= self.half.1 + reach
    }

    /// Whether a point is seen.
    #[must_use]
    pub fn sees_point(&self, p: &Point) -> bool {
        self.sees_around(p, 0.0)
    }
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineStyle {
    /// Unbroken.
    Solid,
    /// Unbroken, and broader than others.
    Thick,
    /// Dashes.
    Dashed,
    /// Single dots.
    Dotted,
}

/// Something drawn over the traffic.
#[derive(Debug, Clone, PartialEq)]
pub enum Overlay {
    /// An open line.
    Path(Path),
    /// A hollow body.
    Outline(Outline),
}

/// An open line.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// What it is.
    pub role: Role,
    /// How it is drawn.
    pub style: LineStyle,
    /// From 0, not seen, to 1.
    pub opacity: f64,
    /// Its points.
    pub points: Vec<Point>,
}

/// A body that is not there now: hollow.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// What it is.
    pub role: Role,
    /// Whether it matters less.
    pub faint: bool,
    /// Its outlines, each a ring (not closed).
    pub rings: Vec<Vec<Point>>,
    /// What it is called, if it has a label.
    pub name: Option<String>,
}

impl Overlay {
    /// An open line.
    #[must_use]
    pub fn path(role: Role, style: LineStyle, points: Vec<Point>) -> Self {
        Self::Path(Path {
            role,
            style,
            opacity: 1.0,
            points,
        })
    }
}

/// The recorded motion of each attacker of a variant dashed, the changed one a thick line, and the body that is not driven in
/// what is shown hollow, where the two are not in one place.
fn of_variation(request: &MapRequest<'_>) -> Vec<Overlay> {
    let all = request.variations.iter().enumerate();
    all.flat_map(|(place, both)| of_attacker(request, place, both))
        .collect()
}

fn of_attacker(request: &MapRequest<'_>, place: usize, both: &Variation<'_>) -> Vec<Overlay> {
    let attacker = Role::Attacker(place);
    let after = both.from..=i64::MAX;
    let way =
        |obstacle: &nearmiss_scene::scenario::Obstacle| positions(obstacle.track().during(&after));
    let mut found = vec![
        Overlay::path(Role::Recorded, LineStyle::Dashed, way(both.recorded)),
        Overlay::path(attacker, LineStyle::Thick, way(both.changed)),
    ];
    let (role, other, word) = if both.shows_changed {
        (Role::Recorded, both.recorded, "recorded")
    } else {
        (attacker, both.changed, "changed")
    };
    if let Some(placed) = other.placed_at(request.step)
        && request.step > both.from
    {
        found.push(Overlay::Outline(Outline {
            role,
            faint: false,
            rings: placed.outlines(),
            name: Some(format!("{} {word}", other.id)),
        }));
    }
    found
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod viewport_tests {
    use super::*;

    #[test]
    fn boxes_are_seen_where_they_reach_into_the_turned_rectangle() {
        let east = Viewport::new(Pose::new(10.0, 0.0, 0.0), (5.0, 20.0));
        // Ahead is up: 20 m to the east are seen, and 5 m to the north.
        assert_eq!(east.at(&Point::new(13.0, 1.0)), (-1.0, 3.0));
        let around = |x: f64, y: f64| Bounds {
            min: Point::new(x - 2.0, y - 1.0),
            max: Point::new(x + 2.0, y + 1.0),
        };
        assert!(east.sees(&around(31.9, 0.0)) && !east.sees(&around(32.1, 0.0)));
        assert!(east.sees(&around(10.0, 5.9)) && !east.sees(&around(10.0, 6.1)));
        let slanted = Viewport::new(Pose::new(0.0, 0.0, 0.6), (5.0, 5.0));
        assert!(slanted.sees(&around(6.0, 2.0)) && !slanted.sees(&around(9.0, 9.0)));
    }
}

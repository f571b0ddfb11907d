//! Collisions: which obstacle touches the ego, and with which side of its body.

use crate::geometry::{Footprint, Placed, Point, Pose, Vector, angle_between};
use crate::scenario::{Obstacle, ObstacleRole, Scenario};

/// A side of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ContactSide {
    /// Front.
    Front,
    /// Rear.
    Rear,
    /// Left side.
    Left,
    /// Right side.
    Right,
}

impl ContactSide {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Rear => "rear",
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

/// The first contact of the ego.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Collision {
    /// The obstacle.
    pub with: i64,
    /// When, in time steps.
    pub step: i64,
    /// The side of the ego that is touched.
    pub ego: ContactSide,
    /// The side of the obstacle that is touched.
    pub other: ContactSide,
    /// Whether the obstacle is a region of an occupancy set there, which it may cover or not.
    pub is_possible: bool,
}

impl std::fmt::Display for Collision {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (ego, other) = (self.ego.name(), self.other.name());
        if self.is_possible {
            return write!(
                f,
                "{} at step {}, a possible contact: the ego's {ego} with its predicted occupancy",
                self.with, self.step
            );
        }
        write!(
            f,
            "{} at step {}: the ego's {ego}, the other's {other}",
            self.with, self.step
        )
    }
}

impl Collision {
    /// The collision of a body with anyone of `scenario` but `without` at a step: exact distance 0. Of several the
    /// first in the file's order; see [`Self::first`].
    #[must_use]
    pub fn at(
        scenario: &Scenario,
        ego: &Placed<'_>,
        step: i64,
        without: Option<i64>,
    ) -> Option<Self> {
        Self::all_at(scenario, ego, step, without).next()
    }

    /// The same for a body that was at `before` a step earlier: of several who are touched, the one that was touched
    /// first on the way from there. The sides are those of the first touch on that way: at the step itself fast bodies
    /// are already in each other, and the front that ran into a rear may seem to touch a side.
    #[must_use]
    pub fn first(
        scenario: &Scenario,
        ego: &Placed<'_>,
        before: Option<Pose>,
        step: i64,
        without: Option<i64>,
    ) -> Option<Self> {
        let mut all: Vec<Self> = Self::all_at(scenario, ego, step, without).collect();
        let Some(before) = before else {
            return all.into_iter().next();
        };
        let swept = |one: &mut Self| {
            let way = (before, ego.pose);
            let touch = scenario
                .obstacle(one.with)
                .and_then(|other| Touch::on(other, ego.footprint, way, step - 1));
            if let Some(touch) = &touch {
                (one.ego, one.other) = touch.sides;
            }
            touch.map_or(1.0, |touch| touch.share)
        };
        let mut all: Vec<(f64, Self)> = { all.iter_mut() }.map(|one| (swept(one), *one)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.first().map(|(_, one)| *one)
    }

    fn all_at<'a>(
        scenario: &'a Scenario,
        ego: &'a Placed<'_>,
        step: i64,
        without: Option<i64>,
    ) -> impl Iterator<Item = Self> + 'a {
        let others = scenario.obstacles.iter();
        let others = others.filter(move |o| is_solid(o) && Some(o.id) != without);
        others.filter_map(move |obstacle| {
            let other = obstacle.placed_at(step)?;
            let far = ego.footprint.reach() + other.footprint.reach();
            let apart = (ego.pose.position - other.pose.position).norm();
            if apart > far || ego.distance(&other) > 0.0 {
                return None;
            }
            let (own, others) = sides(ego, &other);
            Some(Self {
                with: obstacle.id,
                step,
                ego: own,
                other: others,
                is_possible: obstacle.is_occupancy_at(step),
            })
        })
    }
}

/// The sides with which two bodies touch.
pub(super) fn sides(a: &Placed<'_>, b: &Placed<'_>) -> (ContactSide, ContactSide) {
    let middle = middle(a, b);
    (face(a, &middle), face(b, &middle))
}

fn is_solid(obstacle: &Obstacle) -> bool {
    matches!(obstacle.role, ObstacleRole::Static | ObstacleRole::Dynamic)
}

/// Looks between two steps.
const PARTS: usize = 8;

/// A first touch is found to this share of a step: 0.1 mm where two bodies approach by 1 m a step.
const EXACT: f64 = 1e-4;

/// The obstacle of `scenario` but `without` that a body touches on its way from one pose to the other within the step
/// after `step`; body and obstacles go evenly from their places to the next ones. Looked at 8 times a step.
#[must_use]
pub fn touches_between(
    scenario: &Scenario,
    body: &Footprint,
    way: (Pose, Pose),
    step: i64,
    without: Option<i64>,
) -> Option<i64> {
    let mut others = scenario.obstacles.iter();
    let touched = others.find(|obstacle| {
        is_solid(obstacle)
            && Some(obstacle.id) != without
            && Ways::of(obstacle, body, way, step)
                .is_some_and(|ways| (1..PARTS).any(|part| ways.touch(part_of(part))))
    });
    touched.map(|obstacle| obstacle.id)
}

fn part_of(part: usize) -> f64 {
    part as f64 / PARTS as f64
}

/// The ways of a body and an obstacle within a step, both even.
struct Ways<'a> {
    body: &'a Footprint,
    other: &'a Footprint,
    of_body: (Pose, Pose),
    of_other: (Pose, Pose),
}

impl<'a> Ways<'a> {
    /// Nothing where the obstacle is not there at both steps, or too far away to be touched.
    fn of(
        obstacle: &'a Obstacle,
        body: &'a Footprint,
        (from, to): (Pose, Pose),
        step: i64,
    ) -> Option<Self> {
        let other = obstacle.footprint_at(step)?;
        let (now, next) = (obstacle.motion_at(step)?, obstacle.motion_at(step + 1)?);
        let moved = (to.position - from.position).norm();
        let far = body.reach() + other.reach() + moved;
        let far = far + (next.pose.position - now.pose.position).norm();
        if (from.position - now.pose.position).norm() > far {
            return None;
        }
        Some(Self {
            body,
            other,
            of_body: (from, to),
            of_other: (now.pose, next.pose),
        })
    }

    /// Both bodies a share of the way on.
    fn at(&self, share: f64) -> (Placed<'a>, Placed<'a>) {
        let pose = |(from, to): &(Pose, Pose)| between(from, to, share);
        (
            self.body.at(pose(&self.of_body)),
            self.other.at(pose(&self.of_other)),
        )
    }

    fn touch(&self, share: f64) -> bool {
        let (body, other) = self.at(share);
        body.distance(&other) <= 0.0
    }
}

/// The first touch of a body and an obstacle within a step.
struct Touch {
    /// Share of the step.
    share: f64,
    /// The sides that touch: the body's, the obstacle's.
    sides: (ContactSide, ContactSide),
}

impl Touch {
    /// Nothing where they do not touch, or do so from the beginning of the step.
    fn on(obstacle: &Obstacle, body: &Footprint, way: (Pose, Pose), step: i64) -> Option<Self> {
        let ways = Ways::of(obstacle, body, way, step)?;
        let first = (0..=PARTS).find(|part| ways.touch(part_of(*part)))?;
        let (mut apart, mut touching) = (part_of(first.checked_sub(1)?), part_of(first));
        while touching - apart > EXACT {
            let middle = f64::midpoint(apart, touching);
            match ways.touch(middle) {
                true => touching = middle,
                false => apart = middle,
            }
        }
        let (body, other) = ways.at(touching);
        Some(Self {
            share: touching,
            sides: sides(&body, &other),
        })
    }
}

/// The pose a share of the way from one to the other.
pub(super) fn between(from: &Pose, to: &Pose, share: f64) -> Pose {
    Pose {
        position: from.position + (to.position - from.position) * share,
        heading: from.heading + angle_between(from.heading, to.heading) * share,
    }
}

/// The middle of what two bodies share: of the corners of either that are in the other, and of where their outlines
/// cross; the point between them where they only just touch.
fn middle(a: &Placed<'_>, b: &Placed<'_>) -> Point {
    let edges = |body: &Placed<'_>| -> Vec<(Point, Point)> {
        let rings = body.outlines();
        let ring = |ring: &Vec<Point>| -> Vec<(Point, Point)> {
            let ends = ring.iter().cycle().skip(1);
            ring.iter().copied().zip(ends.copied()).collect()
        };
        rings.iter().flat_map(ring).collect()
    };
    let (of_a, of_b) = (edges(a), edges(b));
    let inside = |edges: &[(Point, Point)], other: &Placed<'_>| -> Vec<Point> {
        let corners = edges.iter().map(|(from, _)| *from);
        corners.filter(|p| other.holds(p)).collect()
    };
    let mut shared = [inside(&of_a, b), inside(&of_b, a)].concat();
    for one in &of_a {
        shared.extend(of_b.iter().filter_map(|other| crossing(*one, *other)));
    }
    if shared.is_empty() {
        return nalgebra::center(&a.pose.position, &b.pose.position);
    }
    let sum = shared.iter().fold(Vector::zeros(), |sum, p| sum + p.coords);
    Point::from(sum / shared.len() as f64)
}

/// Where two stretches of line cross; `None` for parallel ones.
fn crossing((a, b): (Point, Point), (c, d): (Point, Point)) -> Option<Point> {
    let (along, other, between) = (b - a, d - c, c - a);
    let cross = along.perp(&other);
    if cross == 0.0 {
        return None;
    }
    let (t, u) = (between.perp(&other) / cross, between.perp(&along) / cross);
    let within = (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u);
    within.then(|| a + along * t)
}

/// The side of a body that is nearest to a point on or in it.
fn face(body: &Placed<'_>, at: &Point) -> ContactSide {
    let local = body.pose.to_local(at);
    let (length, width) = body.footprint.shape().size();
    let (x, y) = (local.x * 2.0 / length, local.y * 2.0 / width);
    // Depth below each side, metres: the least one is that side.
    let sides = [
        ((1.0 - x) * length, ContactSide::Front),
        ((1.0 + x) * length, ContactSide::Rear),
        ((1.0 - y) * width, ContactSide::Left),
        ((1.0 + y) * width, ContactSide::Right),
    ];
    let nearest = sides.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map_or(ContactSide::Front, |(_, face)| face)
}

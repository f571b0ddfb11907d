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
}

impl std::fmt::Display for Collision {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (ego, other) = (self.ego.name(), self.other.name());
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

    /// The same for a body that was at `before` a step earlier; of several who are touched, the one that was touched
    /// first on the way from there.
    #[must_use]
    pub fn first(
        scenario: &Scenario,
        ego: &Placed<'_>,
        before: Option<Pose>,
        step: i64,
        without: Option<i64>,
    ) -> Option<Self> {
        let mut all: Vec<Self> = Self::all_at(scenario, ego, step, without).collect();
        if let (Some(before), true) = (before, all.len() > 1) {
            let way = (before, ego.pose);
            let when = |one: &Self| {
                let obstacle = scenario.obstacle(one.with)?;
                touched_on(obstacle, ego.footprint, way, step - 1)
            };
            all.sort_by_key(|one| when(one).unwrap_or(PARTS));
        }
        all.into_iter().next()
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
            && touched_on(obstacle, body, way, step).is_some()
    });
    touched.map(|obstacle| obstacle.id)
}

/// The first part of the step after `step` in which a body touches an obstacle on its way; nothing where it does not,
/// or only at the end.
fn touched_on(
    obstacle: &Obstacle,
    body: &Footprint,
    (from, to): (Pose, Pose),
    step: i64,
) -> Option<usize> {
    let other = obstacle.footprint_at(step)?;
    let (now, next) = (obstacle.motion_at(step)?, obstacle.motion_at(step + 1)?);
    let moved = (to.position - from.position).norm();
    let far = body.reach() + other.reach() + moved;
    let far = far + (next.pose.position - now.pose.position).norm();
    if (from.position - now.pose.position).norm() > far {
        return None;
    }
    (1..PARTS).find(|part| {
        let share = *part as f64 / PARTS as f64;
        let own = body.at(between(&from, &to, share));
        own.distance(&other.at(between(&now.pose, &next.pose, share))) <= 0.0
    })
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

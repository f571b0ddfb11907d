//! Which obstacles matter however far away they are, what the ego sees of them, and the overview of a long window.
//!
//! At 30 m/s a radius of 30 m is a second. Only the motions at one step are looked at, and nothing that follows.

use std::collections::{BTreeMap, HashMap};

use nearmiss_base::geometry::Vector;

use super::options::{Moment, Options};
use super::writer::{Subject, Writer, degrees};
use crate::metrics::{Direction, Encounter, HORIZON, Relation, measure, side_of_centre};
use crate::scenario::{Motion, Participant, Scene, Window};

/// Whether an obstacle can reach the ego is asked with either velocity off by up to this, in any direction, m/s.
pub const VELOCITY_TOLERANCE: f64 = 2.0;

/// Whether the two can touch within `horizon` seconds: discs around the bodies do, if each keeps its velocity to within
/// [`VELOCITY_TOLERANCE`].
pub(super) fn can_reach(encounter: &Encounter<'_>, horizon: f64) -> bool {
    Approach::new(encounter).least(2.0 * VELOCITY_TOLERANCE, horizon) <= 0.0
}

/// The obstacle of the lowest `ttc` at a step: the first that touches the ego if all keep velocity and heading; the
/// measure looks [`HORIZON`] ahead.
pub(super) fn first_to_touch(scene: &Scene, step: i64) -> Option<i64> {
    let ttc = measure("ttc")?;
    let times = scene.participants().filter_map(|other| {
        let encounter = Encounter::at(scene, &other, step)?;
        // The discs spare most of the sweeping.
        let meet = Approach::new(&encounter).least(0.0, HORIZON) <= 0.0;
        let time = meet.then(|| ttc.compute(&encounter).value()).flatten()?;
        Some((time, other.obstacle.id))
    });
    let first = times.min_by(|a, b| a.0.total_cmp(&b.0));
    first.map(|(_, id)| id)
}

/// How far two centres are apart, metres.
pub(super) fn centre_distance(one: &Motion, other: &Motion) -> f64 {
    (other.pose.position - one.pose.position).norm()
}

/// Two discs, one seen from the other.
struct Approach {
    /// From centre to centre, metres.
    between: Vector,
    /// m/s.
    velocity: Vector,
    /// Both radii, metres.
    bodies: f64,
}

impl Approach {
    fn new(encounter: &Encounter<'_>) -> Self {
        let Encounter { ego, other, .. } = encounter;
        Self {
            between: other.pose.position - ego.pose.position,
            velocity: other.velocity_vector() - ego.velocity_vector(),
            bodies: encounter.ego_body.reach() + encounter.other_body.reach(),
        }
    }

    /// The smallest gap within `horizon` seconds at constant velocity, metres, where the discs grow by `growth` m/s.
    fn least(&self, growth: f64, horizon: f64) -> f64 {
        let Self {
            between, velocity, ..
        } = self;
        let speed = velocity.norm();
        // The gap is convex in time: least where it shrinks as fast as the discs grow.
        let time = if speed > growth.max(f64::EPSILON) {
            let nearest = -between.dot(velocity) / (speed * speed);
            let miss = (between + velocity * nearest).norm();
            nearest + miss * growth / (speed * (speed * speed - growth * growth).sqrt())
        } else {
            horizon
        };
        let time = time.clamp(0.0, horizon);
        (between + velocity * time).norm() - self.bodies - growth * time
    }
}

/// An obstacle as the ego sees it at one step.
pub(super) struct VisibleObstacle {
    /// The side of the ego that it is on, as descriptions have it.
    pub direction: Direction,
    /// The shortest way between the bodies, metres; 0 where they touch.
    pub distance: f64,
    /// Its heading minus the ego's, degrees, positive to the left.
    pub heading: f64,
    /// Gaps and relative motion.
    pub relation: Relation,
}

impl VisibleObstacle {
    pub fn new(encounter: &Encounter<'_>, options: &Options) -> Self {
        let relation = encounter.relation();
        Self {
            direction: direction(encounter, &relation, options),
            distance: encounter.distance(),
            heading: degrees(encounter.other.pose.heading - encounter.ego.pose.heading),
            relation,
        }
    }

    /// The relative velocity along and across the ego's heading as it is written.
    pub fn written_velocity(&self, w: &Writer) -> (f64, f64) {
        let velocity = &self.relation.velocity;
        (
            w.written("v_rel_long", velocity.x),
            w.written("v_rel_lat", velocity.y),
        )
    }
}

/// Where contact is not to be said, bodies that touch have the side of the ego that the other's centre lies nearest to,
/// as bodies have that nearly touch.
fn direction(encounter: &Encounter<'_>, relation: &Relation, options: &Options) -> Direction {
    if relation.direction != Direction::Contact || options.contact {
        return relation.direction;
    }
    side_of_centre(encounter)
}

/// The obstacles that are near the ego as descriptions have it at any step of a window, described or not, in the order
/// in which they come near.
pub(super) fn came_near<'a>(
    scene: &'a Scene,
    window: &Window,
    options: &Options,
) -> Vec<Participant<'a>> {
    let mut first: HashMap<i64, i64> = HashMap::new();
    for step in window.steps() {
        for (other, _) in options.near(scene, step) {
            first.entry(other.obstacle.id).or_insert(step);
        }
    }
    let everyone = scene.participants().filter(|p| !p.obstacle.is_set_based());
    let mut found: Vec<_> = everyone
        .filter_map(|p| Some((*first.get(&p.obstacle.id)?, p)))
        .collect();
    found.sort_by_key(|(step, _)| *step);
    found
        .into_iter()
        .map(|(_, participant)| participant)
        .collect()
}

/// The steps at which these obstacles are nearest to the ego in a window, body to body, in order, each with those that
/// are.
pub(super) fn nearest_moments<'a>(
    scene: &'a Scene,
    window: &Window,
    everyone: &[Participant<'a>],
) -> Vec<Moment<'a>> {
    let mut moments: BTreeMap<i64, Vec<_>> = BTreeMap::new();
    for other in everyone {
        let distance = |step: i64| Some((Encounter::at(scene, other, step)?.distance(), step));
        let nearest = window
            .steps()
            .filter_map(distance)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        // The motion outlives the encounter: it is the scene's.
        let motion = nearest.and_then(|(_, step)| Some((step, other.at(step)?)));
        if let Some((step, motion)) = motion {
            moments.entry(step).or_default().push((*other, motion));
        }
    }
    let moment = |(step, near)| Moment {
        step,
        near,
        left_out: false,
    };
    moments.into_iter().map(moment).collect()
}

/// The heading of the nearest moments.
pub(super) fn heading(w: &mut Writer, scene: &Scene, window: &Window) {
    let dt = scene.scenario.dt();
    w.about(Subject::Scene, Some(window.first()))
        .text("\nThe nearest moment of each obstacle from t = ")
        .time(window.first(), dt)
        .text(" s to t = ")
        .about(Subject::Scene, Some(window.last()))
        .time(window.last(), dt)
        .text(" s:\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_gap_is_that_of_all_times() {
        let mut random = fastrand::Rng::with_seed(3);
        let mut number = |most: f64| (random.f64() - 0.5) * 2.0 * most;
        for _ in 0..2000 {
            let pair = Approach {
                between: Vector::new(number(90.0), number(90.0)),
                velocity: Vector::new(number(40.0), number(40.0)),
                bodies: number(4.0).abs(),
            };
            let growth = number(6.0).abs();
            let gap = |t: f64| (pair.between + pair.velocity * t).norm() - pair.bodies - growth * t;
            let sampled = (0..=2000)
                .map(|k| gap(2.0 * f64::from(k) / 2000.0))
                .fold(f64::INFINITY, f64::min);
            let least = pair.least(growth, 2.0);
            assert!((least - sampled).abs() < 0.05 && least <= sampled + 1e-9);
        }
        // Standing still, both.
        let still = Approach {
            between: Vector::new(9.0, 0.0),
            velocity: Vector::zeros(),
            bodies: 4.0,
        };
        assert_eq!(still.least(0.0, 2.0), 5.0);
        assert_eq!(still.least(4.0, 2.0), -3.0);
    }
}

//! Obstacles that matter however far away they are: those that can reach the ego soon, and the one that meets it first.
//!
//! At 30 m/s a radius of 30 m is a second. Only the motions at one step are looked at, and nothing that follows.

use crate::metrics::{Encounter, HORIZON, measure};
use crate::scenario::{Motion, Scene};
use nearmiss_base::geometry::Vector;

/// Whether an obstacle can reach the ego is asked with either velocity off by up to this, in any direction, m/s.
pub const GIVE: f64 = 2.0;

/// Whether the two can touch within `horizon` seconds: discs around the bodies do, if each keeps its velocity to within
/// [`GIVE`].
pub(super) fn can_reach(encounter: &Encounter<'_>, horizon: f64) -> bool {
    Approach::of(encounter).least(2.0 * GIVE, horizon) <= 0.0
}

/// The obstacle of the lowest `ttc` at a step: the first that touches the ego if all keep velocity and heading; the
/// measure looks [`HORIZON`] ahead.
pub(super) fn first_to_touch(scene: &Scene, step: i64) -> Option<i64> {
    let compute = measure("ttc")?.compute;
    let times = scene.participants().filter_map(|other| {
        let encounter = Encounter::at(scene, &other, step)?;
        // The discs spare most of the sweeping.
        let meet = Approach::of(&encounter).least(0.0, HORIZON) <= 0.0;
        let time = meet.then(|| compute(&encounter).value()).flatten()?;
        Some((time, other.obstacle.id))
    });
    let first = times.min_by(|a, b| a.0.total_cmp(&b.0));
    first.map(|(_, id)| id)
}

/// How far two centres are apart, metres.
pub(super) fn apart(one: &Motion, other: &Motion) -> f64 {
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
    fn of(encounter: &Encounter<'_>) -> Self {
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

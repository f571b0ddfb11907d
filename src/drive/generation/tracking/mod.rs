//! Trajectory tracking: the motion of a single-track vehicle closest to its targets, from pure pursuit as a first guess.
//!
//! Control-limited differential dynamic programming with jerk and steering rate as bounded inputs. Source: Tassa,
//! Mansard and Todorov, Control-limited differential dynamic programming, ICRA 2014, with the bounds enforced by
//! clamping in the forward pass. In every result, each state follows from the previous one by inputs within the limits.
//!
//! Pure pursuit as the initial guess: steers towards where the vehicle is to be a moment later.
//!
//! Source: Coulter, Implementation of the pure pursuit path tracking algorithm, 1992.

mod sweep;

use nearmiss_base::geometry::{Point, Pose};

use super::Capability;
use crate::planner::VehicleState;
use sweep::{ACCELERATION, Car, HEADING, Input, Moment, SPEED, STEERING, State};

/// Targets at a step; `None` for unconstrained quantities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackingTarget {
    /// The target position of the body's centre, metres.
    pub position: Point,
    /// How fast, m/s.
    pub velocity: Option<f64>,
    /// Which way it is to point, radians.
    pub heading: Option<f64>,
    /// The weight of a squared metre of distance.
    pub weight: f64,
}

/// Rounds of the programme, at most.
const ROUNDS: usize = 25;

/// It ends when a round makes the cost better by less than this share.
const MIN_IMPROVEMENT: f64 = 1e-3;

/// The motion from `start` on, one state a step of `dt` seconds, that comes near to `wanted` at the steps after it.
///
/// It keeps the limits of `able`, never drives backwards, and begins with `start`, whose steering angle and
/// acceleration are taken into the limits.
#[must_use]
pub fn track(
    start: &VehicleState,
    wanted: &[Option<TrackingTarget>],
    able: &Capability,
    dt: f64,
) -> Vec<VehicleState> {
    let car = Car::new(able, dt);
    let first = car.state_of(start);
    let mut run = pursue(&car, first, wanted);
    let mut cost = sweep::cost(&car, &run, wanted);
    let mut damping = 1e-3;
    for _ in 0..ROUNDS {
        let Some(gains) = sweep::backward(&car, &run, wanted, damping) else {
            damping = (damping * 10.0).max(1e-3);
            if damping > 1e6 {
                break;
            }
            continue;
        };
        let better = [1.0, 0.5, 0.2, 0.05].into_iter().find_map(|length| {
            let tried = sweep::forward(&car, &run, &gains, length);
            let costs = sweep::cost(&car, &tried, wanted);
            (costs < cost).then_some((tried, costs))
        });
        let Some((tried, costs)) = better else {
            damping *= 10.0;
            if damping > 1e6 {
                break;
            }
            continue;
        };
        let gained = cost - costs;
        (run, cost) = (tried, costs);
        damping = (damping / 5.0).max(1e-6);
        if gained < MIN_IMPROVEMENT * cost {
            break;
        }
    }
    run.iter().map(|m| car.vehicle_state(&m.state)).collect()
}

/// How far ahead one looks, seconds.
const LOOKAHEAD_SECONDS: f64 = 0.6;

/// No nearer than this, metres.
const NEAREST: f64 = 2.0;

/// How quickly differences of speed are made up for, 1/s.
const HASTE: f64 = 1.5;

fn pursue(car: &Car, first: State, wanted: &[Option<TrackingTarget>]) -> Vec<Moment> {
    let ahead = (LOOKAHEAD_SECONDS / car.dt).round().max(1.0) as usize;
    let mut run = Vec::with_capacity(wanted.len() + 1);
    let mut z = first;
    for k in 0..=wanted.len() {
        let target = next(wanted, k + ahead - 1).or_else(|| last(wanted));
        let input = target.map_or(Input::zeros(), |(at, place)| {
            let time = (at + 1).saturating_sub(k).max(1) as f64 * car.dt;
            towards(car, &z, &place.position, time)
        });
        let input = car.bounded(&z, input);
        run.push(Moment { state: z, input });
        z = car.step(&z, &input);
    }
    run
}

fn next(wanted: &[Option<TrackingTarget>], from: usize) -> Option<(usize, &TrackingTarget)> {
    let there = wanted.iter().enumerate().skip(from);
    there
        .filter_map(|(at, w)| w.as_ref().map(|w| (at, w)))
        .next()
}

fn last(wanted: &[Option<TrackingTarget>]) -> Option<(usize, &TrackingTarget)> {
    let there = wanted.iter().enumerate().rev();
    there
        .filter_map(|(at, w)| w.as_ref().map(|w| (at, w)))
        .next()
}

fn towards(car: &Car, z: &State, place: &Point, time: f64) -> Input {
    let rear = Pose::new(z[0], z[1], z[HEADING]);
    // The centre is to be there, and the rear axle is behind it.
    let local = rear.to_local(place);
    let ahead = local.x - car.limits.rear_to_centre;
    let distance = ahead.hypot(local.y);
    let speed = (ahead / time).max(0.0);
    let acceleration = HASTE * (speed - z[SPEED]);
    let jerk = (acceleration - z[ACCELERATION]) / (3.0 * car.dt);
    let curvature = if distance > NEAREST && ahead > 0.0 {
        2.0 * local.y / (distance * distance)
    } else {
        0.0
    };
    let steering = (curvature * car.limits.wheelbase).atan();
    Input::new(jerk, (steering - z[STEERING]) / (2.0 * car.dt))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::planner::{Feasibility, Limits};
    use nearmiss_base::geometry::Pose;
    use nearmiss_scene::scenario::VehicleType;

    fn able() -> Capability {
        Capability {
            limits: Limits::for_vehicle(VehicleType::Bmw320i),
            jerk: 20.0,
            jerk_cost: 2e-4,
            speeding_up: f64::INFINITY,
            lateral: f64::INFINITY,
            on_road: true,
        }
    }

    fn start(velocity: f64) -> VehicleState {
        VehicleState {
            rear: Pose::new(1000.0, -500.0, 0.5),
            velocity,
            acceleration: 0.0,
            curvature: 0.0,
        }
    }

    /// Wanted relative to the start: metres ahead and to the left.
    fn wanted(
        start: &VehicleState,
        place: impl Fn(f64) -> (f64, f64),
    ) -> Vec<Option<TrackingTarget>> {
        let centre = start.centre(&able().limits).pose;
        (1..=60)
            .map(|k| {
                let (x, y) = place(f64::from(k) * 0.1);
                Some(TrackingTarget {
                    position: centre.to_world(&Point::new(x, y)),
                    velocity: None,
                    heading: None,
                    weight: 1.0,
                })
            })
            .collect()
    }

    fn worst(states: &[VehicleState], wanted: &[Option<TrackingTarget>]) -> f64 {
        let centres = states.iter().skip(1).map(|s| s.centre(&able().limits));
        let off = centres
            .zip(wanted)
            .map(|(c, w)| (c.pose.position - w.unwrap().position).norm());
        off.fold(0.0, f64::max)
    }

    fn check(states: &[VehicleState]) {
        let done = Feasibility::new(able().limits, 0.1).states(0, states);
        assert!(done.is_ok(), "{}", done.unwrap_err());
        for pair in states.windows(3) {
            let a = (pair[1].velocity - pair[0].velocity) / 0.1;
            let b = (pair[2].velocity - pair[1].velocity) / 0.1;
            assert!((b - a).abs() <= 20.0 * 0.1 + 1e-6, "jerk {}", (b - a) / 0.1);
        }
    }

    #[test]
    fn a_change_of_lane_is_followed_within_centimetres() {
        let start = start(12.0);
        let wanted = wanted(&start, |t| {
            let x = (t / 3.0).min(1.0);
            (12.0 * t, 3.5 * x * x * x * (10.0 - 15.0 * x + 6.0 * x * x))
        });
        let states = track(&start, &wanted, &able(), 0.1);
        assert_eq!(states.len(), 61);
        assert_eq!(states[0], start);
        check(&states);
        assert!(worst(&states, &wanted) < 0.1, "{}", worst(&states, &wanted));
    }

    #[test]
    fn what_nobody_can_drive_is_approached_within_the_limits() {
        let start = start(15.0);
        // A jump of 6 m to the left, and standing after 1 s.
        let wanted = wanted(&start, |t| {
            (15.0 * t.min(1.0), if t > 0.5 { 6.0 } else { 0.0 })
        });
        let states = track(&start, &wanted, &able(), 0.1);
        check(&states);
        let end = states.last().unwrap();
        assert!(end.velocity < 1.0, "{}", end.velocity);
    }

    #[test]
    fn braking_to_a_stop_stays_there() {
        let start = start(10.0);
        let wanted = wanted(&start, |t| {
            let t = t.min(2.5);
            (10.0 * t - 2.0 * t * t, 0.0)
        });
        let states = track(&start, &wanted, &able(), 0.1);
        check(&states);
        assert!(worst(&states, &wanted) < 0.5, "{}", worst(&states, &wanted));
        assert!(states.iter().all(|s| s.velocity >= 0.0));
    }
}

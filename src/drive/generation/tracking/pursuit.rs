//! Pure pursuit as the initial guess: steers towards where the vehicle is to be a moment later.
//!
//! Source: Coulter, Implementation of the pure pursuit path tracking algorithm, 1992.

use super::TrackingTarget;
use super::model::{ACCELERATION, Car, HEADING, Input, Moment, SPEED, STEERING, State};
use nearmiss_base::geometry::{Point, Pose};

/// How far ahead one looks, seconds.
const AHEAD: f64 = 0.6;

/// No nearer than this, metres.
const NEAREST: f64 = 2.0;

/// How quickly differences of speed are made up for, 1/s.
const HASTE: f64 = 1.5;

pub fn pursue(car: &Car, first: State, wanted: &[Option<TrackingTarget>]) -> Vec<Moment> {
    let ahead = (AHEAD / car.dt).round().max(1.0) as usize;
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

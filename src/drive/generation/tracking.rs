//! Trajectory tracking: the motion of a single-track vehicle closest to its targets, from pure pursuit as a first guess.
//!
//! Control-limited differential dynamic programming with jerk and steering rate as bounded inputs. Source: Tassa,
//! Mansard and Todorov, Control-limited differential dynamic programming, ICRA 2014, with the bounds enforced by
//! clamping in the forward pass. In every result, each state follows from the previous one by inputs within the limits.
//!
//! Pure pursuit as the initial guess: steers towards where the vehicle is to be a moment later.
//!
//! Source: Coulter, Implementation of the pure pursuit path tracking algorithm, 1992.

use nalgebra::{SMatrix, SVector};
use nearmiss_base::geometry::{Point, Pose, angle_between};

use super::Capability;
use crate::planner::{Limits, VehicleState};

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
    let mut cost = run_cost(&car, &run, wanted);
    let mut damping = 1e-3;
    for _ in 0..ROUNDS {
        let Some(gains) = sweep_backward(&car, &run, wanted, damping) else {
            damping = (damping * 10.0).max(1e-3);
            if damping > 1e6 {
                break;
            }
            continue;
        };
        let better = [1.0, 0.5, 0.2, 0.05].into_iter().find_map(|length| {
            let tried = sweep_forward(&car, &run, &gains, length);
            let costs = run_cost(&car, &tried, wanted);
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

/// Weights of squared differences of speed (m/s) and heading (rad), relative to a squared metre.
const SPEEDS: f64 = 0.2;

const HEADINGS: f64 = 2.0;

/// Weight of the squared steering rate (rad/s).
const RATE: f64 = 0.05;

/// What is beyond the friction circle weighs so much, squared share.
const FRICTION: f64 = 20.0;

/// The feedback law of the inputs: a change, and a gain on each difference of the state.
#[derive(Debug, Clone, Copy)]
struct Gain {
    change: SVector<f64, 2>,
    feedback: SMatrix<f64, 2, 6>,
}

/// What a state costs, with slope and bend.
struct Worth {
    value: f64,
    slope: State,
    bend: SMatrix<f64, 6, 6>,
}

fn worth(car: &Car, z: &State, wanted: Option<&TrackingTarget>) -> Worth {
    let mut worth = Worth {
        value: 0.0,
        slope: State::zeros(),
        bend: SMatrix::zeros(),
    };
    friction(car, z, &mut worth);
    let Some(wanted) = wanted else { return worth };
    let (sin, cos) = z[HEADING].sin_cos();
    let back = car.limits.rear_to_centre;
    let off = [
        z[0] + back * cos - wanted.position.x,
        z[1] + back * sin - wanted.position.y,
    ];
    for (row, (off, turned)) in off.into_iter().zip([-back * sin, back * cos]).enumerate() {
        let mut slope = State::zeros();
        slope[row] = 1.0;
        slope[HEADING] = turned;
        worth.add(off, &slope, wanted.weight);
    }
    if let Some(velocity) = wanted.velocity {
        let mut slope = State::zeros();
        slope[SPEED] = 1.0;
        worth.add(z[SPEED] - velocity, &slope, SPEEDS * wanted.weight);
    }
    if let Some(heading) = wanted.heading {
        let mut slope = State::zeros();
        slope[HEADING] = 1.0;
        let off = angle_between(heading, z[HEADING]);
        worth.add(off, &slope, HEADINGS * wanted.weight);
    }
    worth
}

/// Nothing within the friction circle, and the more the farther beyond it.
fn friction(car: &Car, z: &State, worth: &mut Worth) {
    let most = car.limits.acceleration;
    let tan = z[STEERING].tan();
    let per = z[SPEED] / car.limits.wheelbase;
    let across = z[SPEED] * per * tan;
    let used = (across * across + z[ACCELERATION] * z[ACCELERATION]).sqrt() / most;
    if used <= 1.0 {
        return;
    }
    let scale = 1.0 / (most * most * used);
    let mut slope = State::zeros();
    slope[SPEED] = across * 2.0 * per * tan * scale;
    slope[ACCELERATION] = z[ACCELERATION] * scale;
    slope[STEERING] = across * z[SPEED] * per * (1.0 + tan * tan) * scale;
    worth.add(used - 1.0, &slope, FRICTION);
}

impl Worth {
    /// Adds a weighted square of `off`, whose slope is given.
    fn add(&mut self, off: f64, slope: &State, weight: f64) {
        self.value += weight * off * off;
        self.slope += slope * (2.0 * weight * off);
        self.bend += slope * slope.transpose() * (2.0 * weight);
    }
}

fn input_cost(car: &Car, u: &Input) -> f64 {
    car.jerk_cost * u[0] * u[0] + RATE * u[1] * u[1]
}

/// What a motion costs; its first state is given and costs nothing.
fn run_cost(car: &Car, run: &[Moment], wanted: &[Option<TrackingTarget>]) -> f64 {
    let states = run.iter().skip(1).zip(wanted);
    let states: f64 = states
        .map(|(m, w)| worth(car, &m.state, w.as_ref()).value)
        .sum();
    states + run.iter().map(|m| input_cost(car, &m.input)).sum::<f64>()
}

/// The gains for each step; nothing where `damping` is too small for them to exist.
fn sweep_backward(
    car: &Car,
    run: &[Moment],
    wanted: &[Option<TrackingTarget>],
    damping: f64,
) -> Option<Vec<Gain>> {
    let mut gains = Vec::with_capacity(run.len());
    let last = run.last()?;
    let end = worth(car, &last.state, wanted.last().and_then(Option::as_ref));
    let (mut slope, mut bend) = (end.slope, end.bend);
    for k in (0..run.len() - 1).rev() {
        let Moment { state, input } = &run[k];
        let (a, b) = car.slopes(state, input);
        let here = match k.checked_sub(1) {
            Some(before) => worth(car, state, wanted[before].as_ref()),
            None => Worth {
                value: 0.0,
                slope: State::zeros(),
                bend: SMatrix::zeros(),
            },
        };
        let q_z = here.slope + a.transpose() * slope;
        let weights = SVector::<f64, 2>::new(2.0 * car.jerk_cost, 2.0 * RATE);
        let q_u = weights.component_mul(input) + b.transpose() * slope;
        let q_zz = here.bend + a.transpose() * bend * a;
        let q_uz = b.transpose() * bend * a;
        let q_uu = SMatrix::<f64, 2, 2>::from_diagonal(&weights) + b.transpose() * bend * b;
        let damped = q_uu + SMatrix::<f64, 2, 2>::from_diagonal(&(weights * damping));
        let inverse = damped
            .try_inverse()
            .filter(|i| i[(0, 0)] > 0.0 && i[(1, 1)] > 0.0)?;
        let gain = Gain {
            change: -(inverse * q_u),
            feedback: -(inverse * q_uz),
        };
        slope = q_z
            + gain.feedback.transpose() * (q_uu * gain.change + q_u)
            + q_uz.transpose() * gain.change;
        bend = q_zz
            + gain.feedback.transpose() * q_uu * gain.feedback
            + gain.feedback.transpose() * q_uz
            + q_uz.transpose() * gain.feedback;
        bend = (bend + bend.transpose()) * 0.5;
        gains.push(gain);
    }
    gains.reverse();
    Some(gains)
}

/// The motion with a share of the change, and every input within its bounds.
fn sweep_forward(car: &Car, run: &[Moment], gains: &[Gain], share: f64) -> Vec<Moment> {
    let mut tried = Vec::with_capacity(run.len());
    let Some(first) = run.first() else {
        return tried;
    };
    let mut z = first.state;
    for (k, before) in run.iter().enumerate() {
        let input = gains.get(k).map_or(before.input, |gain| {
            before.input + gain.change * share + gain.feedback * (z - before.state)
        });
        let input = car.bounded(&z, input);
        tried.push(Moment { state: z, input });
        z = car.step(&z, &input);
    }
    tried
}

/// x, y (m) and heading (rad) of the rear axle, velocity (m/s), acceleration (m/s²) and steering angle (rad).
type State = SVector<f64, 6>;

/// Jerk (m/s³) and steering rate (rad/s).
type Input = SVector<f64, 2>;

/// A state, and the input that is held until the next one.
#[derive(Debug, Clone, Copy)]
struct Moment {
    state: State,
    input: Input,
}

/// Places in a state.
const HEADING: usize = 2;

const SPEED: usize = 3;

const ACCELERATION: usize = 4;

const STEERING: usize = 5;

/// Shares of the limits that motions are made within, so that they pass the whole ones after rounding.
const SHARE: f64 = 0.97;

/// A vehicle with its limits.
#[derive(Debug, Clone, Copy)]
struct Car {
    limits: Limits,
    jerk: f64,
    speeding_up: f64,
    lateral: f64,
    dt: f64,
    /// What a squared jerk costs, m²/(m/s³)².
    jerk_cost: f64,
}

impl Car {
    fn new(able: &Capability, dt: f64) -> Self {
        let able = able.scaled(SHARE);
        Self {
            limits: able.limits,
            jerk: able.jerk,
            speeding_up: able.speeding_up,
            lateral: able.lateral,
            dt,
            jerk_cost: able.jerk_cost,
        }
    }

    fn state_of(&self, start: &VehicleState) -> State {
        let limits = &self.limits;
        let steering = limits.steering_of(start.curvature);
        State::from([
            start.rear.position.x,
            start.rear.position.y,
            start.rear.heading,
            start.velocity.max(0.0),
            start.acceleration,
            steering.clamp(-limits.steering, limits.steering),
        ])
    }

    fn vehicle_state(&self, z: &State) -> VehicleState {
        VehicleState {
            rear: Pose::new(z[0], z[1], z[HEADING]),
            velocity: z[SPEED],
            acceleration: z[ACCELERATION],
            curvature: z[STEERING].tan() / self.limits.wheelbase,
        }
    }

    /// The state after a step: the acceleration is held over it and jumps at its end, the wheels turn evenly.
    fn step(&self, z: &State, u: &Input) -> State {
        let dt = self.dt;
        let along = z[SPEED] + z[ACCELERATION] * dt / 2.0;
        let curvature = (z[STEERING] + u[1] * dt / 2.0).tan() / self.limits.wheelbase;
        let (sin, cos) = (z[HEADING] + along * curvature * dt / 2.0).sin_cos();
        State::from([
            z[0] + along * cos * dt,
            z[1] + along * sin * dt,
            z[HEADING] + along * curvature * dt,
            // Rounding error at a stop.
            (z[SPEED] + z[ACCELERATION] * dt).max(0.0),
            z[ACCELERATION] + u[0] * dt,
            z[STEERING] + u[1] * dt,
        ])
    }

    /// Derivatives of [`Self::step`] by state and by input.
    fn slopes(&self, z: &State, u: &Input) -> (SMatrix<f64, 6, 6>, SMatrix<f64, 6, 2>) {
        let (dt, half) = (self.dt, self.dt / 2.0);
        let along = z[SPEED] + z[ACCELERATION] * half;
        let middle = z[STEERING] + u[1] * half;
        let curvature = middle.tan() / self.limits.wheelbase;
        let bend = (1.0 + middle.tan().powi(2)) / self.limits.wheelbase;
        let (sin, cos) = (z[HEADING] + along * curvature * half).sin_cos();
        let mut a = SMatrix::<f64, 6, 6>::identity();
        let mut b = SMatrix::<f64, 6, 2>::zeros();
        let turned = [-along * sin * dt, along * cos * dt];
        for (row, (ahead, turned)) in [cos, sin].into_iter().zip(turned).enumerate() {
            let by_speed = dt * ahead + turned * curvature * half;
            let by_steering = turned * along * bend * half;
            a[(row, HEADING)] = turned;
            a[(row, SPEED)] = by_speed;
            a[(row, ACCELERATION)] = by_speed * half;
            a[(row, STEERING)] = by_steering;
            b[(row, 1)] = by_steering * half;
        }
        a[(HEADING, SPEED)] = dt * curvature;
        a[(HEADING, ACCELERATION)] = dt * curvature * half;
        a[(HEADING, STEERING)] = dt * along * bend;
        a[(SPEED, ACCELERATION)] = dt;
        b[(HEADING, 1)] = dt * along * bend * half;
        b[(ACCELERATION, 0)] = dt;
        b[(STEERING, 1)] = dt;
        (a, b)
    }

    /// The input nearest to `u` after which the limits hold.
    fn bounded(&self, z: &State, u: Input) -> Input {
        let (dt, limits) = (self.dt, &self.limits);
        let speed = (z[SPEED] + z[ACCELERATION] * dt).max(0.0);
        let rate = limits.steering_rate;
        // Steering first: what it leaves of the friction circle is for accelerating.
        let across = |angle: f64| speed * speed * angle.tan() / limits.wheelbase;
        let widest = if speed > 1.0 {
            let most = (limits.acceleration * ACROSS).min(self.lateral);
            (most * limits.wheelbase / (speed * speed)).atan()
        } else {
            limits.steering
        };
        let widest = widest.min(limits.steering);
        let wanted = (z[STEERING] + u[1] * dt).clamp(-widest, widest);
        let steering_rate = ((wanted - z[STEERING]) / dt).clamp(-rate, rate);
        let across = across(z[STEERING] + steering_rate * dt).abs();
        let left = (limits.acceleration.powi(2) - across.powi(2))
            .max(0.0)
            .sqrt();
        let lowest = (-left).max(-self.releasable(speed));
        let next_speed = speed + z[ACCELERATION].max(0.0) * dt;
        let room = (limits.speed - speed).max(0.0);
        let highest = left
            .min(limits.forward(next_speed))
            .min(self.speeding_up)
            .min((2.0 * self.jerk * room).sqrt() / 2.0);
        let acceleration = (z[ACCELERATION] + u[0] * dt).clamp(lowest.min(highest), highest);
        let jerk = ((acceleration - z[ACCELERATION]) / dt).clamp(-self.jerk, self.jerk);
        Input::new(jerk, steering_rate)
    }

    /// The braking (m/s²) that can still be taken back, with the jerk there is, before one stands.
    fn releasable(&self, speed: f64) -> f64 {
        // In steps of dt, braking by b, b − J dt, … takes b²/2J + b dt/2 of the speed, and up to J dt²/8 more where the
        // last one is not a whole one. What ends within one step is exact.
        let change = self.jerk * self.dt;
        let left = (speed - change * self.dt / 8.0).max(0.0);
        let several = (change * change / 4.0 + 2.0 * self.jerk * left).sqrt() - change / 2.0;
        several.max((speed / self.dt).min(change))
    }
}

/// The share of the friction circle that steering may take.
const ACROSS: f64 = 0.9;

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

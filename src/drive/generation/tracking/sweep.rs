//! The two sweeps of the programme: the value of each step, backwards; the resulting motion, forwards.

use nalgebra::{SMatrix, SVector};

use super::TrackingTarget;
use super::model::{ACCELERATION, Car, HEADING, Input, Moment, SPEED, STEERING, State};
use nearmiss_base::geometry::angle_between;

/// Weights of squared differences of speed (m/s) and heading (rad), relative to a squared metre.
const SPEEDS: f64 = 0.2;
const HEADINGS: f64 = 2.0;

/// Weight of the squared steering rate (rad/s).
const RATE: f64 = 0.05;

/// What is beyond the friction circle weighs so much, squared share.
const FRICTION: f64 = 20.0;

/// The feedback law of the inputs: a change, and a gain on each difference of the state.
#[derive(Debug, Clone, Copy)]
pub struct Gain {
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
pub fn cost(car: &Car, run: &[Moment], wanted: &[Option<TrackingTarget>]) -> f64 {
    let states = run.iter().skip(1).zip(wanted);
    let states: f64 = states
        .map(|(m, w)| worth(car, &m.state, w.as_ref()).value)
        .sum();
    states + run.iter().map(|m| input_cost(car, &m.input)).sum::<f64>()
}

/// The gains for each step; nothing where `damping` is too small for them to exist.
pub fn backward(
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
pub fn forward(car: &Car, run: &[Moment], gains: &[Gain], share: f64) -> Vec<Moment> {
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

//! Checks whether a vehicle could have driven a finished trajectory, whatever its source.
//!
//! Between consecutive states a kinematic single-track vehicle must get by with one steering rate and one acceleration,
//! constant over the step and within its limits. Tolerances are those of `commonroad-drivability-checker` 2025.4.0
//! (`position_orientation_feasibility_criteria`). One difference: there an optimiser searches inputs that reach the
//! next place; here the inputs are those that also reach the next speed and steering angle.
//!
//! One step of the kinematic single-track model, integrated.
//!
//! Source: Althoff and Würsching, CommonRoad: Vehicle Models (2020), section III. The inputs are constant over the
//! step.

use std::cmp::Ordering;

use nearmiss_base::geometry::{Pose, Vector, angle_between};
use nearmiss_scene::scenario::Track;

use super::{Limits, VehicleState};

/// Bounds that every step of a trajectory must keep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Bound {
    /// A state for each step; the value is the steps to the next one.
    Gap,
    /// The largest speed.
    Speed,
    /// No driving backwards; the value is the speed backwards.
    Backwards,
    /// Acceleration by engine or brakes along the heading.
    Acceleration,
    /// The steering angle.
    SteeringAngle,
    /// The rate of the steering angle.
    SteeringRate,
    /// The yaw rate: no more than the speed gives with the wheels turned all the way.
    YawRate,
    /// Acceleration along and across together.
    Friction,
    /// As far along the heading as the speed says; the value is what is missing or too much along x or y.
    Displacement,
    /// Movement along the heading; the value is what is off to a side along x or y.
    Slip,
    /// The heading that speed and steering angle give; the value is the difference from it.
    Heading,
}

impl Bound {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Gap => "gap",
            Self::Speed => "speed",
            Self::Backwards => "speed backwards",
            Self::Acceleration => "acceleration",
            Self::SteeringAngle => "steering angle",
            Self::SteeringRate => "steering rate",
            Self::YawRate => "yaw rate",
            Self::Friction => "friction circle",
            Self::Displacement => "displacement",
            Self::Slip => "slip",
            Self::Heading => "heading",
        }
    }

    /// The unit of its value.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Gap => "steps",
            Self::Speed | Self::Backwards => "m/s",
            Self::Acceleration | Self::Friction => "m/s²",
            Self::SteeringAngle | Self::Heading => "rad",
            Self::SteeringRate | Self::YawRate => "rad/s",
            Self::Displacement | Self::Slip => "m",
        }
    }
}

/// One bound that a trajectory breaks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Broken {
    /// The time step of the state, or the one at which the way to the next state begins.
    pub step: i64,
    /// Which.
    pub bound: Bound,
    /// The value that was needed, in the bound's unit.
    pub value: f64,
    /// The most that is allowed.
    pub most: f64,
}

impl Broken {
    /// How far it is beyond its limit, as a multiple of that.
    #[must_use]
    pub fn excess(&self) -> f64 {
        if self.value.is_nan() {
            f64::INFINITY
        } else {
            self.value / self.most.max(f64::MIN_POSITIVE)
        }
    }
}

impl std::fmt::Display for Broken {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (name, unit) = (self.bound.name(), self.bound.unit());
        write!(
            f,
            "step {}: {name} {:.4} {unit}, at most {:.4}",
            self.step, self.value, self.most
        )
    }
}

/// A trajectory that can be driven.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feasible {
    /// Steps from one state to the next that were checked.
    pub steps: usize,
    /// The largest share of the friction circle that is used, 0 to 1.
    pub friction: f64,
}

/// All bounds that a trajectory breaks, in order of time; never empty.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{} ({} in all)", .0[0], .0.len())]
pub struct FeasibilityError(pub Vec<Broken>);

/// How exactly a trajectory must be met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Of a place along x and along y, metres.
    pub position: f64,
    /// Of a heading, radians.
    pub heading: f64,
    /// The share of a limit by which it may be exceeded.
    pub share: f64,
    /// The precision of positions (m) and headings (rad): half the rounding of a file.
    pub rounding: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self {
            position: 0.02,
            heading: 0.03,
            share: 1e-4,
            rounding: 1e-6,
        }
    }
}

/// The check, for one kind of vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct Feasibility {
    limits: Limits,
    dt: f64,
    tolerance: Tolerance,
}

impl Feasibility {
    /// A check against the limits of a vehicle for states that are `dt` seconds apart.
    #[must_use]
    pub fn new(limits: Limits, dt: f64) -> Self {
        Self {
            limits,
            dt,
            tolerance: Tolerance::default(),
        }
    }

    /// With other tolerances.
    #[must_use]
    pub fn within(mut self, tolerance: Tolerance) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// Checks states at the rear axle, one a step, the first one at time step `first`.
    ///
    /// # Errors
    /// Everything that is broken.
    pub fn states(
        &self,
        first: i64,
        states: &[VehicleState],
    ) -> Result<Feasible, FeasibilityError> {
        let angle = |state: &VehicleState| self.limits.steering_of(state.curvature);
        let moments: Vec<Moment> = (first..)
            .zip(states)
            .map(|(step, state)| Moment {
                step,
                rear: state.rear,
                velocity: state.velocity,
            })
            .collect();
        let turns: Vec<Turn> = states
            .windows(2)
            .map(|pair| {
                let rate = (angle(&pair[1]) - angle(&pair[0])) / self.dt;
                Turn {
                    angle: angle(&pair[0]),
                    rate,
                    needed_angle: angle(&pair[0]).abs(),
                    needed_rate: rate.abs(),
                    angle_slack: 0.0,
                    rate_slack: 0.0,
                    across: None,
                }
            })
            .collect();
        // No step follows the last state, which has a steering angle too.
        let last = states.last().map_or(0.0, |state| angle(state).abs());
        self.run(&moments, &turns, last)
    }

    /// Checks the motion of a body's centre.
    ///
    /// The rear axle is the vehicle's `rear_to_centre` behind the centre. Steering angles are estimated, as a track has
    /// none: the mean angle of a step is the one that gives its change of heading over its length, and the steering
    /// rate of a step is the change from the mean angle of the step before it. A rate that is too high for one step
    /// only can therefore hide between lower ones, and the heading always fits. Below a displacement of a centimetre
    /// nothing is known of the steering angle; the wheels may be turned meanwhile.
    ///
    /// # Errors
    /// Everything that is broken.
    pub fn track(&self, track: &Track) -> Result<Feasible, FeasibilityError> {
        let moments: Vec<Moment> = track
            .iter()
            .map(|(step, motion)| Moment {
                step,
                rear: Pose {
                    position: motion.pose.position
                        - motion.pose.forward() * self.limits.rear_to_centre,
                    heading: motion.pose.heading,
                },
                velocity: motion.velocity,
            })
            .collect();
        let turns = estimate(&moments, &self.limits, self.dt, self.tolerance.rounding);
        self.run(&moments, &turns, 0.0)
    }

    fn run(
        &self,
        moments: &[Moment],
        turns: &[Turn],
        last_angle: f64,
    ) -> Result<Feasible, FeasibilityError> {
        let mut found = Violations {
            check: self,
            broken: Vec::new(),
        };
        let mut feasible = Feasible {
            steps: 0,
            friction: 0.0,
        };
        for (pair, turn) in moments.windows(2).zip(turns) {
            found.state(&pair[0]);
            let steps = pair[1].step - pair[0].step;
            if steps != 1 {
                found.ask(pair[0].step, Bound::Gap, steps as f64, 1.0);
                continue;
            }
            feasible.steps += 1;
            let used = found.way(&pair[0], &pair[1], turn);
            feasible.friction = feasible.friction.max(used);
        }
        if let Some(last) = moments.last() {
            found.state(last);
            found.limit(
                last.step,
                Bound::SteeringAngle,
                last_angle,
                self.limits.steering,
            );
        }
        if found.broken.is_empty() {
            Ok(feasible)
        } else {
            Err(FeasibilityError(found.broken))
        }
    }
}

/// What is broken so far.
struct Violations<'a> {
    check: &'a Feasibility,
    broken: Vec<Broken>,
}

impl Violations<'_> {
    /// NaN violates every bound.
    fn ask(&mut self, step: i64, bound: Bound, value: f64, most: f64) {
        let broken = value.partial_cmp(&most).is_none_or(Ordering::is_gt);
        if broken {
            self.broken.push(Broken {
                step,
                bound,
                value,
                most,
            });
        }
    }

    fn limit(&mut self, step: i64, bound: Bound, value: f64, most: f64) {
        self.ask(
            step,
            bound,
            value,
            most * (1.0 + self.check.tolerance.share),
        );
    }

    fn state(&mut self, at: &Moment) {
        self.limit(at.step, Bound::Speed, at.velocity, self.check.limits.speed);
        self.ask(at.step, Bound::Backwards, -at.velocity, BACKWARDS);
    }

    /// Checks all bounds at one step; returns the share of the friction circle used.
    fn way(&mut self, from: &Moment, to: &Moment, turn: &Turn) -> f64 {
        let Feasibility {
            limits,
            dt,
            tolerance,
            ..
        } = self.check;
        let step = from.step;
        let acceleration = (to.velocity - from.velocity) / dt;
        let most = if acceleration > 0.0 {
            limits.forward(from.velocity.max(to.velocity))
        } else {
            limits.acceleration
        };
        self.limit(step, Bound::Acceleration, acceleration.abs(), most);
        let (angle, rate) = (limits.steering, limits.steering_rate);
        self.limit(
            step,
            Bound::SteeringAngle,
            turn.needed_angle,
            angle + turn.angle_slack,
        );
        self.limit(
            step,
            Bound::SteeringRate,
            turn.needed_rate,
            rate + turn.rate_slack,
        );
        let turned = angle_between(from.rear.heading, to.rear.heading).abs();
        let fastest = from.velocity.max(to.velocity).max(0.0);
        let most = fastest * limits.curvature() + 2.0 * tolerance.rounding / dt;
        self.limit(step, Bound::YawRate, turned / dt, most);

        let reached = simulate(from, acceleration, turn, limits.wheelbase, *dt);
        let (friction, most) = match turn.across {
            Some(across) => (
                acceleration.hypot(across),
                limits.acceleration * (1.0 + ESTIMATE),
            ),
            None => (reached.friction, limits.acceleration),
        };
        self.limit(step, Bound::Friction, friction, most);
        let off = to.rear.position - reached.rear.position;
        // `max` would ignore NaN.
        let worst = if off.y.abs() <= off.x.abs() || off.x.is_nan() {
            off.x.abs()
        } else {
            off.y.abs()
        };
        let forward = reached.rear.forward();
        let (along, across) = (off.dot(&forward), forward.perp(&off));
        let bound = if along.abs() >= across.abs() {
            Bound::Displacement
        } else {
            Bound::Slip
        };
        self.ask(step, bound, worst, tolerance.position);
        let turned = angle_between(reached.rear.heading, to.rear.heading).abs();
        self.ask(step, Bound::Heading, turned, tolerance.heading);
        friction / limits.acceleration
    }
}

/// So little of driving backwards is rounding, m/s.
const BACKWARDS: f64 = 1e-3;

/// A shorter step says nothing about the steering angle, metres.
const STANDING: f64 = 0.01;

/// The mean of a tangent is not the tangent of the mean: what is estimated from means may exceed a limit by this share.
const ESTIMATE: f64 = 0.02;

/// The mean steering angle of a step.
#[derive(Debug, Clone, Copy)]
struct Mean {
    /// Radians.
    angle: f64,
    /// When the wheels stood like this, if they turned evenly; seconds from the first step.
    at: f64,
    /// Seconds from the first step to the beginning of this one.
    from: f64,
    /// How much of the angle may be rounding, radians.
    slack: f64,
}

/// How the wheels are turned in each of the steps between `moments`.
fn estimate(moments: &[Moment], limits: &Limits, dt: f64, rounding: f64) -> Vec<Turn> {
    let means: Vec<Option<Mean>> = moments
        .windows(2)
        .map(|pair| {
            let from = (pair[0].step - moments[0].step) as f64 * dt;
            mean(&pair[0], &pair[1], from, limits, dt, rounding)
        })
        .collect();
    // The change to each step from the last one before it that is known, rad/s, and its slack.
    let mut rates: Vec<Option<(f64, f64)>> = Vec::with_capacity(means.len());
    let mut known: Option<Mean> = None;
    for mean in &means {
        rates.push(known.zip(*mean).map(|(before, now)| {
            let time = now.at - before.at;
            let rate = (now.angle - before.angle) / time;
            let slack = (now.slack + before.slack) / time + ESTIMATE * limits.steering_rate;
            (rate, slack)
        }));
        known = mean.or(known);
    }
    let most = limits.steering_rate;
    let mut held = 0.0;
    (0..means.len())
        .map(|k| {
            let around = [Some(&rates[k]), rates.get(k + 1)];
            let around: Vec<f64> = around
                .into_iter()
                .flatten()
                .flatten()
                .map(|(rate, _)| *rate)
                .collect();
            let sum: f64 = around.iter().sum();
            let rate = (sum / around.len().max(1) as f64).clamp(-most, most);
            let (needed_rate, rate_slack) = rates[k].map_or((0.0, 0.0), |(r, s)| (r.abs(), s));
            let (from, to) = (&moments[k], &moments[k + 1]);
            let turned = angle_between(from.rear.heading, to.rear.heading);
            let across = f64::midpoint(from.velocity, to.velocity) * turned / dt;
            let Some(mean) = means[k] else {
                return Turn {
                    angle: held,
                    rate: 0.0,
                    needed_angle: 0.0,
                    needed_rate,
                    angle_slack: 0.0,
                    rate_slack,
                    across: Some(across),
                };
            };
            held = mean.angle;
            Turn {
                angle: mean.angle - rate * (mean.at - mean.from),
                rate,
                needed_angle: mean.angle.abs(),
                needed_rate,
                angle_slack: mean.slack,
                rate_slack,
                across: Some(across),
            }
        })
        .collect()
}

/// The mean angle between two moments; nothing where they are too close together, or not one step apart.
fn mean(
    from: &Moment,
    to: &Moment,
    seconds: f64,
    limits: &Limits,
    dt: f64,
    rounding: f64,
) -> Option<Mean> {
    let chord = (to.rear.position - from.rear.position).norm();
    if chord < STANDING || to.step - from.step != 1 {
        return None;
    }
    let turned = angle_between(from.rear.heading, to.rear.heading);
    let half = turned / 2.0;
    let length = if half.abs() > 1e-6 {
        chord * half / half.sin()
    } else {
        chord
    };
    // Heading is gained by length: the mean stands where half of the speed's weight is.
    let (v0, v1) = (from.velocity.max(0.0), to.velocity.max(0.0));
    let share = if v0 + v1 > 0.0 {
        (v0 / 2.0 + (v1 - v0) / 3.0) / f64::midpoint(v0, v1)
    } else {
        0.5
    };
    Some(Mean {
        angle: limits.steering_of(turned / length),
        at: seconds + share * dt,
        from: seconds,
        slack: 2.0 * rounding * (limits.wheelbase + 1.0) / length,
    })
}

/// A place of the rear axle with its speed.
#[derive(Debug, Clone, Copy)]
struct Moment {
    pub step: i64,
    pub rear: Pose,
    /// m/s along the heading.
    pub velocity: f64,
}

/// Steering over a step: the integrated angle and rate, and the ones needed.
#[derive(Debug, Clone, Copy)]
struct Turn {
    /// Steering angle at the beginning (rad) and its rate (rad/s), as they are integrated.
    pub angle: f64,
    pub rate: f64,
    /// Values compared with the limits, rad and rad/s.
    pub needed_angle: f64,
    pub needed_rate: f64,
    /// How much of that may be rounding, rad and rad/s.
    pub angle_slack: f64,
    pub rate_slack: f64,
    /// The mean acceleration across (m/s²) where the steering angle on the way is not known, only its mean.
    pub across: Option<f64>,
}

/// State reached by the inputs.
#[derive(Debug, Clone, Copy)]
struct Reached {
    pub rear: Pose,
    /// The largest acceleration along and across together on the way, m/s².
    pub friction: f64,
}

/// Runge–Kutta steps within a step.
const PARTS: usize = 8;

/// Beyond this steering angle (rad) the model turns on the spot; no vehicle's limit comes near.
const SIDEWAYS: f64 = 1.5;

/// Place and heading.
type State = (Vector, f64);

/// Drives for `dt` seconds with constant `acceleration` (m/s²) and steering rate.
fn simulate(from: &Moment, acceleration: f64, turn: &Turn, wheelbase: f64, dt: f64) -> Reached {
    let speed = |t: f64| from.velocity + acceleration * t;
    let yaw_rate = |t: f64| {
        let angle = (turn.angle + turn.rate * t).clamp(-SIDEWAYS, SIDEWAYS);
        speed(t) * angle.tan() / wheelbase
    };
    let slope = |t: f64, (_, heading): State| -> State {
        let (sin, cos) = heading.sin_cos();
        (Vector::new(cos, sin) * speed(t), yaw_rate(t))
    };
    let add = |(p, h): State, (dp, dh): State, by: f64| -> State { (p + dp * by, h + dh * by) };
    let needed = |t: f64| acceleration.hypot(speed(t) * yaw_rate(t));
    let part = dt / PARTS as f64;
    // Relative to where it begins: coordinates of maps are large.
    let mut at: State = (Vector::zeros(), from.rear.heading);
    let mut friction = needed(0.0);
    for i in 0..PARTS {
        let t = i as f64 * part;
        let k1 = slope(t, at);
        let k2 = slope(t + part / 2.0, add(at, k1, part / 2.0));
        let k3 = slope(t + part / 2.0, add(at, k2, part / 2.0));
        let k4 = slope(t + part, add(at, k3, part));
        for (k, weight) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
            at = add(at, k, weight * part / 6.0);
        }
        friction = friction.max(needed(t + part));
    }
    Reached {
        rear: Pose {
            position: from.rear.position + at.0,
            heading: at.1,
        },
        friction,
    }
}

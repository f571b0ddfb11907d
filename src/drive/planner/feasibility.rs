//! Checks whether a vehicle could have driven a finished trajectory, whatever its source.
//!
//! Between consecutive states a kinematic single-track vehicle must get by with one steering rate and one acceleration,
//! constant over the step and within its limits. Tolerances are those of `commonroad-drivability-checker` 2025.4.0
//! (`position_orientation_feasibility_criteria`). One difference: there an optimiser searches inputs that reach the
//! next place; here the inputs are those that also reach the next speed and steering angle.

mod steering;
mod step;

use std::cmp::Ordering;

use self::step::{Moment, Turn, simulate};
use super::{Limits, VehicleState};
use nearmiss_base::geometry::{Pose, angle_between};
use nearmiss_scene::scenario::Track;

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
        let turns = steering::estimate(&moments, &self.limits, self.dt, self.tolerance.rounding);
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
                limits.acceleration * (1.0 + steering::ESTIMATE),
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

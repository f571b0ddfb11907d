//! Takes a planner's trajectory: checks it, and makes it states of the vehicle, one a time step.

use super::protocol::{PlannedState, ReferencePoint, Trajectory};
use super::{Fault, PlannerFault};
use crate::planner::{Limits, MOST_STEPS, VehicleState};
use nearmiss_base::geometry::{Pose, Vector, angle_between, normalize_angle};
use nearmiss_scene::scenario::Motion;

/// A trajectory may begin this far from the ego, metres.
const POSITION_TOLERANCE: f64 = 0.1;

/// The same for the heading, radians.
const HEADING: f64 = 0.05;

/// The same for the speed, m/s.
const SPEED: f64 = 0.2;

/// Below this way (m) in a step the heading tells nothing about the steering.
const MIN_MOVE: f64 = 0.01;

/// Times are multiples of the time step within this share of it.
const ROUNDING: f64 = 1e-6;

/// How a trajectory is read.
pub(super) struct Reader<'a> {
    pub limits: &'a Limits,
    pub dt: f64,
    pub point: ReferencePoint,
}

impl Reader<'_> {
    /// The states of a trajectory, one a step from `now` on, which is exactly the first of them.
    ///
    /// # Errors
    /// It is empty, has numbers that are not finite or times that do not increase, or does not begin at `now`.
    pub fn states(
        &self,
        trajectory: &Trajectory,
        now: &VehicleState,
    ) -> Result<Vec<VehicleState>, Fault> {
        let planned = &trajectory.states;
        if planned.is_empty() {
            return Err(Fault::new(PlannerFault::Empty, ""));
        }
        let times = self.times(planned)?;
        for (place, state) in planned.iter().enumerate() {
            if let Some((field, value)) = not_finite(state) {
                let details = format!("`states[{place}].{field}` is {value}");
                return Err(Fault::new(PlannerFault::NotFinite, details));
            }
        }
        let poses: Vec<Pose> = planned.iter().map(|state| self.rear(state)).collect();
        self.begins(&poses[0], &planned[0], now)?;
        let resampled = self.at_steps(planned, &times, &poses);
        let mut states = self.complete(&resampled, now);
        states[0] = *now;
        Ok(states)
    }

    /// Seconds of each state from now.
    fn times(&self, planned: &[PlannedState]) -> Result<Vec<f64>, Fault> {
        let times = planned.iter().enumerate();
        let times: Vec<f64> = times
            .map(|(place, state)| state.t.unwrap_or(place as f64 * self.dt))
            .collect();
        if let Some(place) = times.iter().position(|t| !t.is_finite()) {
            let details = format!("`states[{place}].t` is {}", times[place]);
            return Err(Fault::new(PlannerFault::NotFinite, details));
        }
        if times[0].abs() > self.dt * ROUNDING {
            let details = format!("the first state is at {} s, not 0", times[0]);
            return Err(Fault::new(PlannerFault::WrongTimes, details));
        }
        match times.windows(2).position(|pair| pair[1] <= pair[0]) {
            None => Ok(times),
            Some(place) => {
                let (before, after) = (times[place], times[place + 1]);
                let details = format!("`states[{}].t`: {after} s after {before} s", place + 1);
                Err(Fault::new(PlannerFault::WrongTimes, details))
            }
        }
    }

    fn rear(&self, state: &PlannedState) -> Pose {
        let pose = Pose::new(state.x, state.y, normalize_angle(state.heading));
        match self.point {
            ReferencePoint::RearAxle => pose,
            ReferencePoint::Centre => {
                let motion = Motion {
                    pose,
                    velocity: 0.0,
                    acceleration: 0.0,
                };
                VehicleState::of_centre(&motion, 0.0, self.limits).rear
            }
        }
    }

    fn begins(&self, rear: &Pose, first: &PlannedState, now: &VehicleState) -> Result<(), Fault> {
        let off = (rear.position - now.rear.position).norm();
        let turned = angle_between(now.rear.heading, rear.heading).abs();
        let faster = (first.velocity - now.velocity).abs();
        let wrong = match () {
            () if off > POSITION_TOLERANCE => {
                Some(format!("{off:.2} m away, at most {POSITION_TOLERANCE} m"))
            }
            () if turned > HEADING => Some(format!("turned {turned:.3} rad, at most {HEADING}")),
            () if faster > SPEED => Some(format!(
                "{faster:.2} m/s another speed, at most {SPEED} m/s"
            )),
            () => None,
        };
        wrong.map_or(Ok(()), |details| {
            Err(Fault::new(PlannerFault::WrongStart, details))
        })
    }

    /// The states at the time steps: between two given ones on a straight line.
    fn at_steps(&self, planned: &[PlannedState], times: &[f64], poses: &[Pose]) -> Vec<Sampled> {
        let last = times.last().copied().unwrap_or(0.0);
        let steps = ((last / self.dt + ROUNDING).floor() as usize).min(MOST_STEPS);
        let mut place = 0;
        let at = (0..=steps).map(|step| {
            let t = step as f64 * self.dt;
            while place + 2 < times.len() && times[place + 1] <= t {
                place += 1;
            }
            let next = (place + 1).min(times.len() - 1);
            let span = times[next] - times[place];
            let share = if span > 0.0 {
                ((t - times[place]) / span).clamp(0.0, 1.0)
            } else {
                0.0
            };
            Sampled::between(
                (&planned[place], &poses[place]),
                (&planned[next], &poses[next]),
                share,
            )
        });
        at.collect()
    }

    /// With the accelerations and curvatures that were not said.
    fn complete(&self, sampled: &[Sampled], now: &VehicleState) -> Vec<VehicleState> {
        let mut curvature = now.curvature;
        let count = sampled.len();
        let states = (0..count).map(|place| {
            let (here, next) = (&sampled[place], sampled.get(place + 1));
            let before = place.checked_sub(1).map(|before| &sampled[before]);
            let acceleration = here.acceleration.unwrap_or_else(|| match (next, before) {
                (Some(next), _) => (next.velocity - here.velocity) / self.dt,
                (None, Some(before)) => (here.velocity - before.velocity) / self.dt,
                (None, None) => now.acceleration,
            });
            curvature = match here.steering {
                Some(angle) => angle.tan() / self.limits.wheelbase,
                None => turn(before.unwrap_or(here), next.unwrap_or(here)).unwrap_or(curvature),
            };
            VehicleState {
                rear: here.rear,
                velocity: here.velocity,
                acceleration,
                curvature,
            }
        });
        states.collect()
    }
}

/// A state at a time step.
struct Sampled {
    rear: Pose,
    velocity: f64,
    acceleration: Option<f64>,
    steering: Option<f64>,
}

impl Sampled {
    fn between(a: (&PlannedState, &Pose), b: (&PlannedState, &Pose), share: f64) -> Self {
        let mix = |from: f64, to: f64| from + (to - from) * share;
        let both = |from: Option<f64>, to: Option<f64>| Some(mix(from?, to?));
        let turned = angle_between(a.1.heading, b.1.heading) * share;
        Self {
            rear: Pose {
                position: a.1.position + (b.1.position - a.1.position) * share,
                heading: normalize_angle(a.1.heading + turned),
            },
            velocity: mix(a.0.velocity, b.0.velocity),
            acceleration: both(a.0.acceleration, b.0.acceleration),
            steering: both(a.0.steering, b.0.steering),
        }
    }
}

/// The curvature of the way between two states, 1/m; nothing where it is too short to tell.
fn turn(from: &Sampled, to: &Sampled) -> Option<f64> {
    let way = (to.rear.position - from.rear.position).norm();
    (way > MIN_MOVE).then(|| angle_between(from.rear.heading, to.rear.heading) / way)
}

/// The first field of a state that is not finite, and its value.
fn not_finite(state: &PlannedState) -> Option<(&'static str, f64)> {
    let numbers = [
        ("x", Some(state.x)),
        ("y", Some(state.y)),
        ("heading", Some(state.heading)),
        ("velocity", Some(state.velocity)),
        ("acceleration", state.acceleration),
        ("steering", state.steering),
    ];
    let mut said = { numbers.into_iter() }.filter_map(|(name, value)| Some((name, value?)));
    // Larger than this, sums of squares are not finite either.
    said.find(|(_, number)| !number.is_finite() || number.abs() >= 1e12)
}

/// A trajectory that counts from its state `late` on, after the vehicle went on from `actual`: what is between them
/// goes to nothing within `within` seconds. Also the distance between them, metres.
pub(super) fn joined(
    planned: &[VehicleState],
    actual: &[VehicleState],
    late: usize,
    dt: f64,
    within: f64,
) -> (Vec<VehicleState>, f64) {
    let mut states: Vec<VehicleState> = actual.to_vec();
    let (Some(meant), Some(here)) = (planned.get(late), actual.get(late)) else {
        return (states, 0.0);
    };
    let off: Vector = here.rear.position - meant.rear.position;
    let turned = angle_between(meant.rear.heading, here.rear.heading);
    let faster = here.velocity - meant.velocity;
    for (place, state) in planned.iter().enumerate().skip(late + 1) {
        let gone = (place - late) as f64 * dt / within;
        let left = (1.0 - gone).max(0.0);
        states.push(VehicleState {
            rear: Pose {
                position: state.rear.position + off * left,
                heading: normalize_angle(state.rear.heading + turned * left),
            },
            velocity: state.velocity + faster * left,
            ..*state
        });
    }
    (states, off.norm())
}

//! Trajectories from inputs, by a method that is not the program's: many small midpoint steps.

use nearmiss::geometry::Pose;
use nearmiss::planner::{Limits, VehicleState};
use nearmiss::scenario::{Sample, Track, VehicleType};

pub const DT: f64 = 0.1;
const PARTS: usize = 400;

pub fn limits() -> Limits {
    Limits::for_vehicle(VehicleType::Bmw320i)
}

/// One step's inputs.
#[derive(Debug, Clone, Copy)]
pub struct Input {
    /// rad/s.
    pub rate: f64,
    /// m/s².
    pub acceleration: f64,
}

pub fn begin(velocity: f64, angle: f64) -> VehicleState {
    VehicleState {
        rear: Pose::new(4321.0, -987.0, 3.0),
        velocity,
        acceleration: 0.0,
        curvature: angle.tan() / limits().wheelbase,
    }
}

/// The state after one step with an input.
pub fn after(state: &VehicleState, input: Input) -> VehicleState {
    let part = DT / PARTS as f64;
    let wheelbase = limits().wheelbase;
    let (mut x, mut y, mut heading) = (
        state.rear.position.x,
        state.rear.position.y,
        state.rear.heading,
    );
    let angle = (state.curvature * wheelbase).atan();
    for i in 0..PARTS {
        let t = (i as f64 + 0.5) * part;
        let way = (state.velocity + input.acceleration * t) * part;
        let turn = way * (angle + input.rate * t).tan() / wheelbase;
        x += way * (heading + turn / 2.0).cos();
        y += way * (heading + turn / 2.0).sin();
        heading += turn;
    }
    VehicleState {
        rear: Pose::new(x, y, heading),
        velocity: state.velocity + input.acceleration * DT,
        acceleration: input.acceleration,
        curvature: (angle + input.rate * DT).tan() / wheelbase,
    }
}

/// All states from the first one on.
pub fn states(first: VehicleState, inputs: &[Input]) -> Vec<VehicleState> {
    let mut all = vec![first];
    for input in inputs {
        all.push(after(all.last().unwrap(), *input));
    }
    all
}

/// The motion of the body's centre, from time step `first` on.
pub fn track(first: i64, states: &[VehicleState]) -> Track {
    let samples = (first..).zip(states).map(|(step, state)| {
        let motion = state.centre(&limits());
        Sample {
            step,
            position: motion.pose.position,
            heading: Some(motion.pose.heading),
            velocity: Some(motion.velocity),
            acceleration: None,
        }
    });
    Track::new(samples.collect(), DT, None)
}

/// Acceleration along and across together, m/s².
pub fn friction(state: &VehicleState, acceleration: f64) -> f64 {
    acceleration.hypot(state.velocity * state.velocity * state.curvature)
}

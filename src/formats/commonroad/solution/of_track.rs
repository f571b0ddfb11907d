//! Builds a solution from an ego's motion.

use super::{
    ProblemSolution, Solution, SolutionError, SolutionState, SolutionTrajectory, TrajectoryKind,
};
use nearmiss_base::geometry::angle_between;
use nearmiss_scene::scenario::{Header, Motion, Track, VehicleModel, VehicleType};

/// The default cost function; it is defined for every model except the point mass.
const COST: &str = "SM1";

/// The one that is defined for a point mass.
const POINT_MASS_COST: &str = "JB1";

/// A vehicle that moves less than this between two steps, metres, does not show how its wheels stand.
const STANDSTILL: f64 = 0.005;

impl Solution {
    /// How one vehicle solves one planning problem of the scenario with this header. It does not say when and where
    /// it was made: the same motion gives the same file.
    #[must_use]
    pub fn of_problem(header: &Header, solved: ProblemSolution) -> Self {
        Self {
            scenario_id: header.benchmark_id.clone(),
            version: header.version.clone(),
            date: None,
            computation_time: None,
            processor: None,
            problems: vec![solved],
            diagnostics: Vec::new(),
        }
    }
}

impl ProblemSolution {
    /// The recorded steps of `track`, `dt` seconds apart, as states of `model`.
    ///
    /// Positions stay the centre of the vehicle, as solutions have them. A point mass gets the velocity along the
    /// heading. The kinematic single-track model gets the steering angle with which a vehicle of this wheelbase turns
    /// as the track does until the next step, δ = atan(l · Δψ / Δs); at standstill and at the end it is held, and it is
    /// 0 before the first movement. Whether the vehicle could steer so is not checked.
    ///
    /// # Errors
    /// The track is empty, or the model has states that do not follow from an ego's motion.
    pub fn of_track(
        track: &Track,
        dt: f64,
        planning_problem: i64,
        model: VehicleModel,
        vehicle: VehicleType,
    ) -> Result<Self, SolutionError> {
        let motions: Vec<(i64, &Motion)> = track.iter().collect();
        let (kind, cost, values): (_, _, Vec<Vec<f64>>) = match model {
            VehicleModel::Pm => (TrajectoryKind::Pm, POINT_MASS_COST, {
                let motions = motions.iter();
                motions.map(|(_, m)| point_mass(m)).collect()
            }),
            VehicleModel::Ks => (TrajectoryKind::Ks, COST, {
                let steering = steering(&motions, dt, vehicle.wheelbase());
                let pairs = motions.iter().zip(steering);
                pairs.map(|((_, m), s)| single_track(m, s)).collect()
            }),
            VehicleModel::St | VehicleModel::Mb | VehicleModel::Kst => {
                return Err(SolutionError::NotDerivable(model));
            }
        };
        let states = motions
            .iter()
            .zip(values)
            .map(|((step, _), values)| SolutionState {
                step: *step,
                values,
            });
        Ok(Self {
            planning_problem,
            model,
            vehicle,
            cost: cost.into(),
            trajectory: SolutionTrajectory::new(kind, states.collect())?,
        })
    }
}

fn point_mass(motion: &Motion) -> Vec<f64> {
    let (at, velocity) = (motion.pose.position, motion.velocity_vector());
    vec![at.x, at.y, velocity.x, velocity.y]
}

fn single_track(motion: &Motion, steering: f64) -> Vec<f64> {
    let pose = motion.pose;
    vec![
        pose.position.x,
        pose.position.y,
        steering,
        motion.velocity,
        pose.heading,
    ]
}

fn steering(motions: &[(i64, &Motion)], dt: f64, wheelbase: f64) -> Vec<f64> {
    let mut angles = Vec::with_capacity(motions.len());
    let mut held = 0.0;
    for pair in motions.windows(2) {
        let [(from, before), (to, after)] = pair else {
            continue;
        };
        let time = (to - from) as f64 * dt;
        let distance = f64::midpoint(before.velocity, after.velocity) * time;
        if distance.abs() >= STANDSTILL {
            let turn = angle_between(before.pose.heading, after.pose.heading);
            held = (wheelbase * turn / distance).atan();
        }
        angles.push(held);
    }
    angles.push(held);
    angles
}

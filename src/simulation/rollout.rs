//! A drive as data: its request, its steps and how it ended. The loop itself is in `closed_loop`.

use std::time::Duration;

use super::{DrivenTraffic, ExternalReport, Outcome, TrafficMode};
use crate::geometry::Pose;
use crate::planner::{
    self, Forecast, Limits, MOST_STEPS, Plan, ReferenceTrack, ReferenceTrackError, VehicleState,
};
use crate::scenario::{Motion, PlanningProblem, Sample, StateField, Track};

/// Settings of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The planner's.
    pub planner: planner::Settings,
    /// The forecast given to the planner.
    pub forecast: Forecast,
    /// Steps that are driven of a plan before the next one, at least 1.
    pub replan: usize,
    /// The obstacle whose place the ego takes.
    pub without: Option<i64>,
    /// What the others do.
    pub traffic: TrafficMode,
}

/// One planning cycle of a drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Cycle {
    /// The time step at which it was planned.
    pub step: i64,
    /// What was decided.
    pub plan: Plan,
    /// How long planning took, the forecast not counted.
    pub took: Duration,
    /// In real time: steps until the plan was there; until then its states are what was driven before.
    pub late: usize,
}

/// A drive from start to end.
#[derive(Debug, Clone, PartialEq)]
pub struct Rollout {
    /// Time steps and states of the ego, one a step.
    pub states: Vec<(i64, VehicleState)>,
    /// Every cycle.
    pub cycles: Vec<Cycle>,
    /// How it ended.
    pub outcome: Outcome,
    /// What the others did.
    pub traffic: DrivenTraffic,
    /// Whole limits of the vehicle.
    pub limits: Limits,
    /// Seconds between two steps.
    pub dt: f64,
    /// What is known of the planner's process; `None` for the built-in planner.
    pub external: Option<Box<ExternalReport>>,
}

/// Why a drive could not start.
#[derive(Debug, thiserror::Error)]
pub enum DriveError {
    /// The planner has nothing to follow.
    #[error(transparent)]
    ReferenceTrack(#[from] ReferenceTrackError),
    /// The goal does not say until when.
    #[error("planning problem {problem} has no goal")]
    NoGoal {
        /// Its id.
        problem: i64,
    },
    /// The start lacks something.
    #[error("planning problem {problem} has no {what} at its start")]
    NoStart {
        /// Its id.
        problem: i64,
        /// What is missing.
        what: &'static str,
    },
    /// A plan would have more steps than one can have.
    #[error(
        "time steps of {dt} s are too short: a horizon of {horizon} s needs {:.0} steps, but a plan has at most {MOST_STEPS}; shorten --horizon",
        horizon / dt
    )]
    TooFine {
        /// Seconds between two steps.
        dt: f64,
        /// How far ahead is planned, seconds.
        horizon: f64,
    },
}

/// The state a problem starts with.
///
/// Files made of SUMO's traffic say a yaw rate of exactly 0 in every curve; the wheels are then taken to stand as the
/// path bends. A yaw rate that is not 0 is kept.
pub(super) fn start(
    problem: &PlanningProblem,
    guide: &ReferenceTrack,
    limits: &Limits,
) -> Option<VehicleState> {
    let initial = &problem.initial;
    let position = initial.point()?;
    let velocity = initial.velocity?.middle();
    let motion = Motion {
        pose: Pose {
            position,
            heading: initial.orientation?.middle(),
        },
        velocity,
        acceleration: initial.acceleration.map_or(0.0, |q| q.middle()),
    };
    let state = VehicleState::of_centre(&motion, 0.0, limits);
    let said = initial
        .quantity(StateField::YawRate)
        .map_or(0.0, |q| q.middle());
    let curvature = if said != 0.0 && velocity.abs() > SLOW {
        said / velocity
    } else {
        guide.curvature_at(&state).unwrap_or(0.0)
    };
    let most = limits.curvature();
    Some(VehicleState {
        curvature: curvature.clamp(-most, most),
        ..state
    })
}

/// Below this speed a yaw rate does not tell how the wheels stand, m/s.
const SLOW: f64 = 0.1;

impl Rollout {
    /// Whether it ends with a contact with this obstacle.
    #[must_use]
    pub fn touches(&self, obstacle: i64) -> bool {
        matches!(self.outcome, Outcome::Collision(collision) if collision.with == obstacle)
    }

    /// The motion of the body's centre.
    #[must_use]
    pub fn track(&self) -> Track {
        let samples = self.states.iter().map(|(step, state)| {
            let motion = state.centre(&self.limits);
            Sample {
                step: *step,
                position: motion.pose.position,
                heading: Some(motion.pose.heading),
                velocity: Some(motion.velocity),
                acceleration: Some(motion.acceleration),
            }
        });
        Track::new(samples.collect(), self.dt, None)
    }
}

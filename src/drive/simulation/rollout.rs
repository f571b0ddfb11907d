//! A drive as data: its request, its steps and how it ended. The loop itself is in `closed_loop`.

use std::time::Duration;

use super::{DrivenTraffic, ExternalReport, Outcome, TrafficMode};
use crate::planner::{
    self, Forecast, Limits, MOST_STEPS, Memory, Plan, ReferenceTrack, ReferenceTrackError,
    VehicleState,
};
use nearmiss_base::geometry::Pose;
use nearmiss_scene::scenario::{Motion, PlanningProblem, Sample, StateField, Track};

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

/// Coarse drives plan anew after this time, seconds.
const COARSE: f64 = 0.2;

impl Settings {
    /// For drives that only select what is worth a whole one, with steps of `dt` seconds: fewer samples, see
    /// [`planner::Sampling::coarse`], and no new plan before 0.2 s are over.
    #[must_use]
    pub fn coarse(self, dt: f64) -> Self {
        let mut coarse = self;
        coarse.planner.sampling = self.planner.sampling.coarse();
        coarse.replan = self.replan.max((COARSE / dt).round() as usize);
        coarse
    }
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

/// A drive, and what the planner carried from cycle to cycle: enough to drive on from any of them.
#[derive(Debug, Clone)]
pub struct ResumableRollout {
    /// The drive.
    pub drive: Rollout,
    /// The planner's memory after each cycle.
    pub(super) memories: Vec<Memory>,
    /// Cycles at its beginning that were not planned but taken over from another drive.
    pub taken_over: usize,
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
        "time steps of {dt} s are too short: a horizon of {horizon} s needs {:.0} steps, but a plan has at most {MOST_STEPS}; shorten the horizon",
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

impl ResumableRollout {
    /// A cycle that can be taken over, and the planner's memory after it.
    pub(super) fn cycle(&self, place: usize, step: i64, same: i64) -> Option<(&Cycle, &Memory)> {
        let cycle = self.drive.cycles.get(place)?;
        let usable = cycle.step == step && step <= same;
        usable.then(|| self.memories.get(place).map(|memory| (cycle, memory)))?
    }

    /// Steps until the cycle after this one.
    pub(super) fn driven_of(&self, place: usize) -> Option<usize> {
        let [this, next] = self.drive.cycles.get(place..place + 2)? else {
            return None;
        };
        Some((next.step - this.step) as usize)
    }
}

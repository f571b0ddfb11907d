//! A drive as data: its request, its steps, how it ended, its figures; as the ego of a scene and as a CommonRoad solution.

use std::sync::Arc;
use std::time::Duration;

use nearmiss_base::geometry::Pose;
use nearmiss_formats::commonroad::{ProblemSolution, Solution, SolutionError};
use nearmiss_scene::metrics::{Contact, Impact, Series, measure};
use nearmiss_scene::scenario::{
    Diagnostic, Ego, EgoSource, Header, Motion, PlanningProblem, Sample, Scenario, Scene, Severity,
    StateField, Track, VehicleModel, VehicleType,
};
use nearmiss_scene::traffic_rules::RuleReport;
use strum::{IntoStaticStr, VariantArray};

use super::{
    Collision, ContactSide, DrivenTraffic, ExternalReport, PlannerError, Policy, TrafficMode,
};
use crate::planner::{
    self, Broken, Feasibility, Forecast, Limits, MOST_STEPS, Memory, Plan, ReferenceTrack,
    ReferenceTrackError, Road, VehicleState,
};

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
    /// The rule that drives instead of a planner.
    pub policy: Option<Policy>,
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
    let curvature = if said != 0.0 && velocity.abs() > MIN_SPEED {
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
const MIN_SPEED: f64 = 0.1;

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

/// Outcome of a drive.
#[derive(Debug, Clone, Copy, PartialEq, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum Outcome {
    /// The goal with this place among the problem's was reached.
    Goal(usize),
    /// The ego's body touched an obstacle's.
    Collision(Collision),
    /// The last step at which a goal could be reached went by.
    Timeout,
    /// The ego's body left the road.
    OffRoad,
    /// The vehicle cannot be driven from where it starts.
    Infeasible,
    /// The planner's process failed.
    PlannerError(PlannerError),
}

impl Outcome {
    /// Its name on the command line and in tables.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.into()
    }

    /// Whether a drive may end so: at the goal, or out of time, without harm. Such a drive solves its problem.
    #[must_use]
    pub fn is_unharmed(&self) -> bool {
        matches!(self, Self::Goal(_) | Self::Timeout)
    }
}

impl std::fmt::Display for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Goal(_) => f.write_str("goal reached"),
            Self::Collision(collision) => write!(f, "collision with {collision}"),
            Self::Timeout => f.write_str("goal not reached in time"),
            Self::OffRoad => f.write_str("off the road"),
            Self::Infeasible => f.write_str("no feasible motion"),
            Self::PlannerError(error) => error.fmt(f),
        }
    }
}

impl Rollout {
    /// The solution of planning problem `problem` of the scenario with this header: states of `model` for `vehicle`.
    ///
    /// # Errors
    /// The model has states that do not follow from the motion of a body.
    pub fn solution(
        &self,
        header: &Header,
        problem: i64,
        model: VehicleModel,
        vehicle: VehicleType,
    ) -> Result<Solution, SolutionError> {
        let solved = ProblemSolution::of_track(&self.track(), self.dt, problem, model, vehicle)?;
        Ok(Solution::of_problem(header, solved))
    }
}

impl Rollout {
    /// The ego that drove it; nothing where the vehicle has no body.
    ///
    /// Its source says that it was planned, by what and under which forecast; how the drive ended is a diagnostic.
    #[must_use]
    pub fn ego(&self, problem: &PlanningProblem, settings: &Settings) -> Ego {
        let outcome = Diagnostic {
            severity: Severity::Note,
            line: 0,
            element: String::new(),
            message: match &self.external {
                None => format!("the planned drive ended with: {}", self.outcome),
                Some(report) => format!(
                    "the drive planned by {} ended with: {}",
                    report.planner, self.outcome
                ),
            },
        };
        Ego {
            id: problem.id,
            source: EgoSource::Planned {
                planner: match settings.policy {
                    Some(policy) => Some(policy.name().into()),
                    None => self.external.as_ref().map(|report| report.named()),
                },
                vehicle: settings.planner.vehicle.name().into(),
                forecast: settings.forecast.name().into(),
                planning_problem: problem.id,
            },
            footprint: Road::body_of(&self.limits),
            track: self.track(),
            recorded: Vec::new(),
            diagnostics: vec![outcome],
        }
    }
}

/// Which body drove into which, after the sides that touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum CollisionKind {
    /// The ego's front touches: it ran into the obstacle.
    RanInto,
    /// The obstacle's front touches the ego's rear: the ego was rear-ended, in recorded traffic by an obstacle that
    /// does not see it.
    RearEnded,
    /// Neither: a side of the ego, or its rear by another side than the front.
    Side,
}

nearmiss_record::named!(CollisionKind);

impl Collision {
    /// Which body drove into which.
    #[must_use]
    pub fn kind(&self) -> CollisionKind {
        match (self.ego, self.other) {
            (ContactSide::Front, _) => CollisionKind::RanInto,
            (ContactSide::Rear, ContactSide::Front) => CollisionKind::RearEnded,
            _ => CollisionKind::Side,
        }
    }
}

/// What of a drive is beyond the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeyondVehicle {
    /// Steps at which a limit is broken.
    pub steps: usize,
    /// The first of them, with the limit that is broken most there, relative to its value.
    pub first: Broken,
    /// Of all steps the limit that is broken most.
    pub worst: Broken,
}

impl std::fmt::Display for BeyondVehicle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (steps, worst) = (self.steps, &self.worst);
        let plural = if steps == 1 { "" } else { "s" };
        let (name, unit) = (worst.bound.name(), worst.bound.unit());
        write!(
            f,
            "{steps} step{plural} beyond the vehicle, worst: {name} {:.2} {unit} at step {}, at most {:.2}",
            worst.value, worst.step, worst.most
        )
    }
}

/// Risk scores at which an obstacle counts as a near miss: 1, or 0 without a contact at a step.
const NEAR_MISS: u8 = 1;

impl Rollout {
    /// Absolute values of the change of acceleration from step to step, m/s³: mean and largest; `None` for fewer than
    /// three states.
    #[must_use]
    pub fn jerk(&self) -> Option<(f64, f64)> {
        let pairs = self.states.windows(2).skip(1);
        // The first state is the scenario's: what a planner makes of its acceleration is no jerk of the planner.
        let jerks = pairs.map(|pair| (pair[1].1.acceleration - pair[0].1.acceleration).abs());
        let jerks: Vec<f64> = jerks.map(|change| change / self.dt).collect();
        let most = jerks.iter().copied().max_by(f64::total_cmp)?;
        Some((jerks.iter().sum::<f64>() / jerks.len() as f64, most))
    }

    /// The strongest braking, m/s²; 0 without braking.
    #[must_use]
    pub fn largest_deceleration(&self) -> f64 {
        let states = self.states.iter();
        states.map(|(_, s)| -s.acceleration).fold(0.0, f64::max)
    }

    /// Seconds from the start to the goal; `None` for a drive that does not reach it.
    #[must_use]
    pub fn seconds_to_goal(&self) -> Option<f64> {
        let steps = self.states.len().saturating_sub(1);
        matches!(self.outcome, Outcome::Goal(_)).then(|| steps as f64 * self.dt)
    }

    /// The steps of the drive that the vehicle cannot do; `None` where it can do all.
    #[must_use]
    pub fn beyond_vehicle(&self) -> Option<BeyondVehicle> {
        let broken = self.undrivable();
        let first_step = broken.first()?.step;
        let worst = |among: &mut dyn Iterator<Item = &Broken>| {
            // Of equals the first.
            let all = among.copied();
            all.reduce(|a, b| if b.excess() > a.excess() { b } else { a })
        };
        let mut steps: Vec<i64> = broken.iter().map(|one| one.step).collect();
        steps.dedup();
        Some(BeyondVehicle {
            steps: steps.len(),
            first: worst(&mut broken.iter().filter(|one| one.step == first_step))?,
            worst: worst(&mut broken.iter())?,
        })
    }

    /// What of the drive the vehicle cannot do, in order; empty where it can do all.
    #[must_use]
    pub fn undrivable(&self) -> Vec<Broken> {
        let first = self.states.first().map_or(0, |(step, _)| *step);
        let states: Vec<_> = self.states.iter().map(|(_, state)| *state).collect();
        match Feasibility::new(self.limits, self.dt).states(first, &states) {
            Ok(_) => Vec::new(),
            Err(error) => error.0,
        }
    }

    /// Obstacles whose risk score is 1 or 0 at some step of the drive, without the one that is touched at its end.
    #[must_use]
    pub fn near_misses(
        &self,
        scenario: &Arc<Scenario>,
        problem: &PlanningProblem,
        settings: &Settings,
    ) -> Vec<i64> {
        let scene = self.scene(scenario, problem, settings);
        let series = Series::compute(&scene, measure("risk").into_iter().collect());
        let near = |id: &i64| {
            let mut readings = series.row("risk", *id).iter();
            let is_near = readings.any(|r| r.value().is_some_and(|v| v as u8 <= NEAR_MISS));
            is_near && !self.touches(*id)
        };
        let ids = scene.scenario.obstacles.iter().map(|o| o.id);
        ids.filter(near).collect()
    }

    /// How hard the contact is that ends it.
    #[must_use]
    pub fn impact(
        &self,
        scenario: &Arc<Scenario>,
        problem: &PlanningProblem,
        settings: &Settings,
    ) -> Option<Impact> {
        let Outcome::Collision(collision) = self.outcome else {
            return None;
        };
        let scene = self.scene(scenario, problem, settings);
        let mut others = scene.participants();
        let other = others.find(|other| other.obstacle.id == collision.with)?;
        Some(Contact::in_drive(&scene, &other, collision.step)?.impact)
    }

    /// Which rules of the road applied, and which were broken. They are not judged where a step ends that the vehicle
    /// cannot do: speed and place there are none that the ego could have.
    #[must_use]
    pub fn rules(
        &self,
        scenario: &Arc<Scenario>,
        problem: &PlanningProblem,
        settings: &Settings,
    ) -> RuleReport {
        let report = RuleReport::from_scene(&self.scene(scenario, problem, settings));
        // An acceleration is that of the step behind a state or of the one before it.
        let broken = self.undrivable();
        let steps = broken.iter().flat_map(|one| [one.step, one.step + 1]);
        report.unjudged_at(&steps.collect(), "the ego moves there as no vehicle can")
    }

    /// The scene of the drive, without the obstacle whose place the ego takes.
    fn scene(
        &self,
        scenario: &Arc<Scenario>,
        problem: &PlanningProblem,
        settings: &Settings,
    ) -> Scene {
        let scenario = match settings.without {
            Some(gone) => {
                let mut others = Scenario::clone(scenario);
                others.obstacles.retain(|o| o.id != gone);
                Arc::new(others)
            }
            None => Arc::clone(scenario),
        };
        Scene::new(scenario, self.ego(problem, settings))
    }
}

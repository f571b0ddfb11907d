//! The closed loop: plan, advance, check, until the drive ends; all of a problem or a stretch of it, watched and controlled.

use std::sync::Arc;
use std::time::Instant;

use nearmiss_base::geometry::angle_between;
use nearmiss_scene::scenario::{Motion, PlanningProblem, Scenario, Scene, Track};

use super::external::{ExternalPlanner, ExternalReport, NoTrajectory, PlannerError, Session};
use super::policy::Seat;
use super::rollout::start;
use super::traffic::World;
use super::{
    Collision, Cycle, DriveError, DrivenTraffic, EndOfDriveCheck, Outcome, ResumableRollout,
    Rollout, Settings, TrafficMode,
};
use crate::planner::{
    Cancel, ForecastCache, Forecaster, Limits, Planner, ReferenceTrack, Road, VehicleState,
};

/// Drives one planning problem as often as one likes, through any traffic on the same road.
///
/// The way to the goal and the road are worked out once: they depend on the network only, so a scenario with other
/// traffic, but the same network and time step, may be given to each drive.
#[derive(Debug, Clone)]
pub struct Driver {
    problem: PlanningProblem,
    settings: Settings,
    guide: ReferenceTrack,
    road: Arc<Road>,
    limits: Limits,
    start: VehicleState,
    last: i64,
    dt: f64,
    cancel: Cancel,
    /// With the ego as it was recorded.
    recorded: Option<Arc<Scene>>,
    /// The planner; the built-in one where none is named.
    external: Option<Arc<ExternalPlanner>>,
    /// Forecasts that its drives share.
    forecasts: Option<Arc<ForecastCache>>,
}

/// Longest drive, steps; a later deadline is treated as unreasonable.
pub const MOST_DRIVEN: i64 = 1000;

/// Where a drive begins, and when it ends at the latest and at the earliest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveSpan {
    /// The first time step.
    pub step: i64,
    /// The vehicle there.
    pub state: VehicleState,
    /// The last time step; a drive that gets there is a time-out, unless it reached a goal.
    pub last: i64,
    /// A goal that was reached ends the drive at this step or later, and not before.
    pub goal_from: i64,
}

/// Sees each cycle with its planner, and says whether to go on.
pub(super) type WatchCycle<'a> = dyn FnMut(&Planner<'_>, &Cycle) -> bool + 'a;

impl Driver {
    /// A driver for a problem of `scenario`.
    ///
    /// # Errors
    /// The problem has no start or no goal, or no way leads to it; a plan would have too many steps.
    pub fn new(
        scenario: &Scenario,
        problem: &PlanningProblem,
        settings: &Settings,
    ) -> Result<Self, DriveError> {
        let dt = scenario.dt();
        if !settings.planner.fits(dt) {
            let horizon = settings.planner.horizon;
            return Err(DriveError::TooFine { dt, horizon });
        }
        let graph = scenario.network.lane_graph(None);
        let guide = ReferenceTrack::for_problem(scenario, &graph, problem)?;
        let limits = Limits::for_vehicle(settings.planner.vehicle);
        let start = start(problem, &guide, &limits).ok_or(DriveError::NoStart {
            problem: problem.id,
            what: "position, heading and velocity",
        })?;
        let last = problem.deadline().ok_or(DriveError::NoGoal {
            problem: problem.id,
        })?;
        Ok(Self {
            road: Arc::new(Road::new(&scenario.network, &limits)),
            problem: problem.clone(),
            settings: *settings,
            guide,
            limits,
            start,
            last: last.min(problem.initial.time.from.saturating_add(MOST_DRIVEN)),
            dt,
            cancel: Cancel::default(),
            recorded: None,
            external: None,
            forecasts: None,
        })
    }

    /// The same driver, whose drives in `scenario` and in changes of it share the forecasts of what moves as recorded:
    /// many of them take less time, and none of them is another one.
    #[must_use]
    pub fn sharing_forecasts(mut self, scenario: &Arc<Scenario>) -> Self {
        self.forecasts = Some(Arc::new(ForecastCache::new(
            Arc::clone(scenario),
            self.settings.forecast,
            self.settings.without,
            self.settings.planner.steps(self.dt),
            (self.problem.initial.time.from, self.last),
        )));
        self
    }

    /// The same driver, which knows how the ego of its problem was recorded: traffic that reacts then tells what the
    /// recording does itself from what is new.
    #[must_use]
    pub fn with_recorded(self, recorded: Option<Arc<Scene>>) -> Self {
        Self { recorded, ..self }
    }

    /// The scene with the ego as it was recorded, if it is known.
    #[must_use]
    pub fn recorded(&self) -> Option<&Scene> {
        self.recorded.as_deref()
    }

    /// The same driver, which asks this planner instead of the built-in one.
    #[must_use]
    pub fn driven_by(mut self, planner: Option<Arc<ExternalPlanner>>) -> Self {
        self.external = planner;
        self
    }

    /// The planner that is asked; `None` for the built-in one.
    #[must_use]
    pub fn external(&self) -> Option<&ExternalPlanner> {
        self.external.as_deref()
    }

    /// The same driver, whose drives end early when `cancel` asks for it: they are to be dropped then.
    #[must_use]
    pub fn cancelled_by(mut self, cancel: &Cancel) -> Self {
        self.cancel = cancel.clone();
        self
    }

    /// The same driver among others that do this.
    #[must_use]
    pub fn in_traffic(mut self, traffic: TrafficMode) -> Self {
        self.settings.traffic = traffic;
        self
    }

    /// Whether its drives are to end early.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_asked()
    }

    /// The built-in planner with other settings, but the same vehicle.
    #[must_use]
    pub fn with(&self, settings: &Settings) -> Self {
        let mut other = self.clone().driven_by(None);
        other.settings = *settings;
        other.settings.planner.vehicle = self.settings.planner.vehicle;
        other
    }

    /// The planning problem.
    #[must_use]
    pub fn problem(&self) -> &PlanningProblem {
        &self.problem
    }

    /// How it drives.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// What it follows.
    #[must_use]
    pub fn guide(&self) -> &ReferenceTrack {
        &self.guide
    }

    /// What it keeps to.
    #[must_use]
    pub fn road(&self) -> &Road {
        &self.road
    }

    /// Whole limits of the vehicle.
    #[must_use]
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Seconds between two time steps.
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// The whole of the problem, from its start to the last step at which a goal can be reached, or to the
    /// [`MOST_DRIVEN`]th step.
    #[must_use]
    pub fn full_span(&self) -> DriveSpan {
        let step = self.problem.initial.time.from;
        DriveSpan {
            step,
            state: self.start,
            last: self.last,
            goal_from: step,
        }
    }

    /// Lets the planner's process say what it is, without a drive; `None` for the built-in planner.
    #[must_use]
    pub fn greet(&self, scenario: &Scenario) -> Option<ExternalReport> {
        let session = Session::new(self.external()?, self, scenario, &self.full_span());
        Some(session.greet(&self.cancel))
    }

    pub(super) fn run(
        &self,
        scenario: &Scenario,
        stretch: &DriveSpan,
        known: Option<(&ResumableRollout, i64)>,
        watch: Option<&mut WatchCycle<'_>>,
        control: &mut dyn FnMut(&Rollout) -> Control,
    ) -> ResumableRollout {
        let external = self.external.as_deref();
        let session = external.map(|planner| Session::new(planner, self, scenario, stretch));
        // A process that remembers has to see every cycle.
        let known = known.filter(|_| external.is_none_or(ExternalPlanner::is_stateless));
        let mut session = session;
        let mut noted = self.steps(scenario, stretch, known, watch, control, session.as_mut());
        noted.drive.external = session.map(|session| Box::new(session.end()));
        noted
    }

    fn steps(
        &self,
        scenario: &Scenario,
        stretch: &DriveSpan,
        known: Option<(&ResumableRollout, i64)>,
        mut watch: Option<&mut WatchCycle<'_>>,
        control: &mut dyn FnMut(&Rollout) -> Control,
        mut session: Option<&mut Session<'_>>,
    ) -> ResumableRollout {
        let (forecast, without) = (self.settings.forecast, self.settings.without);
        let mut world = World::new(self, scenario);
        let mut planner = Planner::new(self.settings.planner, &self.guide, &self.road, self.dt)
            .cancelled_by(&self.cancel);
        if watch.is_none() {
            // The other candidates are not shown.
            planner = planner.only_best();
        }
        let (mut step, mut state, last) = (stretch.step, stretch.state, stretch.last);
        let mut noted = ResumableRollout {
            drive: Rollout {
                states: vec![(step, state)],
                cycles: Vec::new(),
                outcome: Outcome::Timeout,
                traffic: DrivenTraffic::default(),
                limits: self.limits,
                dt: self.dt,
                external: None,
            },
            memories: Vec::new(),
            taken_over: 0,
        };
        let mut look = EndOfDriveCheck::new(self, scenario, stretch.goal_from);
        if let Some(outcome) = look.at(step, &state) {
            noted.drive.outcome = outcome;
            return noted;
        }
        let mut seat = self
            .settings
            .policy
            .map(|policy| Seat::new(policy, self, &state));
        'drive: while step < last {
            let asked = control(&noted.drive);
            match asked {
                Control::Follow if seat.is_none() => {}
                Control::Stop => break 'drive,
                Control::Brake | Control::Follow => {
                    state = match &mut seat {
                        Some(seat) if asked == Control::Follow => {
                            seat.step(noted.drive.scenario_in(scenario), step, &state)
                        }
                        _ => planner.full_braking(&state),
                    };
                    step += 1;
                    noted.drive.states.push((step, state));
                    world.advance(&mut noted.drive);
                    let there = noted.drive.scenario_in(scenario);
                    if let Some(outcome) = look.at_in(there, step, &state) {
                        noted.drive.outcome = outcome;
                        break;
                    }
                    continue;
                }
            }
            let place = noted.drive.cycles.len();
            let cycle = match known.and_then(|(before, same)| before.cycle(place, step, same)) {
                Some((cycle, memory)) => {
                    planner.recall(memory);
                    noted.taken_over += 1;
                    cycle.clone()
                }
                None if let Some(session) = &mut session => {
                    let there = noted.drive.scenario_in(scenario);
                    match session.plan(there, &state, step, &self.cancel) {
                        Ok(cycle) => cycle,
                        Err(none) => {
                            noted.drive.outcome = without_plan(&none, step);
                            break 'drive;
                        }
                    }
                }
                None => {
                    let there = noted.drive.scenario_in(scenario);
                    let forecaster =
                        Forecaster::new(there, forecast, without).cached(self.forecasts.as_deref());
                    let traffic = forecaster.traffic(step, planner.steps());
                    let began = Instant::now();
                    let plan = planner.plan(&state, step, &traffic);
                    let took = began.elapsed();
                    planner.keep_told(traffic);
                    if self.is_cancelled() {
                        break 'drive;
                    }
                    Cycle {
                        step,
                        plan,
                        took,
                        late: 0,
                    }
                }
            };
            let more = watch.as_mut().is_none_or(|watch| watch(&planner, &cycle));
            let mut ahead = self.ahead(&cycle);
            if noted.taken_over > place
                && let Some(driven) = known.and_then(|(before, _)| before.driven_of(place))
            {
                // Another driver may have planned more often.
                ahead.truncate(driven);
            }
            noted.drive.cycles.push(cycle);
            noted.memories.push(planner.memory());
            if ahead.is_empty() {
                noted.drive.outcome = Outcome::Infeasible;
                break;
            }
            if !more {
                break;
            }
            for next in ahead {
                step += 1;
                state = next;
                noted.drive.states.push((step, state));
                world.advance(&mut noted.drive);
                let there = noted.drive.scenario_in(scenario);
                if let Some(outcome) = look.at_in(there, step, &state) {
                    noted.drive.outcome = outcome;
                    break 'drive;
                }
                // The control is asked again above.
                if step >= last || control(&noted.drive) != Control::Follow {
                    break;
                }
            }
        }
        world.finish(&mut noted.drive);
        noted
    }

    /// The states of a plan that are driven before the next one.
    fn ahead(&self, cycle: &Cycle) -> Vec<VehicleState> {
        let ahead = cycle.plan.states.iter().skip(1);
        let driven = self.settings.replan.max(cycle.late).max(1);
        ahead.take(driven).copied().collect()
    }
}

/// How a drive ends at a step where its planner's process has no trajectory.
fn without_plan(none: &NoTrajectory, step: i64) -> Outcome {
    match none {
        // It is to be dropped.
        NoTrajectory::Cancelled => Outcome::Timeout,
        NoTrajectory::Infeasible => Outcome::Infeasible,
        NoTrajectory::Fault(fault) => Outcome::PlannerError(PlannerError {
            fault: *fault,
            step,
        }),
    }
}

/// What is wrong with a motion through a scenario.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum MotionFault {
    /// It touches an obstacle.
    #[error("touches {0}")]
    Contact(Collision),
    /// It leaves the road at a step.
    #[error("leaves the road at step {0}")]
    OffRoad(i64),
}

/// Below this way (m) in a step the heading tells nothing about the steering.
const MIN_MOVE: f64 = 0.01;

impl Driver {
    /// Drives a stretch, and shows each cycle with its planner to `watch`; where that says no, the drive is a time-out
    /// there.
    pub fn drive_watched(
        &self,
        scenario: &Scenario,
        stretch: &DriveSpan,
        watch: &mut dyn FnMut(&Planner<'_>, &Cycle) -> bool,
    ) -> Rollout {
        self.run(scenario, stretch, None, Some(watch), &mut |_| {
            Control::Follow
        })
        .drive
    }

    /// A motion of the vehicle's centre as a drive in recorded traffic, from the problem's start on: it ends as a planned
    /// one would, without a cycle.
    #[must_use]
    pub fn along(&self, scenario: &Scenario, track: &Track) -> Rollout {
        let span = self.full_span();
        let mut look = EndOfDriveCheck::new(self, scenario, span.goal_from);
        let mut drive = Rollout {
            states: Vec::new(),
            cycles: Vec::new(),
            outcome: Outcome::Timeout,
            traffic: DrivenTraffic::default(),
            limits: *self.limits(),
            dt: self.dt(),
            external: None,
        };
        let mut before: Option<Motion> = None;
        for (step, motion) in track.iter() {
            if step < span.step || step > span.last {
                continue;
            }
            let turn = before.map_or(0.0, |before| {
                let way = (motion.pose.position - before.pose.position).norm();
                let turned = angle_between(before.pose.heading, motion.pose.heading);
                if way > MIN_MOVE { turned / way } else { 0.0 }
            });
            before = Some(*motion);
            let state = VehicleState::of_centre(motion, turn, self.limits());
            drive.states.push((step, state));
            if let Some(outcome) = look.at(step, &state) {
                drive.outcome = outcome;
                break;
            }
        }
        drive
    }

    /// What is wrong with a motion of the vehicle's centre in `scenario`: the first contact with an obstacle, at a step
    /// or between two, or that it leaves the road that it was on.
    #[must_use]
    pub fn fault_of(&self, scenario: &Scenario, track: &Track) -> Option<MotionFault> {
        // A goal ends nothing here.
        let mut look = EndOfDriveCheck::new(self, scenario, i64::MAX);
        track.iter().find_map(|(step, motion)| {
            let state = VehicleState::of_centre(motion, 0.0, self.limits());
            match look.at(step, &state) {
                Some(Outcome::Collision(contact)) => Some(MotionFault::Contact(contact)),
                Some(Outcome::OffRoad) => Some(MotionFault::OffRoad(step)),
                _ => None,
            }
        })
    }

    /// Drives the whole problem under a control, which is asked at every step before it, perhaps more than once, and
    /// sees the drive until then.
    pub fn drive_controlled(
        &self,
        scenario: &Scenario,
        control: &mut dyn FnMut(&Rollout) -> Control,
        watch: &mut dyn FnMut(&Planner<'_>, &Cycle) -> bool,
    ) -> Rollout {
        self.run(scenario, &self.full_span(), None, Some(watch), control)
            .drive
    }

    /// Drives a stretch.
    #[must_use]
    pub fn drive(&self, scenario: &Scenario, stretch: &DriveSpan) -> Rollout {
        self.run(scenario, stretch, None, None, &mut |_| Control::Follow)
            .drive
    }

    /// Drives the whole problem, so that other drives can take over its first cycles.
    #[must_use]
    pub fn drive_noted(&self, scenario: &Scenario, until: i64) -> ResumableRollout {
        self.run(scenario, &self.until(until), None, None, &mut |_| {
            Control::Follow
        })
    }

    /// The same; `watch` sees each cycle with its planner; where that says no, the drive is a time-out there.
    #[must_use]
    pub fn drive_noted_watched(
        &self,
        scenario: &Scenario,
        until: i64,
        watch: &mut dyn FnMut(&Planner<'_>, &Cycle) -> bool,
    ) -> ResumableRollout {
        self.run(scenario, &self.until(until), None, Some(watch), &mut |_| {
            Control::Follow
        })
    }

    /// Drives the whole problem in traffic of which the planner is told the same as in the drive `before` in every
    /// cycle up to step `same`: those cycles are taken over instead of being planned again.
    ///
    /// The drive is exactly that of [`Self::drive_noted`], but for the times that cycles took: planning depends on
    /// the vehicle's state, on what is told of the traffic and on what the planner carries from cycle to cycle, and on
    /// nothing else. Contacts and arrivals are looked for at every step again.
    #[must_use]
    pub fn drive_again(
        &self,
        scenario: &Scenario,
        before: &ResumableRollout,
        same: i64,
        until: i64,
    ) -> ResumableRollout {
        self.run(
            scenario,
            &self.until(until),
            Some((before, same)),
            None,
            &mut |_| Control::Follow,
        )
    }

    /// The whole drive, but no farther than to step `until`.
    fn until(&self, until: i64) -> DriveSpan {
        let whole = self.full_span();
        DriveSpan {
            last: whole.last.min(until),
            ..whole
        }
    }
}

/// What the ego does in the next step of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Control {
    /// It follows the planner.
    Follow,
    /// It brakes fully along its path: see [`Planner::full_braking`](crate::planner::Planner::full_braking).
    Brake,
    /// The drive ends here, and is to be dropped.
    Stop,
}

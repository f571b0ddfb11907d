//! One drive with a planner's process: hello, a plan each cycle, what became of it, and what is known of it afterwards.

use std::time::{Duration, Instant};

use nearmiss_base::geometry::{Pose, normalize_angle};
use nearmiss_scene::scenario::Scenario;

use super::messages::{SceneMessageBuilder, hello};
use super::process::{NoLine, Peer};
use super::protocol::{Answer, Bye, Message, Ready, Trajectory};
use super::reading::{Reader, answer, joined, ready, shown};
use super::{Clock, ExternalPlanner, Fault, NoTrajectory, PlannerFault};
use crate::planner::{Cancel, Cost, Plan, VehicleState};
use crate::simulation::{Cycle, DriveSpan, Driver};

/// In real time, what is between the ego and a trajectory that came late goes to nothing within this, seconds.
const JOINED_WITHIN: f64 = 1.0;

/// A late answer is waited for in real time at most this long, as seconds of the drive.
const STRAIGHT_ON: f64 = 4.0;

/// A drive with a planner's process, which starts at the first cycle.
pub(in crate::simulation) struct Session<'a> {
    planner: &'a ExternalPlanner,
    driver: &'a Driver,
    scenario: &'a Scenario,
    span: DriveSpan,
    running: Option<(Peer, Ready)>,
    report: ExternalReport,
    /// In real time: what is driven until the next answer counts, from its step on.
    in_force: Option<(i64, Vec<VehicleState>)>,
}

impl<'a> Session<'a> {
    pub fn new(
        planner: &'a ExternalPlanner,
        driver: &'a Driver,
        scenario: &'a Scenario,
        span: &DriveSpan,
    ) -> Self {
        Self {
            planner,
            driver,
            scenario,
            span: *span,
            running: None,
            report: ExternalReport::new(planner),
            in_force: None,
        }
    }

    /// A cycle at `step`, where the ego is in `state` among the traffic of `scenario`: how long it drives, and what.
    pub fn plan(
        &mut self,
        scenario: &Scenario,
        state: &VehicleState,
        step: i64,
        cancel: &Cancel,
    ) -> Result<Cycle, NoTrajectory> {
        match self.try_plan(scenario, state, step, cancel) {
            Err(Stop::Fault(fault)) => {
                wait_for_last_words(&fault);
                if let Some((peer, _)) = self.running.take() {
                    self.report.stderr = peer.last_words();
                }
                let kind = fault.fault;
                self.report.fail(&fault, step);
                Err(NoTrajectory::Fault(kind))
            }
            Err(Stop::Cancelled) => {
                self.running = None;
                Err(NoTrajectory::Cancelled)
            }
            Err(Stop::Infeasible(message)) => {
                self.report.message = Some(message);
                Err(NoTrajectory::Infeasible)
            }
            Ok(cycle) => Ok(cycle),
        }
    }

    /// Starts the process and says hello, without a drive; what it said of itself, or its fault.
    pub fn greet(mut self, cancel: &Cancel) -> ExternalReport {
        if let Err(Stop::Fault(fault)) = self.start(cancel) {
            let step = self.span.step;
            self.report.fail(&fault, step);
        }
        self.end()
    }

    /// Gives the process back or ends it; what became of the drive.
    pub fn end(mut self) -> ExternalReport {
        if let Some((mut peer, ready)) = self.running.take() {
            self.report.stderr = if ready.reusable && peer.is_waiting() {
                let written = peer.stderr();
                self.planner.put_back(peer);
                written
            } else {
                peer.end(bye())
            };
        }
        self.report
    }

    fn try_plan(
        &mut self,
        scenario: &Scenario,
        state: &VehicleState,
        step: i64,
        cancel: &Cancel,
    ) -> Result<Cycle, Stop> {
        if self.running.is_none() {
            self.start(cancel)?;
        }
        let Some((peer, ready)) = &mut self.running else {
            return Err(Fault::new(PlannerFault::NotStarted, "").into());
        };
        if let Some(unasked) = peer.unasked() {
            let details = format!("before it was asked at step {step}: {}", shown(&unasked));
            return Err(Fault::new(PlannerFault::Flood, details).into());
        }
        let teller = SceneMessageBuilder::new(self.driver, scenario, self.span.step, ready);
        let message = teller.message(state, step);
        let began = Instant::now();
        peer.send(line(&Message::Plan(&message)));
        let limit = self.planner.options.cycle;
        let text = peer
            .receive(limit, cancel)
            .map_err(|none| Stop::from_no_line(none, PlannerFault::CycleTimeout, limit))?;
        let trajectory = match answer(&text)? {
            Answer::Trajectory(trajectory) => trajectory,
            Answer::Error(refusal) if refusal.infeasible => {
                return Err(Stop::Infeasible(shown(&refusal.message)));
            }
            Answer::Error(refusal) => {
                return Err(Fault::new(PlannerFault::Refused, shown(&refusal.message)).into());
            }
            Answer::Ready(_) => {
                let details = "`ready` in answer to `plan`";
                return Err(Fault::new(PlannerFault::Nonsense, details).into());
            }
        };
        let reader = Reader {
            limits: self.driver.limits(),
            dt: self.driver.dt(),
            point: ready.reference_point,
        };
        let states = of_step(&trajectory, step).and_then(|()| reader.states(&trajectory, state))?;
        let took = began.elapsed();
        self.report.count(took, trajectory.ms);
        let (states, late) = self.in_time(states, state, step, took)?;
        self.reaches_next(&states, step, late)?;
        if self.planner.options.clock == Clock::Real {
            self.in_force = Some((step, states.clone()));
        }
        Ok(Cycle {
            step,
            plan: plan(states),
            took,
            late,
        })
    }

    fn start(&mut self, cancel: &Cancel) -> Result<(), Stop> {
        let began = Instant::now();
        let mut peer = self.planner.peer()?;
        let clock = self.planner.options.clock.name();
        let hello = hello(self.driver, self.scenario, &self.span, clock);
        peer.send(line(&Message::Hello(&hello)));
        let limit = self.planner.options.start;
        let text = peer.receive(limit, cancel);
        // Its last words are kept, whatever it answered.
        let ready = text
            .map_err(|none| Stop::from_no_line(none, PlannerFault::StartTimeout, limit))
            .and_then(|text| ready(&text).map_err(Stop::Fault));
        let mut ready = match ready {
            Ok(ready) => ready,
            Err(stop) => {
                if let Stop::Fault(fault) = &stop {
                    wait_for_last_words(fault);
                }
                self.report.stderr = peer.last_words();
                return Err(stop);
            }
        };
        ready.predictions |= self.planner.options.predictions;
        ready.history = ready.history.max(self.planner.options.history);
        self.report.greeted(&ready, began.elapsed());
        self.planner.remember(&ready);
        self.running = Some((peer, ready));
        Ok(())
    }

    /// In simulated time the trajectory itself; in real time what was driven until the answer was there, then the
    /// trajectory. Also how many steps that took.
    fn in_time(
        &mut self,
        planned: Vec<VehicleState>,
        state: &VehicleState,
        step: i64,
        took: Duration,
    ) -> Result<(Vec<VehicleState>, usize), Stop> {
        if self.planner.options.clock == Clock::Simulated {
            return Ok((planned, 0));
        }
        let dt = self.driver.dt();
        let late = (took.as_secs_f64() / dt).ceil().max(1.0) as usize;
        self.report.late_steps = self.report.late_steps.max(late);
        // Nothing is driven after the end.
        let left = usize::try_from(self.span.last - step).unwrap_or(0);
        let late = late.min(left.max(1));
        let mut actual = vec![*state];
        for later in 1..=late {
            let next = match &self.in_force {
                Some((from, states)) => {
                    let place = usize::try_from(step - from).unwrap_or(0) + later;
                    states.get(place).copied()
                }
                // Before the first trajectory it goes on as it was.
                None if later as f64 * dt <= STRAIGHT_ON => {
                    actual.last().map(|before| rolled(before, dt))
                }
                None => None,
            };
            let Some(next) = next else {
                let seconds = took.as_secs_f64();
                let details = format!("after {seconds:.2} s, {late} steps");
                return Err(Fault::new(PlannerFault::TooLate, details).into());
            };
            actual.push(next);
        }
        if planned.len() <= late {
            let covered = (planned.len() - 1) as f64 * dt;
            let details = format!("it covers {covered:.1} s and came {late} steps late");
            return Err(Fault::new(PlannerFault::TooShort, details).into());
        }
        let (states, off) = joined(&planned, &actual, late, dt, JOINED_WITHIN);
        self.report.largest_offset = self.report.largest_offset.max(off);
        Ok((states, late))
    }

    /// Whether a trajectory lasts until the next cycle, or the end of the drive.
    fn reaches_next(&self, states: &[VehicleState], step: i64, late: usize) -> Result<(), Stop> {
        let left = usize::try_from(self.span.last - step).unwrap_or(0);
        let needed = self.driver.settings().replan.max(late).max(1).min(left);
        let has = states.len() - 1;
        if has >= needed {
            return Ok(());
        }
        let details = format!("{has} steps after now; {needed} are driven before the next cycle");
        Err(Fault::new(PlannerFault::TooShort, details).into())
    }
}

/// What a planner says of its end on standard error may come a little after that.
fn wait_for_last_words(fault: &Fault) {
    use PlannerFault::{Died, Nonsense, Refused};
    if matches!(fault.fault, Died | Nonsense | Refused) {
        std::thread::sleep(LAST_WORDS);
    }
}

/// How long they are waited for.
const LAST_WORDS: Duration = Duration::from_millis(50);

/// Why a cycle has no trajectory.
enum Stop {
    Cancelled,
    Infeasible(String),
    Fault(Fault),
}

impl From<Fault> for Stop {
    fn from(fault: Fault) -> Self {
        Self::Fault(fault)
    }
}

impl Stop {
    fn from_no_line(none: NoLine, timeout: PlannerFault, limit: Duration) -> Self {
        match none {
            NoLine::Cancelled => Self::Cancelled,
            NoLine::Fault(fault) => Self::Fault(fault),
            NoLine::TimedOut => {
                let (option, key) = match timeout {
                    PlannerFault::StartTimeout => ("", "start_timeout"),
                    _ => ("--set timeout=SECONDS or ", "timeout"),
                };
                let details = format!(
                    "{} s; {option}`{key}` of [planner.NAME] in config.toml sets it",
                    limit.as_secs_f64()
                );
                Self::Fault(Fault::new(timeout, details))
            }
        }
    }
}

/// Whether a trajectory answers the request of this step.
fn of_step(trajectory: &Trajectory, step: i64) -> Result<(), Fault> {
    if trajectory.step == step {
        return Ok(());
    }
    let details = format!("it is for step {}, asked was step {step}", trajectory.step);
    // One more answer to an earlier request, or one to none.
    let fault = if trajectory.step < step {
        PlannerFault::Flood
    } else {
        PlannerFault::Nonsense
    };
    Err(Fault::new(fault, details))
}

/// The line that ends a planner.
pub(super) fn bye() -> Vec<u8> {
    line(&Message::Bye(Bye {}))
}

/// A line of a message; JSON has no line breaks inside.
fn line(message: &Message<'_>) -> Vec<u8> {
    // Numbers that are not finite become null; nothing else can fail.
    serde_json::to_vec(message).unwrap_or_default()
}

/// A step later with the same speed and the same steering.
fn rolled(state: &VehicleState, dt: f64) -> VehicleState {
    let way = state.velocity * dt;
    let middle = state.rear.heading + way * state.curvature / 2.0;
    let direction = Pose {
        heading: middle,
        ..state.rear
    };
    VehicleState {
        rear: Pose {
            position: state.rear.position + direction.forward() * way,
            heading: normalize_angle(state.rear.heading + way * state.curvature),
        },
        acceleration: 0.0,
        ..*state
    }
}

fn plan(states: Vec<VehicleState>) -> Plan {
    Plan {
        states,
        candidates: 0,
        feasible: 0,
        rejected: Vec::new(),
        refinements: 0,
        wanted: 0.0,
        cost: Cost::default(),
        emergency: None,
        hold: None,
    }
}

/// Characters of a planner's name that are kept.
const LONGEST_NAME: usize = 80;

/// Characters of the last line of standard error in a sentence.
const LONGEST_LAST_LINE: usize = 200;

/// A drive as seen from beside a planner's process.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ExternalReport {
    /// The planner as the user names it.
    pub planner: String,
    /// Its name and version as it said them; empty before it was ready.
    pub name: String,
    /// See `name`.
    pub version: String,
    /// Simulated or real time.
    pub clock: Clock,
    /// Whether obstacles came with predictions.
    pub predictions: bool,
    /// Earlier states that each obstacle came with, at most.
    pub history: usize,
    /// The fault that ended the drive.
    pub fault: Option<PlannerFault>,
    /// The time step at which there was no trajectory for this.
    pub fault_step: Option<i64>,
    /// The fault's details, or why nothing could be driven.
    pub message: Option<String>,
    /// The last lines of standard error.
    pub stderr: Vec<String>,
    /// From the start of the process to its `ready`; `None` where it never came.
    pub started_in: Option<Duration>,
    /// Time of each cycle beside what the planner itself measured, milliseconds; empty where it did not say.
    pub overhead_ms: Vec<f64>,
    /// In real time: the most steps until an answer counted.
    pub late_steps: usize,
    /// In real time: the largest distance between the ego and a trajectory that came late, metres.
    pub largest_offset: f64,
}

impl ExternalReport {
    pub(super) fn new(planner: &ExternalPlanner) -> Self {
        Self {
            planner: planner.name().to_string(),
            clock: planner.options.clock,
            ..Self::default()
        }
    }

    pub(super) fn greeted(&mut self, ready: &Ready, started_in: Duration) {
        self.name.clone_from(&ready.name);
        self.version.clone_from(&ready.version);
        self.predictions = ready.predictions;
        self.history = ready.history;
        self.started_in = Some(started_in);
    }

    pub(super) fn count(&mut self, took: Duration, own_ms: Option<f64>) {
        let took = took.as_secs_f64() * 1e3;
        let own = own_ms.filter(|own| (0.0..=took).contains(own));
        self.overhead_ms.extend(own.map(|own| took - own));
    }

    pub(super) fn fail(&mut self, fault: &Fault, step: i64) {
        self.fault = Some(fault.fault);
        self.fault_step = Some(step);
        self.message = Some(fault.details.clone()).filter(|details| !details.is_empty());
    }

    /// The planner with its version, as its process said them, on one line; else as the user names it.
    #[must_use]
    pub fn named(&self) -> String {
        let said = match (self.name.as_str(), self.version.as_str()) {
            ("", _) => self.planner.clone(),
            (name, "") => name.into(),
            (name, version) => format!("{name} {version}"),
        };
        let plain = said.chars().filter(|c| !c.is_control());
        plain.take(LONGEST_NAME).collect()
    }

    /// The fault in a sentence: its name, the time step, and its details; nothing without one.
    #[must_use]
    pub fn fault_in_words(&self) -> Option<String> {
        let fault = self.fault?;
        let step = self.fault_step.map(|step| format!(" at step {step}"));
        let name = format!("{}{}", fault.name(), step.unwrap_or_default());
        Some(match &self.message {
            Some(details) => format!("{name}: {fault}: {details}"),
            None => format!("{name}: {fault}"),
        })
    }

    /// The same with the last line of standard error, where the planner wrote one.
    #[must_use]
    pub fn failure(&self) -> Option<String> {
        let words = self.fault_in_words()?;
        Some(match self.stderr.last() {
            Some(line) => {
                let line: String = line.trim().chars().take(LONGEST_LAST_LINE).collect();
                format!("{words}; stderr: {line}")
            }
            None => words,
        })
    }
}

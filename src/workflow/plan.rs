//! Plans the ego of a scenario: selects the planning problem, checks that it can be planned, and drives.

use std::sync::Arc;

use nearmiss_drive::planner::{Cancel, Forecaster, Limits, Planner, Traffic};
use nearmiss_drive::simulation::{
    Cycle, DriveError, Driver, ExternalPlanner, ExternalReport, PlannerFault, Rollout, Settings,
    TrafficMode,
};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::scenario::{Ego, PlanningProblem, Scenario, Scene};

use super::{MissingEgo, OpenError, OpenRequest, OpenedScene, StandIn, open, scene_with_ego};

/// Whose ego is planned, and how.
#[derive(Debug, Clone, Copy)]
pub struct PlanRequest<'a> {
    /// The scenario. Its ego is what the planned one is compared with.
    pub open: OpenRequest<'a>,
    /// Id of the planning problem; that of the recorded ego where none is named, else the first one.
    pub problem: Option<i64>,
    /// How is planned.
    pub settings: &'a Settings,
}

/// Why an ego is not planned; the message begins with the scenario.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// The scenario cannot be opened.
    #[error("{0}")]
    Unreadable(String),
    /// The request does not fit the scenario: it has no planning problem of that id, or too long steps.
    #[error("{0}")]
    Mismatch(String),
    /// The scenario has nothing that could be planned; that is a finding about it.
    #[error("{0}")]
    NothingToPlan(String),
    /// The planner's process failed before there was anything to work on.
    #[error("{0}")]
    PlannerFailed(Box<PlannerFailure>),
}

/// Events while an ego is planned.
pub enum PlanEvent<'a> {
    /// A cycle has ended.
    Cycle {
        /// The planner, with the candidates of the cycle.
        planner: &'a Planner<'a>,
        /// What it decided.
        cycle: &'a Cycle,
        /// What it was told of the traffic, worked out again.
        traffic: &'a dyn Fn() -> Traffic,
        /// Steps that are planned by now.
        done: usize,
        /// Steps until the goal's time is over; 0 where it has none.
        of: usize,
    },
}

/// A request that can be carried out.
#[derive(Debug, Clone)]
pub struct PreparedPlan {
    /// The scenario, changed if that was asked for.
    pub scenario: Arc<Scenario>,
    /// The scene with the ego that the scenario has otherwise.
    pub recorded: Option<Arc<Scene>>,
    /// Why there is none.
    missing: Option<MissingEgo>,
    /// How is planned.
    pub settings: Settings,
    /// The planner; the built-in one where none is named.
    pub planner: Option<Arc<ExternalPlanner>>,
    /// The scenario's name.
    pub name: String,
    /// The scenario, as errors name it.
    shown: String,
    /// Its place among the scenario's problems.
    problem: usize,
    /// Whether a cycle gives up candidates as soon as another one is cheaper.
    only_best: bool,
}

/// A planned ego.
#[derive(Debug)]
pub struct PlanOutcome {
    /// The request.
    pub prepared: PreparedPlan,
    /// How it drove.
    pub drive: Rollout,
}

/// So many planning problems are named where one has to be chosen.
const NAMED: usize = 12;

/// Opens the scenario and checks that its ego can be planned as asked.
///
/// # Errors
/// See [`PlanError`].
pub fn prepare(request: &PlanRequest<'_>) -> Result<PreparedPlan, PlanError> {
    let entry = request.open.entry;
    let opened = open(&request.open).map_err(|error| match error {
        // It names the file itself.
        OpenError::Scenario(error) => PlanError::Unreadable(error.to_string()),
        error => PlanError::Unreadable(format!("{}: {error}", entry.display())),
    })?;
    prepare_opened(entry, opened, request.problem, request.settings)
}

/// The same for the ego beside the scenario.
///
/// # Errors
/// See [`PlanError`].
pub fn prepare_beside(
    entry: &Entry,
    problem: Option<i64>,
    settings: &Settings,
) -> Result<PreparedPlan, PlanError> {
    prepare(&PlanRequest {
        open: OpenRequest {
            entry,
            ego: &EgoSelection::Beside,
            transform: None,
            strict: false,
            stand_in: StandIn::None,
        },
        problem,
        settings,
    })
}

/// The same for a scenario that is read, whose ego is the one beside it.
///
/// # Errors
/// See [`PlanError`].
pub fn prepare_read(
    entry: &Entry,
    scenario: Arc<Scenario>,
    problem: Option<i64>,
    settings: &Settings,
) -> Result<PreparedPlan, PlanError> {
    let scene = scene_with_ego(entry, &scenario, &EgoSelection::Beside)
        .unwrap_or_else(|error| Err(MissingEgo::Unusable(error.to_string())));
    let opened = OpenedScene {
        scenario,
        scene,
        stands_in: false,
    };
    prepare_opened(entry, opened, problem, settings)
}

/// The same for a scenario that is open.
///
/// # Errors
/// See [`PlanError`].
pub fn prepare_opened(
    entry: &Entry,
    opened: OpenedScene,
    problem: Option<i64>,
    settings: &Settings,
) -> Result<PreparedPlan, PlanError> {
    let (recorded, missing) = match opened.scene {
        Ok(scene) => (Some(scene), None),
        Err(why) => (None, Some(why)),
    };
    let scenario = opened.scenario;
    let problem = chosen(entry, &scenario, recorded.as_deref(), problem)?;
    within_horizon(entry, &scenario, settings)?;
    let prepared = PreparedPlan {
        scenario,
        recorded,
        missing,
        settings: *settings,
        planner: None,
        name: entry.name.clone(),
        shown: entry.display(),
        problem,
        only_best: false,
    };
    prepared.starts_slowly_enough()?;
    Ok(prepared)
}

/// The place of the problem that is solved.
fn chosen(
    entry: &Entry,
    scenario: &Scenario,
    recorded: Option<&Scene>,
    wanted: Option<i64>,
) -> Result<usize, PlanError> {
    let problems = &scenario.planning_problems;
    if problems.is_empty() {
        return Err(PlanError::NothingToPlan(format!(
            "{}: no planning problem, so nothing to plan",
            entry.display()
        )));
    }
    let place = |id| problems.iter().position(|p| p.id == id);
    let Some(id) = wanted else {
        let own = recorded.and_then(|scene| place(scene.ego.id));
        return Ok(own.unwrap_or(0));
    };
    place(id).ok_or_else(|| {
        let ids = problems.iter().map(|p| p.id.to_string());
        let mut known: Vec<String> = ids.take(NAMED).collect();
        if problems.len() > NAMED {
            known.push(format!("and {} more", problems.len() - NAMED));
        }
        let ids = match &known[..] {
            [only] => format!("the only one is {only}"),
            _ => format!("available: {}", known.join(", ")),
        };
        PlanError::Mismatch(format!(
            "{}: no planning problem {id}; {ids}",
            entry.display()
        ))
    })
}

/// A plan ends at the horizon: nothing of it can be driven beyond.
fn within_horizon(
    entry: &Entry,
    scenario: &Scenario,
    settings: &Settings,
) -> Result<(), PlanError> {
    let (dt, horizon) = (scenario.dt(), settings.planner.horizon);
    let most = settings.planner.steps(dt);
    // Steps that do not fit at all are refused by the planner.
    if settings.replan <= most || !settings.planner.fits(dt) {
        return Ok(());
    }
    Err(PlanError::Mismatch(format!(
        "{}: replan={} is too large: a horizon of {horizon} s has {most} steps of {dt} s; use at most replan={most}, or a longer horizon",
        entry.display(),
        settings.replan
    )))
}

/// The ego of a drive, without a word on how the drive ends: that may not be over.
pub(super) fn prepared_ego(prepared: &PreparedPlan, drive: &Rollout) -> Ego {
    Ego {
        diagnostics: Vec::new(),
        ..drive.ego(prepared.problem(), &prepared.settings)
    }
}

impl PreparedPlan {
    /// The scenario as it was opened.
    #[must_use]
    pub fn opened(&self) -> OpenedScene {
        let missing = || self.missing.clone().unwrap_or(MissingEgo::NotRecorded);
        OpenedScene {
            scenario: Arc::clone(&self.scenario),
            scene: self.recorded.clone().ok_or_else(missing),
            stands_in: false,
        }
    }

    /// The same, planned by this planner; by the built-in one where none is named.
    #[must_use]
    pub fn driven_by(self, planner: Option<Arc<ExternalPlanner>>) -> Self {
        Self { planner, ..self }
    }

    /// The same, which drives the same sooner: its cycles tell no event, and do not say how many of their candidates
    /// could be driven, see [`Planner::only_best`].
    #[must_use]
    pub fn only_best(self) -> Self {
        Self {
            only_best: true,
            ..self
        }
    }

    /// What drives, in a scenario that differs from the prepared one by the motion of obstacles alone.
    pub(super) fn driver(
        &self,
        scenario: &Scenario,
        cancel: &Cancel,
    ) -> Result<Driver, DriveError> {
        let driver = Driver::new(scenario, self.problem(), &self.settings)?
            .with_recorded(self.recorded_ego().cloned());
        Ok(driver.cancelled_by(cancel).driven_by(self.planner.clone()))
    }

    /// The scene with the recorded ego of the problem: that of another one is not what this one is compared with.
    #[must_use]
    pub fn recorded_ego(&self) -> Option<&Arc<Scene>> {
        let own = |scene: &&Arc<Scene>| scene.ego.id == self.problem().id;
        self.recorded.as_ref().filter(own)
    }

    /// The planning problem that is solved.
    #[must_use]
    pub fn problem(&self) -> &PlanningProblem {
        &self.scenario.planning_problems[self.problem]
    }

    /// An error that begins with the scenario.
    pub(super) fn nothing(&self, why: &dyn std::fmt::Display) -> PlanError {
        PlanError::NothingToPlan(format!("{}: {why}", self.shown))
    }

    /// That the planner's process failed; nothing where it did not.
    pub(super) fn failed(&self, report: &ExternalReport) -> Option<PlanError> {
        let failure = PlannerFailure::from_report(self.shown.clone(), report)?;
        Some(PlanError::PlannerFailed(Box::new(failure)))
    }

    /// The same about the request.
    pub(super) fn mismatch(&self, why: &dyn std::fmt::Display) -> PlanError {
        PlanError::Mismatch(format!("{}: {why}", self.shown))
    }

    fn starts_slowly_enough(&self) -> Result<(), PlanError> {
        let (problem, vehicle) = (self.problem(), self.settings.planner.vehicle);
        let (start, most) = (problem.initial.velocity, Limits::for_vehicle(vehicle).speed);
        match start.map(|v| v.middle()).filter(|v| *v > most) {
            None => Ok(()),
            Some(start) => Err(self.nothing(&format!(
                "planning problem {} starts at {start} m/s, but the {} reaches at most {most} m/s; choose another vehicle",
                problem.id,
                vehicle.name()
            ))),
        }
    }

    /// The motion of the recorded ego as a drive: how it ends is judged as of a planned one, in recorded traffic.
    ///
    /// # Errors
    /// [`PlanError::NothingToPlan`]: the scenario has no recorded ego of the problem, or that of [`Self::run`].
    pub fn recorded_drive(self, cancel: &Cancel) -> Result<PlanOutcome, PlanError> {
        let Some(scene) = self.recorded_ego().cloned() else {
            let why = match &self.missing {
                Some(MissingEgo::Unusable(why)) => format!(": {why}"),
                _ => String::new(),
            };
            return Err(self.nothing(&format!("no recorded ego to compare with{why}")));
        };
        let driver = self
            .driver(&self.scenario, cancel)
            .map_err(|error| self.nothing(&error))?;
        let drive = driver.along(&self.scenario, &scene.ego.track);
        Ok(PlanOutcome {
            prepared: self,
            drive,
        })
    }

    /// What the planner's process says of itself, or its fault; `None` for the built-in planner.
    ///
    /// # Errors
    /// Those of [`Driver::new`].
    pub fn greet(&self, cancel: &Cancel) -> Result<Option<ExternalReport>, DriveError> {
        Ok(self.driver(&self.scenario, cancel)?.greet(&self.scenario))
    }

    /// Drives. Nothing where `cancel` asked for an end.
    ///
    /// # Errors
    /// [`PlanError::NothingToPlan`]: the problem has no start or no goal, or no way leads to it.
    pub fn run(
        self,
        cancel: &Cancel,
        on_event: &mut dyn FnMut(PlanEvent<'_>),
    ) -> Result<Option<PlanOutcome>, PlanError> {
        let driver = self.driver(&self.scenario, cancel);
        let drive = driver
            .map(|driver| self.drive_with(&driver, &self.scenario, cancel, on_event))
            .map_err(|error| self.nothing(&error))?;
        Ok(drive.map(|drive| PlanOutcome {
            prepared: self,
            drive,
        }))
    }

    /// Drives in a scenario that differs from the prepared one by the motion of obstacles alone, which do not react: so
    /// attacks are judged.
    ///
    /// # Errors
    /// Those of [`Driver::new`].
    pub fn drive_in(
        &self,
        scenario: &Scenario,
        cancel: &Cancel,
        on_event: &mut dyn FnMut(PlanEvent<'_>),
    ) -> Result<Option<Rollout>, DriveError> {
        let driver = self
            .driver(scenario, cancel)?
            .in_traffic(TrafficMode::Recorded);
        Ok(self.drive_with(&driver, scenario, cancel, on_event))
    }

    fn drive_with(
        &self,
        driver: &Driver,
        scenario: &Scenario,
        cancel: &Cancel,
        on_event: &mut dyn FnMut(PlanEvent<'_>),
    ) -> Option<Rollout> {
        if self.only_best {
            let drive = driver.drive(scenario, &driver.full_span());
            return (!cancel.is_asked()).then_some(drive);
        }
        let mut watch = self.watch(scenario, on_event);
        let drive = driver.drive_watched(scenario, &driver.full_span(), &mut |planner, cycle| {
            watch(planner, cycle);
            !cancel.is_asked()
        });
        (!cancel.is_asked()).then_some(drive)
    }

    /// The scenario as it was driven.
    #[must_use]
    pub fn driven(&self, drive: &Rollout) -> Arc<Scenario> {
        let driven = drive.traffic.scenario.as_ref();
        Arc::clone(driven.unwrap_or(&self.scenario))
    }

    /// Tells `on_event` of each cycle.
    pub(super) fn watch<'a>(
        &'a self,
        scenario: &'a Scenario,
        on_event: &'a mut dyn FnMut(PlanEvent<'_>),
    ) -> impl FnMut(&Planner<'_>, &Cycle) + 'a {
        let problem = self.problem();
        let first = problem.initial.time.from;
        let steps = move |step: i64| usize::try_from(step.saturating_sub(first)).unwrap_or(0);
        let of = problem.deadline().map_or(0, steps);
        let Settings {
            forecast, without, ..
        } = self.settings;
        // Where the planner has not kept what it was told, it is made again from the same past.
        let forecaster = std::cell::OnceCell::new();
        move |planner, cycle| {
            let traffic = || {
                if let Some(told) = planner.traffic() {
                    return told.clone();
                }
                let forecaster =
                    forecaster.get_or_init(|| Forecaster::new(scenario, forecast, without));
                forecaster.traffic(cycle.step, planner.steps())
            };
            on_event(PlanEvent::Cycle {
                planner,
                cycle,
                traffic: &traffic,
                done: steps(cycle.step) + 1,
                of,
            });
        }
    }
}

/// How a planner's process failed in a scenario.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{scenario}: not driven by `{planner}`: {words}")]
pub struct PlannerFailure {
    /// The scenario, as errors name it.
    pub scenario: String,
    /// The planner as the user names it.
    pub planner: String,
    /// The fault with its time step, its details, and the last line of standard error.
    pub words: String,
    /// What kind of fault it is.
    pub fault: PlannerFault,
    /// The time step at which there was no trajectory.
    pub step: Option<i64>,
    /// The last lines of standard error.
    pub stderr: Vec<String>,
}

impl PlannerFailure {
    /// The failure of a drive; nothing where its planner did not fail.
    #[must_use]
    pub fn from_report(scenario: String, report: &ExternalReport) -> Option<Self> {
        Some(Self {
            scenario,
            planner: report.planner.clone(),
            words: report.failure()?,
            fault: report.fault?,
            step: report.fault_step,
            stderr: report.stderr.clone(),
        })
    }
}

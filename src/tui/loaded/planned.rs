//! An opened scenario whose ego was planned, with what the planner saw and chose at every cycle.

use std::sync::Arc;

use super::{CycleShown, Opened, changed_scene};
use crate::metrics::Thresholds;
use crate::planner::{Forecast, Forecaster, Limits};
use crate::scenario::{Entry, PlanningProblem, Scenario, Scene, Transform, VehicleType, WantedEgo};
use crate::simulation::{Drive, Outcome, Settings, drive_watched};

/// How an ego was planned.
#[derive(Debug, PartialEq)]
pub struct Planned {
    /// What the planner was told of the others' future.
    pub forecast: Forecast,
    /// The vehicle that was driven.
    pub vehicle: VehicleType,
    /// Id of the planning problem that was solved.
    pub problem: i64,
    /// How the drive ended.
    pub outcome: Outcome,
    /// Every cycle, in the order of time.
    pub cycles: Vec<CycleShown>,
    /// The scenario with the ego that it has otherwise, to compare both; nothing where it has none.
    pub recorded: Option<Arc<Scene>>,
}

impl Planned {
    /// The width of a map with the ego in its middle that shows all that was chosen, metres.
    #[must_use]
    pub fn reach(&self) -> f64 {
        let ends = self.cycles.iter().filter_map(|cycle| {
            let (first, last) = (cycle.chosen.first()?, cycle.chosen.last()?);
            Some((last - first).norm())
        });
        2.0 * ends.fold(0.0, f64::max)
    }

    /// The cycle that decided what is driven at a step: the last one until then.
    #[must_use]
    pub fn cycle_at(&self, step: i64) -> Option<&CycleShown> {
        let after = self.cycles.partition_point(|cycle| cycle.step <= step);
        self.cycles.get(after.checked_sub(1)?)
    }
}

impl Opened {
    /// Plans the ego of a scenario, after a change of its scene if there is one, and opens it with that; `watch` hears the number of steps that are
    /// planned and of all, and says whether to go on. Nothing where it said no.
    ///
    /// # Errors
    /// The scenario cannot be read, has no planning problem, or the planner cannot begin.
    pub fn planned(
        entry: &Entry,
        wanted: &WantedEgo,
        thresholds: &Thresholds,
        (change, settings): (Option<Transform>, &Settings),
        watch: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<Option<Self>, String> {
        let (scenario, recorded) = changed_scene(entry, wanted, change)?;
        let recorded = recorded.ok();
        let problem = problem(&scenario.planning_problems, recorded.as_deref()).ok_or(
            "the scenario has no planning problem: there is no start and no goal to plan for",
        )?;
        let Some((drive, cycles)) = driven(&scenario, problem, settings, watch)? else {
            return Ok(None);
        };
        let ego = drive.ego(problem, settings);
        let scene = Arc::new(Scene::new(scenario.clone(), ego));
        let mut opened = Self::with(entry, change, scenario.clone(), Ok(scene), thresholds);
        opened.planned = Some(Arc::new(Planned {
            forecast: settings.forecast,
            vehicle: settings.planner.vehicle,
            problem: problem.id,
            outcome: drive.outcome,
            cycles,
            recorded,
        }));
        Ok(Some(opened))
    }
}

/// A drive with all its cycles; nothing where `watch`, which hears what [`Opened::planned`] says, said no.
pub(super) fn driven(
    scenario: &Scenario,
    problem: &PlanningProblem,
    settings: &Settings,
    watch: &mut dyn FnMut(usize, usize) -> bool,
) -> Result<Option<(Drive, Vec<CycleShown>)>, String> {
    let first = problem.initial.time.from;
    let steps = |step: i64| usize::try_from(step.saturating_sub(first)).unwrap_or(0);
    let of = problem.deadline().map_or(0, steps);
    // What the planner was told is made a second time, from the same past: it does not keep it.
    let forecaster = Forecaster::new(scenario, settings.forecast, settings.without);
    let limits = Limits::of(settings.planner.vehicle);
    let dt = scenario.dt();
    let mut cycles = Vec::new();
    let mut stopped = false;
    let drive = drive_watched(scenario, problem, settings, &mut |planner, cycle| {
        let traffic = forecaster.traffic(cycle.step, planner.steps());
        cycles.push(CycleShown::of((planner, &limits), cycle, &traffic, dt));
        stopped = !watch(steps(cycle.step) + 1, of);
        !stopped
    });
    let drive = drive.map_err(|error| error.to_string())?;
    Ok((!stopped).then_some((drive, cycles)))
}

/// The problem of the recorded ego, else the first one.
fn problem<'a>(
    all: &'a [PlanningProblem],
    recorded: Option<&Scene>,
) -> Option<&'a PlanningProblem> {
    let own = recorded.and_then(|scene| all.iter().find(|problem| problem.id == scene.ego.id));
    own.or(all.first())
}

//! An opened scenario with a planned ego, and what the planner saw and chose in every cycle.

use std::sync::Arc;

use super::{CycleShown, Opened};
use nearmiss_drive::planner::{Cancel, Forecast, Limits};
use nearmiss_drive::simulation::{
    BeyondVehicle, ExternalPlanner, ExternalReport, Outcome, Rollout,
};
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Ego, Scenario, Scene, VehicleType};
use nearmiss_scene::traffic_rules::RuleReport;
use nearmiss_workflow::{OpenRequest, PlanEvent, PlanOutcome, PlanRequest, PreparedPlan, prepare};

/// The record of a planned ego.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedEgo {
    /// The forecast given to the planner.
    pub forecast: Forecast,
    /// The planner: 0 is the built-in one, then those of the configuration.
    pub planner: usize,
    /// What is known of the planner's process, if it is one.
    pub process: Option<Box<ExternalReport>>,
    /// The vehicle that was driven.
    pub vehicle: VehicleType,
    /// Id of the planning problem that was solved.
    pub problem: i64,
    /// How the drive ended.
    pub outcome: Outcome,
    /// What of the drive the vehicle cannot do.
    pub beyond: Option<BeyondVehicle>,
    /// What became of the rules of the road.
    pub rules: RuleReport,
    /// Every cycle, in the order of time.
    pub cycles: Vec<CycleShown>,
    /// The scenario with the ego that it has otherwise, to compare both; `None` if it has none.
    pub recorded: Option<Arc<Scene>>,
}

impl PlannedEgo {
    /// How the drive ended; which planner failed, where its process did.
    #[must_use]
    pub fn ended(&self) -> String {
        match (&self.outcome, &self.process) {
            (Outcome::PlannerError(error), Some(process)) => {
                format!(
                    "{} failed: {error}, where the drive ends",
                    visible(&process.planner)
                )
            }
            (outcome, _) => outcome.to_string(),
        }
    }

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
    /// Plans the ego of a scenario and opens it with that; `on_step` hears the number of steps that are planned and of
    /// all. Nothing where `cancel` asked for an end.
    ///
    /// # Errors
    /// The scenario cannot be opened, has no planning problem, or the planner cannot begin.
    pub fn planned(
        request: &PlanRequest<'_>,
        thresholds: &Thresholds,
        cancel: &Cancel,
        on_step: &mut dyn FnMut(usize, usize),
    ) -> Result<Option<Self>, String> {
        Self::planned_by(request, 0, None, thresholds, cancel, on_step)
    }

    /// The same by a planner with this place among those that can be chosen; the built-in one is the first.
    ///
    /// # Errors
    /// Those of [`Self::planned`].
    pub fn planned_by(
        request: &PlanRequest<'_>,
        place: usize,
        planner: Option<Arc<ExternalPlanner>>,
        thresholds: &Thresholds,
        cancel: &Cancel,
        on_step: &mut dyn FnMut(usize, usize),
    ) -> Result<Option<Self>, String> {
        let prepared = prepare(request)
            .map_err(|error| error.to_string())?
            .driven_by(planner);
        let mut recorder = Recorder::new(&prepared);
        let outcome = prepared
            .run(cancel, &mut |event| recorder.hear(&event, on_step))
            .map_err(|error| error.to_string())?;
        Ok(outcome.map(|PlanOutcome { prepared, drive }| {
            let ego = drive.ego(prepared.problem(), &prepared.settings);
            let (scenario, mut planned) =
                PlannedEgo::from_outcome(&prepared, &drive, recorder.cycles);
            planned.planner = place;
            planned.process = drive.external;
            Self::with_planned(&request.open, ego, scenario, planned, thresholds)
        }))
    }

    /// A scenario with its planned ego.
    pub(super) fn with_planned(
        request: &OpenRequest<'_>,
        ego: Ego,
        scenario: Arc<Scenario>,
        planned: PlannedEgo,
        thresholds: &Thresholds,
    ) -> Self {
        let scene = Arc::new(Scene::new(scenario.clone(), ego));
        let (entry, change) = (request.entry, request.transform);
        let mut opened = Self::with(entry, change, scenario, Ok(scene), thresholds);
        opened.planned = Some(Arc::new(planned));
        opened
    }
}

impl PlannedEgo {
    /// The record of a drive, and its scenario.
    pub(super) fn from_outcome(
        prepared: &PreparedPlan,
        drive: &Rollout,
        cycles: Vec<CycleShown>,
    ) -> (Arc<Scenario>, Self) {
        let driven = prepared.driven(drive);
        let planned = Self {
            rules: drive.rules(&driven, prepared.problem(), &prepared.settings),
            forecast: prepared.settings.forecast,
            planner: 0,
            process: None,
            vehicle: prepared.settings.planner.vehicle,
            problem: prepared.problem().id,
            outcome: drive.outcome,
            beyond: drive.beyond_vehicle(),
            cycles,
            recorded: prepared.recorded.clone(),
        };
        (driven, planned)
    }
}

/// Keeps of each cycle what is shown.
pub(super) struct Recorder {
    limits: Limits,
    /// Seconds a step.
    dt: f64,
    /// The cycles so far.
    pub cycles: Vec<CycleShown>,
}

impl Recorder {
    pub(super) fn new(prepared: &PreparedPlan) -> Self {
        Self {
            limits: Limits::for_vehicle(prepared.settings.planner.vehicle),
            dt: prepared.scenario.dt(),
            cycles: Vec::new(),
        }
    }

    pub(super) fn hear(&mut self, event: &PlanEvent<'_>, on_step: &mut dyn FnMut(usize, usize)) {
        let PlanEvent::Cycle {
            planner,
            cycle,
            traffic,
            done,
            of,
        } = event;
        let shown = CycleShown::new(planner, &self.limits, cycle, &traffic(), self.dt);
        self.cycles.push(shown);
        on_step(*done, *of);
    }
}

//! A scenario with a planned ego: the drive, its cycles, and what is written of it.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use nearmiss_base::geometry::{Point, Vector};
use nearmiss_drive::planner::{
    Cancel, Candidate, Cost, Emergency, Forecast, Hold, Limits, Planner, Traffic, VehicleState,
};
use nearmiss_drive::simulation::{
    BeyondVehicle, Cycle, ExternalPlanner, ExternalReport, Outcome, Rollout,
};
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{ContentHash, Ego, Scenario, Scene, Transform, VehicleType};
use nearmiss_scene::traffic_rules::RuleReport;
use nearmiss_workflow::{OpenRequest, PlanEvent, PlanOutcome, PlanRequest, PreparedPlan, prepare};

use super::Opened;

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
            // The drive has no step then.
            (Outcome::Goal(_), _) if self.cycles.is_empty() => "goal reached at the start".into(),
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
            .run(cancel, &mut |event| recorder.on_event(&event, on_step))
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

    pub(super) fn on_event(
        &mut self,
        event: &PlanEvent<'_>,
        on_step: &mut dyn FnMut(usize, usize),
    ) {
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

/// The key of a drive: equal keys give equal drives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveKey {
    /// Hash of the scenario.
    pub hash: ContentHash,
    /// The change of the scenario.
    pub change: Option<Transform>,
    /// The forecast given to the planner.
    pub forecast: Forecast,
    /// The planner: 0 is the built-in one, then those of the configuration.
    pub planner: usize,
}

/// A drive to be written.
#[derive(Debug)]
pub struct DriveFiles {
    /// Which.
    pub key: DriveKey,
    /// Name of the scenario.
    pub name: String,
    /// The scenario with the planned ego.
    pub scene: Arc<Scene>,
    /// The vehicle that was driven.
    pub vehicle: VehicleType,
    /// Id of the planning problem that was solved.
    pub problem: i64,
    /// Where the files go; the current folder if none.
    pub folder: Option<PathBuf>,
}

impl Opened {
    /// The identity of the planned drive; `None` if the ego was not planned.
    #[must_use]
    pub fn drive_key(&self) -> Option<DriveKey> {
        self.planned.as_ref().map(|planned| DriveKey {
            hash: self.scenario.hash,
            change: self.change,
            forecast: planned.forecast,
            planner: planned.planner,
        })
    }
}

/// Lines of the fan at most: of candidates that can be driven, and of those that cannot.
const LINES: (usize, usize) = (90, 80);

/// Points of a line at most.
const POINTS: usize = 14;

/// Seconds from one drawn moment of a predicted body to the next.
const MOMENT: f64 = 1.0;

/// A predicted body farther from the ego than this is left out, metres.
const MAX_DISTANCE: f64 = 80.0;

/// A body predicted to stay within this distance of its position gets no separate outline, metres.
const MIN_MOVE: f64 = 0.5;

/// A cycle of the planner.
#[derive(Debug, Clone, PartialEq)]
pub struct CycleShown {
    /// The time step at which it was planned.
    pub step: i64,
    /// Candidates that were looked at.
    pub candidates: usize,
    /// How many of them could be driven.
    pub feasible: usize,
    /// Why the others could not, the most frequent reason first.
    pub rejected: Vec<(&'static str, usize)>,
    /// Times that the samples were refined.
    pub refinements: usize,
    /// The speed that was wanted, m/s.
    pub wanted: f64,
    /// The speed at the beginning and at the end of what was chosen, m/s.
    pub speeds: (f64, f64),
    /// Cost of the chosen candidate.
    pub cost: Cost,
    /// The fallback, if nothing could be driven.
    pub emergency: Option<Emergency>,
    /// A rule that asks for a stop ahead.
    pub hold: Option<Hold>,
    /// How long planning took, the forecast not counted.
    pub took: Duration,
    /// Where what was chosen leads, the body's centre, a point a step.
    pub chosen: Vec<Point>,
    /// Steps from one full second of what was chosen to the next.
    pub second: usize,
    /// Some of the candidates.
    pub fan: Fan,
    /// Bodies that the planner was told of, at full seconds from now.
    pub foreseen: Vec<PredictedBody>,
}

/// Lines of candidates, in little memory: metres from `origin`, in single precision.
#[derive(Debug, Clone, PartialEq)]
pub struct Fan {
    origin: Point,
    points: Vec<[f32; 2]>,
    /// Where each line ends, and whether it can be driven.
    ends: Vec<(usize, bool)>,
}

/// A body where it is predicted to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedBody {
    /// Its corners, one after another.
    pub corners: [Point; 4],
    /// Whether contact with it is ruled out; else it only costs.
    pub avoided: bool,
}

impl CycleShown {
    /// The displayed data of a cycle that has just ended, for steps of `dt` seconds.
    #[must_use]
    pub fn new(
        planner: &Planner<'_>,
        limits: &Limits,
        cycle: &Cycle,
        traffic: &Traffic,
        dt: f64,
    ) -> Self {
        let plan = &cycle.plan;
        let centre = |s: &VehicleState| s.centre(limits).pose.position;
        let chosen: Vec<Point> = plan.states.iter().map(centre).collect();
        let origin = chosen.first().copied().unwrap_or(Point::origin());
        let speed = |state: Option<&VehicleState>| state.map_or(0.0, |s| s.velocity);
        let mut rejected = plan.rejected.clone();
        rejected.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let second = ((MOMENT / dt).round() as usize).max(1);
        Self {
            step: cycle.step,
            candidates: plan.candidates,
            feasible: plan.feasible,
            rejected,
            refinements: plan.refinements,
            wanted: plan.wanted,
            speeds: (speed(plan.states.first()), speed(plan.states.last())),
            cost: plan.cost,
            emergency: plan.emergency,
            hold: plan.hold,
            took: cycle.took,
            second,
            fan: Fan::new(planner, limits, origin),
            foreseen: foreseen(traffic, &origin, second),
            chosen,
        }
    }
}

impl CycleShown {
    /// Bytes that it takes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let lists = size_of_val(&self.fan.points[..])
            + size_of_val(&self.fan.ends[..])
            + size_of_val(&self.chosen[..])
            + size_of_val(&self.foreseen[..]);
        size_of::<Self>() + lists
    }
}

impl Fan {
    fn new(planner: &Planner<'_>, limits: &Limits, origin: Point) -> Self {
        let mut fan = Self {
            origin,
            points: Vec::new(),
            ends: Vec::new(),
        };
        let all = planner.candidates();
        let (can, cannot): (Vec<&Candidate>, Vec<&Candidate>) =
            all.iter().partition(|c| c.rejected.is_none());
        for candidate in spread(&cannot, LINES.1).chain(spread(&can, LINES.0)) {
            let mut states = planner.states_of(candidate);
            if let Some((step, _)) = candidate.rejected {
                // The candidate was not evaluated past the step of its rejection.
                states.truncate(step + 1);
            }
            let centres: Vec<Point> = states
                .iter()
                .map(|s| s.centre(limits).pose.position)
                .collect();
            fan.add(&centres, candidate.rejected.is_none());
        }
        fan.points.shrink_to_fit();
        fan.ends.shrink_to_fit();
        fan
    }

    fn add(&mut self, line: &[Point], drivable: bool) {
        let Some(last) = line.len().checked_sub(1).filter(|last| *last > 0) else {
            return;
        };
        let stride = last.div_ceil(POINTS - 1).max(1);
        let steps = (0..last).step_by(stride).chain([last]);
        for step in steps {
            let from = line[step] - self.origin;
            self.points.push([from.x as f32, from.y as f32]);
        }
        self.ends.push((self.points.len(), drivable));
    }

    /// How many lines there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.ends.len()
    }

    /// Each line, and whether it can be driven; those that can come last.
    pub fn lines(&self) -> impl Iterator<Item = (Vec<Point>, bool)> + '_ {
        let mut from = 0;
        self.ends.iter().map(move |&(to, drivable)| {
            let line = &self.points[from..to];
            from = to;
            let at = |p: &[f32; 2]| self.origin + Vector::new(f64::from(p[0]), f64::from(p[1]));
            (line.iter().map(at).collect(), drivable)
        })
    }
}

/// At most `most` of them, evenly spaced.
fn spread<'a, T>(all: &'a [&'a T], most: usize) -> impl Iterator<Item = &'a T> {
    let count = all.len().min(most);
    (0..count).map(move |i| all[i * all.len() / count])
}

/// The bodies at full seconds from now that are near and do not just stay.
fn foreseen(traffic: &Traffic, ego: &Point, second: usize) -> Vec<PredictedBody> {
    let now = traffic.at(0);
    let mut found = Vec::new();
    for step in (second..=traffic.horizon()).step_by(second) {
        for body in traffic.at(step) {
            let at = Point::new(body.x, body.y);
            let before = now.iter().find(|b| b.body == body.body);
            let stays = before.is_some_and(|b| (at - Point::new(b.x, b.y)).norm() < MIN_MOVE);
            if stays || (at - ego).norm() > MAX_DISTANCE {
                continue;
            }
            let forward = Vector::new(body.cos, body.sin) * body.half_length;
            let left = Vector::new(-body.sin, body.cos) * body.half_width;
            found.push(PredictedBody {
                corners: [
                    at + forward + left,
                    at - forward + left,
                    at - forward - left,
                    at + forward - left,
                ],
                avoided: traffic.bodies[body.body].avoided,
            });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_much_is_thinned_evenly() {
        let all: Vec<usize> = (0..10).collect();
        let all: Vec<&usize> = all.iter().collect();
        assert_eq!(spread(&all, 3).copied().collect::<Vec<_>>(), [0, 3, 6]);
        assert_eq!(spread(&all, 20).count(), 10);
        assert_eq!(spread(&all[..0], 20).count(), 0);
    }
}

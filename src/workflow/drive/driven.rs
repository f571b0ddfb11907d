//! One drive of the ego of a scenario, and what is known of it.

use std::sync::Arc;

use nearmiss_drive::driver::PreventabilityRecord;
use nearmiss_drive::planner::{Cancel, Emergency};
use nearmiss_drive::simulation::{
    BeyondVehicle, Collision, MOST_DRIVEN, Outcome, Rollout, Settings,
};
use nearmiss_formats::Entry;
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::Impact;
use nearmiss_scene::scenario::{Scenario, Scene};
use nearmiss_scene::traffic_rules::RuleReport;

use super::choice::{BUILT_IN, PlannerChoice, RECORDED};
use crate::VariantOrigin;
use crate::monitor::{Monitor, MonitorReport};
use crate::plan::{PlanError, PlanOutcome, PreparedPlan, prepare_beside};
use crate::tables::too_coarse;

/// A drive, and of what.
pub struct DrivenScenario {
    /// The scenario's name.
    pub name: String,
    /// Its file, or that it is bundled.
    pub file: String,
    /// As it was driven: with traffic that reacted, where it did.
    pub scenario: Arc<Scenario>,
    /// Id of the planning problem.
    pub problem: i64,
    /// How was planned.
    pub settings: Settings,
    /// How it drove.
    pub drive: Rollout,
    /// What a judge beside the planner said.
    pub monitor: Option<MonitorReport>,
    /// How hard the contact is that ended it.
    pub impact: Option<Impact>,
    /// Obstacles that came near without contact; counted where a planner was named.
    pub near_misses: Option<usize>,
    /// What became of the rules of the road.
    pub rules: RuleReport,
    /// What became of them where the recorded ego of the same problem drives, if there is one.
    pub recorded_rules: Option<RuleReport>,
    /// It is the motion of the recorded ego.
    pub is_recorded: bool,
    /// A certificate of the variant says that the ideal driver avoids the contact that ended it.
    pub is_certified: bool,
}

/// How an ego is driven beyond what its settings say.
#[derive(Clone, Copy)]
pub struct DriveOptions<'a> {
    /// Who drives; the built-in planner where none is named.
    pub planner: Option<&'a PlannerChoice>,
    /// A judge beside it.
    pub monitor: Option<&'a Monitor<'a>>,
    /// Whether cycles say how many candidates could be driven, which takes longer.
    pub counts: bool,
}

/// Drives the ego of a scenario; nothing where `cancel` asked for an end.
///
/// # Errors
/// [`PlanError::NothingToPlan`]: the problem has no start or no goal, no way leads to it, or the recorded ego is to drive and
/// there is none.
pub fn drive(
    entry: &Entry,
    prepared: PreparedPlan,
    options: DriveOptions<'_>,
    cancel: &Cancel,
) -> Result<Option<DrivenScenario>, PlanError> {
    let planner = options.planner;
    let mut prepared = prepared.driven_by(planner.and_then(|planner| planner.external.clone()));
    prepared.settings.policy = planner.and_then(|planner| planner.policy);
    if !options.counts {
        prepared = prepared.only_best();
    }
    let is_recorded = planner.is_some_and(|planner| planner.is_recorded);
    let driven = match options.monitor {
        None if is_recorded => Some((prepared.recorded_drive(cancel)?, None)),
        None => {
            let outcome = prepared.run(cancel, &mut |_| {})?;
            outcome.map(|outcome| (outcome, None))
        }
        Some(monitor) => {
            let outcome = prepared.run_monitored(monitor, cancel, &mut |_| {})?;
            outcome.map(|(outcome, report)| (outcome, Some(report)))
        }
    };
    let of = |(outcome, monitor): (PlanOutcome, _)| {
        let PlanOutcome { prepared, drive } = outcome;
        let (problem, settings) = (prepared.problem(), prepared.settings);
        let scenario = prepared.driven(&drive);
        let ego = || drive.ego(problem, &settings);
        // Certificates are of traffic as it was recorded.
        let has_contact = matches!(drive.outcome, Outcome::Collision(_));
        let is_certified = has_contact
            && drive.traffic.reactions.is_empty()
            && VariantOrigin::certified(entry, &Scene::new(Arc::clone(&scenario), ego()))
                .map_err(PlanError::Unreadable)?;
        Ok(DrivenScenario {
            name: visible(&entry.name).into_owned(),
            file: entry.display(),
            problem: problem.id,
            impact: drive.impact(&scenario, problem, &settings),
            near_misses: planner.map(|_| drive.near_misses(&scenario, problem, &settings).len()),
            rules: match prepared.recorded_ego().filter(|_| is_recorded) {
                Some(scene) => RuleReport::from_scene(scene),
                None => drive.rules(&scenario, problem, &settings),
            },
            is_recorded,
            is_certified,
            recorded_rules: prepared
                .recorded_ego()
                .map(|scene| RuleReport::from_scene(scene)),
            settings,
            scenario,
            drive,
            monitor,
        })
    };
    driven.map(of).transpose()
}

/// Drives the ego of a scenario from the start of a planning problem: that with the id, else that of the ego beside it,
/// else the first; nothing where `cancel` asked for an end.
#[must_use]
pub fn drive_entry(
    entry: &Entry,
    problem: Option<i64>,
    settings: &Settings,
    options: DriveOptions<'_>,
    cancel: &Cancel,
) -> Option<Result<DrivenScenario, PlanError>> {
    let prepared = prepare_beside(entry, problem, settings);
    prepared
        .and_then(|prepared| drive(entry, prepared, options, cancel))
        .transpose()
}

impl<'a> DriveOptions<'a> {
    /// This planner's drive, and no more.
    #[must_use]
    pub fn of(planner: &'a PlannerChoice) -> Self {
        Self {
            planner: Some(planner),
            monitor: None,
            counts: false,
        }
    }
}

/// Drives the ego of a scenario with each of several planners; nothing where `cancel` asked for an end.
///
/// # Errors
/// See [`drive`].
pub fn drive_each(
    entry: &Entry,
    prepared: &PreparedPlan,
    planners: &[PlannerChoice],
    cancel: &Cancel,
) -> Result<Option<Vec<DrivenScenario>>, PlanError> {
    let all = planners.iter().map(|planner| {
        let options = DriveOptions::of(planner);
        drive(entry, prepared.clone(), options, cancel).transpose()
    });
    // The first one that is cut short ends it.
    let drives: Option<Result<Vec<_>, _>> = all.collect();
    drives.transpose()
}

impl DrivenScenario {
    /// How it ended.
    #[must_use]
    pub fn outcome(&self) -> &Outcome {
        &self.drive.outcome
    }

    /// The contact that ended it.
    #[must_use]
    pub fn collision(&self) -> Option<&Collision> {
        match self.outcome() {
            Outcome::Collision(collision) => Some(collision),
            _ => None,
        }
    }

    /// The risk that the drive injures somebody seriously: none without contact; nothing where no published curve tells it.
    #[must_use]
    pub fn p_serious(&self) -> Option<f64> {
        match self.collision() {
            Some(_) => self.impact?.p_serious.ok(),
            None => Some(0.0),
        }
    }

    /// The scenario with the ego that was driven.
    #[must_use]
    pub fn scene(&self) -> Option<Scene> {
        let mut problems = self.scenario.planning_problems.iter();
        let problem = problems.find(|problem| problem.id == self.problem)?;
        let ego = self.drive.ego(problem, &self.settings);
        Some(Scene::new(Arc::clone(&self.scenario), ego))
    }

    /// What drivers would have made of the collision that ended it.
    #[must_use]
    pub fn preventability(&self) -> Option<PreventabilityRecord> {
        let collision = self.collision()?;
        let scene = self.scene()?;
        PreventabilityRecord::of(&scene, collision.with, collision.step, self.is_certified)
    }

    /// Whether it ended as a drive may: at the goal, or out of time, without harm.
    #[must_use]
    pub fn unharmed(&self) -> bool {
        self.outcome().is_unharmed()
    }

    /// Steps that were driven.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.drive.states.len().saturating_sub(1)
    }

    /// A note on a drive without a step, which ended where it starts, or on one that ended before the goal's time.
    #[must_use]
    pub fn note(&self) -> Option<String> {
        if self.steps() == 0 {
            return Some(
                match self.outcome() {
                    Outcome::Goal(_) => "goal reached at the start",
                    Outcome::Collision(_) => "contact at the start",
                    Outcome::Timeout => "goal's time over at the start",
                    Outcome::OffRoad => "off the road at the start",
                    Outcome::Infeasible => "infeasible from the start",
                    Outcome::PlannerError(_) => return self.planner_words(),
                }
                .into(),
            );
        }
        self.planner_words().or_else(|| self.cut_off())
    }

    /// That its time steps are too long for who drove by a rule.
    #[must_use]
    pub fn too_coarse(&self) -> Option<String> {
        let policy = self.settings.policy;
        policy.and_then(|_| too_coarse(&self.file, self.scenario.dt()))
    }

    /// Why it ended in time before the goal's time does.
    #[must_use]
    pub fn cut_off(&self) -> Option<String> {
        let problems = self.scenario.planning_problems.iter();
        let deadline = { problems }.find(|p| p.id == self.problem)?.deadline()?;
        let (last, _) = self.drive.states.last()?;
        (*self.outcome() == Outcome::Timeout && *last < deadline).then(|| {
            let why = if self.is_recorded {
                format!("the recording ends at step {last}")
            } else {
                format!("stopped after {MOST_DRIVEN} steps, the maximum")
            };
            format!("{why}; the goal's time ends at step {deadline}")
        })
    }

    /// What was done in cycles without a feasible candidate.
    pub fn emergencies(&self) -> impl Iterator<Item = Emergency> {
        let cycles = self.drive.cycles.iter();
        cycles.filter_map(|cycle| cycle.plan.emergency)
    }

    /// Cycles in which the samples had to be refined.
    #[must_use]
    pub fn refined(&self) -> usize {
        let cycles = self.drive.cycles.iter();
        cycles.filter(|cycle| cycle.plan.refinements > 0).count()
    }

    /// Of planning one cycle, milliseconds: the middle one, and the longest; nothing without cycles.
    #[must_use]
    pub fn milliseconds(&self) -> Option<(f64, f64)> {
        let cycles = self.drive.cycles.iter();
        let mut ms: Vec<f64> = cycles.map(|c| c.took.as_secs_f64() * 1e3).collect();
        ms.sort_by(f64::total_cmp);
        Some((median(&ms)?, *ms.last()?))
    }

    /// Its planner, as it was named.
    #[must_use]
    pub fn planner(&self) -> &str {
        if self.is_recorded {
            return RECORDED;
        }
        if let Some(policy) = self.settings.policy {
            return policy.name();
        }
        let external = self.drive.external.as_ref();
        external.map_or(BUILT_IN, |report| &report.planner)
    }

    /// What went wrong with the planner's process, or why it found nothing to drive.
    #[must_use]
    pub fn planner_words(&self) -> Option<String> {
        let report = self.drive.external.as_ref()?;
        let words = report.failure().or_else(|| report.message.clone())?;
        Some(visible(&words).into_owned())
    }

    /// Its steps that the vehicle cannot do; not looked at in recordings, which are of other vehicles.
    #[must_use]
    pub fn beyond_vehicle(&self) -> Option<BeyondVehicle> {
        self.drive.beyond_vehicle().filter(|_| !self.is_recorded)
    }

    /// Median of the time of a cycle that the planner itself did not measure, milliseconds.
    #[must_use]
    pub fn overhead(&self) -> Option<f64> {
        let mut ms = self.drive.external.as_ref()?.overhead_ms.clone();
        ms.sort_by(f64::total_cmp);
        median(&ms)
    }
}

/// The middle of what is in order; of an even number the mean of the two in the middle.
#[must_use]
pub fn median(sorted: &[f64]) -> Option<f64> {
    let upper = *sorted.get(sorted.len() / 2)?;
    Some(match sorted.len() % 2 {
        0 => f64::midpoint(sorted[sorted.len() / 2 - 1], upper),
        _ => upper,
    })
}

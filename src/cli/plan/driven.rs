//! Drives one scenario, or each of several, and reports the traffic rules that a drive broke.

use std::sync::Arc;

use nearmiss_drive::planner::{Cancel, Emergency};
use nearmiss_drive::simulation::{Collision, MOST_DRIVEN, Outcome, Rollout, Settings};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::scenario::Scenario;
use nearmiss_scene::traffic_rules::{Finding, Rule, RuleReport, Violation};
use nearmiss_workflow::{
    Monitor, MonitorReport, OpenRequest, PlanError, PlanOutcome, PlanRequest, PreparedPlan,
    StandIn, prepare,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::{DriveRecord, thousandths};
use super::options::{BUILT_IN, PlannerChoice, RECORDED};
use crate::output;

/// A drive, and of what.
pub struct DrivenScenario {
    /// The scenario's name.
    pub name: String,
    /// Its file, or that it is bundled.
    pub file: String,
    pub scenario: Arc<Scenario>,
    /// Id of the planning problem.
    pub problem: i64,
    pub settings: Settings,
    pub drive: Rollout,
    /// What a judge beside the planner said.
    pub monitor: Option<MonitorReport>,
    /// Obstacles that came near without contact; counted where a planner was named.
    pub near_misses: Option<usize>,
    /// What became of the rules of the road.
    pub rules: RuleReport,
    /// What became of them where the recorded ego of the same problem drives, if there is one.
    pub recorded_rules: Option<RuleReport>,
    /// It is the motion of the recorded ego.
    pub is_recorded: bool,
}

/// Opens a scenario to drive its ego.
pub fn request(
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

/// Drives the ego of a scenario, perhaps beside a monitor; nothing where `cancel` asked for an end. With `counts` its
/// cycles say how many candidates could be driven, which takes longer.
pub fn drive(
    entry: &Entry,
    problem: Option<i64>,
    settings: &Settings,
    planner: Option<&PlannerChoice>,
    (monitor, counts): (Option<&Monitor<'_>>, bool),
    cancel: &Cancel,
) -> Option<Result<DrivenScenario, PlanError>> {
    let external = planner.and_then(|planner| planner.external.clone());
    let prepared = request(entry, problem, settings);
    let prepared = prepared.map(|prepared| prepared.driven_by(external));
    let prepared = prepared.map(|prepared| {
        if counts {
            prepared
        } else {
            prepared.only_best()
        }
    });
    let is_recorded = planner.is_some_and(|planner| planner.is_recorded);
    let planned = prepared.and_then(|prepared| match monitor {
        None if is_recorded => Ok(Some((prepared.recorded_drive(cancel)?, None))),
        None => {
            let outcome = prepared.run(cancel, &mut |_| {})?;
            Ok(outcome.map(|outcome| (outcome, None)))
        }
        Some(monitor) => {
            let outcome = prepared.run_monitored(monitor, cancel, &mut |_| {})?;
            Ok(outcome.map(|(outcome, report)| (outcome, Some(report))))
        }
    });
    let driven = |(PlanOutcome { prepared, drive }, monitor)| DrivenScenario {
        name: output::visible(&entry.name),
        file: entry.display(),
        problem: prepared.problem().id,
        near_misses: planner.map(|_| {
            let (problem, settings) = (prepared.problem(), &prepared.settings);
            drive
                .near_misses(&prepared.driven(&drive), problem, settings)
                .len()
        }),
        rules: match prepared.recorded_ego().filter(|_| is_recorded) {
            Some(scene) => RuleReport::from_scene(scene),
            None => drive.rules(
                &prepared.driven(&drive),
                prepared.problem(),
                &prepared.settings,
            ),
        },
        is_recorded,
        recorded_rules: prepared
            .recorded_ego()
            .map(|scene| RuleReport::from_scene(scene)),
        settings: prepared.settings,
        scenario: prepared.driven(&drive),
        drive,
        monitor,
    };
    planned.map(|outcome| outcome.map(driven)).transpose()
}

impl DrivenScenario {
    pub fn outcome(&self) -> &Outcome {
        &self.drive.outcome
    }

    pub fn collision(&self) -> Option<&Collision> {
        match self.outcome() {
            Outcome::Collision(collision) => Some(collision),
            _ => None,
        }
    }

    /// Whether it ended as a drive may: at the goal, or out of time, without harm.
    pub fn unharmed(&self) -> bool {
        matches!(self.outcome(), Outcome::Goal(_) | Outcome::Timeout)
    }

    /// Steps that were driven.
    pub fn steps(&self) -> usize {
        self.drive.states.len().saturating_sub(1)
    }

    /// A note on a drive without a step, which ended where it starts, or on one that ended before the goal's time.
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
        if let Some(words) = self.planner_words() {
            return Some(words);
        }
        let problems = self.scenario.planning_problems.iter();
        let deadline = { problems }.find(|p| p.id == self.problem)?.deadline()?;
        let (last, _) = self.drive.states.last()?;
        (*self.outcome() == Outcome::Timeout && *last < deadline).then(|| {
            format!(
                "stopped after {MOST_DRIVEN} steps, the maximum; the goal's time ends at step {deadline}"
            )
        })
    }

    pub fn emergencies(&self) -> impl Iterator<Item = Emergency> {
        let cycles = self.drive.cycles.iter();
        cycles.filter_map(|cycle| cycle.plan.emergency)
    }

    /// Cycles in which the samples had to be refined.
    pub fn refined(&self) -> usize {
        let cycles = self.drive.cycles.iter();
        cycles.filter(|cycle| cycle.plan.refinements > 0).count()
    }

    /// Of planning one cycle, milliseconds: the middle one, and the longest; nothing without cycles.
    pub fn milliseconds(&self) -> Option<(f64, f64)> {
        let cycles = self.drive.cycles.iter();
        let mut ms: Vec<f64> = cycles.map(|c| c.took.as_secs_f64() * 1e3).collect();
        ms.sort_by(f64::total_cmp);
        Some((median(&ms)?, *ms.last()?))
    }

    /// Its planner, as it was named.
    pub fn planner(&self) -> &str {
        if self.is_recorded {
            return RECORDED;
        }
        let external = self.drive.external.as_ref();
        external.map_or(BUILT_IN, |report| &report.planner)
    }

    /// What went wrong with the planner's process, or why it found nothing to drive.
    pub fn planner_words(&self) -> Option<String> {
        let report = self.drive.external.as_ref()?;
        let words = report.failure().or_else(|| report.message.clone())?;
        Some(output::visible(&words))
    }

    /// Whether it has steps that the vehicle cannot do; not looked at in recordings, which are of other vehicles.
    pub fn is_beyond_vehicle(&self) -> Option<bool> {
        (!self.is_recorded).then(|| !self.drive.undrivable().is_empty())
    }

    /// That it has such steps, in a few words.
    pub fn beyond_words(&self) -> Option<String> {
        let beyond = self.drive.beyond_vehicle().filter(|_| !self.is_recorded)?;
        Some(format!(
            "{} beyond the vehicle",
            output::counted(beyond.steps, "step")
        ))
    }

    /// Median of the time of a cycle that the planner itself did not measure, milliseconds.
    pub fn overhead(&self) -> Option<f64> {
        let mut ms = self.drive.external.as_ref()?.overhead_ms.clone();
        ms.sort_by(f64::total_cmp);
        median(&ms)
    }
}

/// The middle of what is in order; of an even number the mean of the two in the middle.
pub fn median(sorted: &[f64]) -> Option<f64> {
    let upper = *sorted.get(sorted.len() / 2)?;
    Some(match sorted.len() % 2 {
        0 => f64::midpoint(sorted[sorted.len() / 2 - 1], upper),
        _ => upper,
    })
}

/// What became of a traffic rule.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RuleRecord {
    /// Its name.
    pub rule: String,
    /// Its number in the formalisation.
    pub number: String,
    /// broken, obeyed, not_applicable or undecided.
    pub status: String,
    /// Why.
    pub reason: Option<String>,
    /// When and where it was broken.
    pub violations: Vec<ViolationRecord>,
}

/// When and where a rule was broken.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ViolationRecord {
    from_step: i64,
    until_step: i64,
    from_seconds: f64,
    until_seconds: f64,
    x: f64,
    y: f64,
    lanelet: Option<i64>,
    obstacle: Option<i64>,
    /// By how much.
    amount: f64,
    unit: String,
}

impl RuleRecord {
    /// Of each rule, where a step takes `dt` seconds.
    pub fn all(report: &RuleReport, dt: f64) -> Vec<Self> {
        let findings = report.findings.iter();
        findings.map(|finding| Self::new(finding, dt)).collect()
    }

    fn new(finding: &Finding, dt: f64) -> Self {
        let violations = finding.violations.iter();
        Self {
            rule: finding.rule.name().into(),
            number: finding.rule.number().into(),
            status: finding.status.name().into(),
            reason: finding.reason.map(String::from),
            violations: violations
                .map(|violation| ViolationRecord::new(finding.rule, violation, dt))
                .collect(),
        }
    }
}

impl ViolationRecord {
    fn new(rule: Rule, violation: &Violation, dt: f64) -> Self {
        Self {
            from_step: violation.from,
            until_step: violation.until,
            from_seconds: thousandths(violation.from as f64 * dt),
            until_seconds: thousandths(violation.until as f64 * dt),
            x: thousandths(violation.at.x),
            y: thousandths(violation.at.y),
            lanelet: violation.lanelet,
            obstacle: violation.obstacle,
            amount: thousandths(violation.amount),
            unit: rule.unit().into(),
        }
    }
}

/// The rules that a drive broke.
fn broken_rules(drive: &DriveRecord) -> impl Iterator<Item = Rule> {
    let named = drive.rules_broken.iter();
    named.filter_map(|name| Rule::ALL.into_iter().find(|rule| name == rule.name()))
}

/// The rules that a drive broke, in a few words; nothing where it broke none.
pub fn broken_rules_note(drive: &DriveRecord) -> Option<String> {
    let broken: Vec<&str> = broken_rules(drive).map(Rule::text).collect();
    (!broken.is_empty()).then(|| format!("breaks {}", broken.join(", ")))
}

/// How many drives broke which rule.
#[derive(Debug, Default)]
pub struct RuleCounts([usize; Rule::ALL.len()]);

impl RuleCounts {
    /// Counts a drive.
    pub fn add(&mut self, drive: &DriveRecord) {
        for (count, rule) in self.0.iter_mut().zip(Rule::ALL) {
            *count += usize::from(broken_rules(drive).any(|broken| broken == rule));
        }
    }

    /// The counts on a line; nothing where no rule was broken.
    pub fn line(&self) -> Option<String> {
        let counted = self
            .0
            .iter()
            .zip(Rule::ALL)
            .filter(|(count, _)| **count > 0);
        let parts: Vec<String> = counted
            .map(|(count, rule)| format!("{} {count}", rule.text()))
            .collect();
        (!parts.is_empty()).then(|| format!("drives that break a rule: {}\n", parts.join(", ")))
    }
}

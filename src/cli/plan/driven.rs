//! One scenario, driven; and why one was not.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::cli::output;
use crate::planner::{Emergency, Limits};
use crate::scenario::{Entry, PlanningProblem, Scenario};
use crate::simulation::{self, Collision, Drive, Outcome, Settings};

/// A drive, and of what.
pub struct Driven {
    /// The scenario's name.
    pub name: String,
    /// Its file, or that it is bundled.
    pub file: String,
    pub scenario: Arc<Scenario>,
    /// Id of the planning problem.
    pub problem: i64,
    pub settings: Settings,
    pub drive: Drive,
}

/// Why nothing was driven, in words that begin with the scenario.
pub enum Missed {
    /// It cannot be read.
    Unread(String),
    /// It has no planning problem of that id, or its steps are too long for what was asked.
    Unfit(String),
    /// There is nothing in it that could be driven: a finding about the scenario.
    Nothing(String),
}

impl Missed {
    pub fn words(&self) -> &str {
        match self {
            Self::Unread(words) | Self::Unfit(words) | Self::Nothing(words) => words,
        }
    }
}

/// Drives the ego of a scenario's planning problem, the first one where no `problem` is named; ends early at `stop`.
pub fn drive(
    entry: &Entry,
    problem: Option<i64>,
    settings: &Settings,
    stop: &AtomicBool,
) -> Result<Driven, Missed> {
    let scenario = entry.read().map_err(|e| Missed::Unread(e.to_string()))?;
    let problem = chosen(entry, &scenario, problem)?;
    within_horizon(entry, &scenario, settings)?;
    let vehicle = settings.planner.vehicle;
    let (start, most) = (problem.initial.velocity, Limits::of(vehicle).speed);
    if let Some(start) = start.map(|v| v.middle()).filter(|v| *v > most) {
        return Err(Missed::Nothing(format!(
            "{}: planning problem {} starts at {start} m/s, and a {} goes {most} m/s at most; --vehicle names another",
            entry.display(),
            problem.id,
            vehicle.name()
        )));
    }
    let driven = simulation::drive_watched(&scenario, problem, settings, &mut |_, _| {
        !stop.load(Ordering::Relaxed)
    });
    let drive = driven.map_err(|e| Missed::Nothing(format!("{}: {e}", entry.display())))?;
    Ok(Driven {
        name: output::visible(&entry.name),
        file: entry.display(),
        problem: problem.id,
        settings: *settings,
        drive,
        scenario: Arc::clone(&scenario),
    })
}

pub fn chosen<'a>(
    entry: &Entry,
    scenario: &'a Scenario,
    wanted: Option<i64>,
) -> Result<&'a PlanningProblem, Missed> {
    let problems = &scenario.planning_problems;
    let Some(first) = problems.first() else {
        return Err(Missed::Nothing(format!(
            "{}: no planning problem in it, so there is nothing to plan",
            entry.display()
        )));
    };
    let Some(id) = wanted else { return Ok(first) };
    problems.iter().find(|p| p.id == id).ok_or_else(|| {
        let mut known: Vec<String> = problems
            .iter()
            .take(NAMED)
            .map(|p| p.id.to_string())
            .collect();
        if problems.len() > NAMED {
            known.push(format!("and {} more", problems.len() - NAMED));
        }
        let ids = match &known[..] {
            [only] => format!("the only one in it has the id {only}"),
            _ => format!("those in it have the ids {}", known.join(", ")),
        };
        Missed::Unfit(format!(
            "{}: no planning problem has the id {id}; {ids}",
            entry.display()
        ))
    })
}

/// A plan ends at the horizon: nothing of it can be driven beyond.
pub fn within_horizon(
    entry: &Entry,
    scenario: &Scenario,
    settings: &Settings,
) -> Result<(), Missed> {
    let (dt, horizon) = (scenario.dt(), settings.planner.horizon);
    let most = settings.planner.steps(dt);
    if settings.replan <= most {
        return Ok(());
    }
    Err(Missed::Unfit(format!(
        "{}: {} steps of a plan cannot be driven before the next one: with a horizon of {horizon} s and {dt} s a step it \
         has {most}; --replan {most} at most, or a longer --horizon",
        entry.display(),
        settings.replan
    )))
}

/// So many planning problems are named where one has to be chosen.
const NAMED: usize = 12;

impl Driven {
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

    /// What there is to say of a drive without a step, which ended where it starts.
    pub fn note(&self) -> Option<&'static str> {
        (self.steps() == 0).then(|| match self.outcome() {
            Outcome::Goal(_) => "the goal holds at the start already",
            Outcome::Collision(_) => "they touch at the start already",
            Outcome::Timeout => "the goal's time is over at the start already",
            Outcome::OffRoad => "off the road at the start already",
            Outcome::Infeasible => "the vehicle cannot be driven from the start",
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

    /// The strongest braking, m/s²; 0 where nobody braked.
    pub fn largest_deceleration(&self) -> f64 {
        let states = self.drive.states.iter();
        states.map(|(_, s)| -s.acceleration).fold(0.0, f64::max)
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

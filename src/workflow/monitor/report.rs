//! How well a monitor warned: lead time, false alarms and latency of a drive.

use super::{Monitor, in_force};
use nearmiss_drive::generation::NEAR_MISS;
use nearmiss_drive::simulation::{Outcome, Rollout};
use nearmiss_scene::metrics::{Context, MEASURES, Series};
use nearmiss_scene::scenario::Scene;
use nearmiss_store::RunId;
use nearmiss_study::evaluation::Case;

/// An answer of the monitor.
#[derive(Debug, Clone, PartialEq)]
pub struct MonitorAnswer {
    /// The time step at which was asked.
    pub step: i64,
    /// The verdict; `None` if the answer has none.
    pub dangerous: Option<bool>,
    /// Seconds until it arrived.
    pub latency: f64,
    /// The first time step at which it counts.
    pub from: i64,
    /// Its number in the store.
    pub run: Option<RunId>,
    /// Whether it was in the store already.
    pub stored: bool,
    /// Its cost now, US dollars, where that is known.
    pub usd: Option<f64>,
}

/// Time steps in a row at which a warning was in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Warning {
    /// The first.
    pub first: i64,
    /// The last.
    pub last: i64,
    /// The last one before the question whose answer takes it back: `last`, if answers came at once. The horizon of a
    /// false alarm counts from here, so that a slow answer makes no warning true.
    pub meant_until: i64,
}

/// What a warning is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Incident {
    /// The ego touches an obstacle at this step.
    Contact(i64),
    /// The risk score of an obstacle falls to 1 or below at this step.
    NearMiss(i64),
}

/// A drive as its monitor saw it.
#[derive(Debug, Clone, PartialEq)]
pub struct MonitorReport {
    /// Id of the judge.
    pub judge: String,
    /// Seconds between two questions.
    pub every: f64,
    /// Every answer, in order.
    pub answers: Vec<MonitorAnswer>,
    /// Every warning, in order.
    pub warnings: Vec<Warning>,
    /// The first contact or near miss: the contact if there is one.
    pub incident: Option<Incident>,
    /// Seconds from the first warning that is no false alarm to the incident; `None` without such a warning before it.
    pub lead: Option<f64>,
    /// Warnings after whose first step, until the horizon after the judge takes them back, there is neither a contact
    /// nor a near miss.
    pub false_alarms: usize,
    /// Seconds driven.
    pub driven: f64,
    /// Steps at which the ego braked for a warning.
    pub braked: usize,
    /// The first of these steps.
    pub first_braked: Option<i64>,
    /// Seconds until an answer counts, where that is set in place of the measured ones.
    pub set_latency: Option<f64>,
    dt: f64,
}

impl Incident {
    /// Its time step.
    #[must_use]
    pub fn step(self) -> i64 {
        match self {
            Self::Contact(step) | Self::NearMiss(step) => step,
        }
    }

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Contact(_) => "contact",
            Self::NearMiss(_) => "near_miss",
        }
    }
}

impl MonitorReport {
    pub(super) fn new(
        monitor: &Monitor<'_>,
        answers: Vec<MonitorAnswer>,
        braked: &[i64],
        drive: &Rollout,
        scene: &Scene,
    ) -> Self {
        let steps = drive.states.iter().map(|(step, _)| *step);
        let warnings = warnings(steps, &answers);
        let contact = match drive.outcome {
            Outcome::Collision(collision) => Some(collision.step),
            _ => None,
        };
        let dangerous = dangerous_steps(scene, monitor, contact);
        let horizon = (Case::HORIZON / drive.dt).round() as i64;
        let near = dangerous.first().map(|step| Incident::NearMiss(*step));
        let incident = contact.map(Incident::Contact).or(near);
        Self {
            judge: monitor.judge.id().to_string(),
            every: monitor.steps(drive.dt) as f64 * drive.dt,
            lead: lead(&warnings, &dangerous, incident, horizon).map(|n| n as f64 * drive.dt),
            false_alarms: warnings
                .iter()
                .filter(|warning| is_false(warning, &dangerous, horizon))
                .count(),
            driven: drive.states.len().saturating_sub(1) as f64 * drive.dt,
            dt: drive.dt,
            answers,
            warnings,
            incident,
            braked: braked.len(),
            first_braked: braked.first().copied(),
            set_latency: monitor.latency,
        }
    }

    /// Time of the first warning, seconds since time step 0.
    #[must_use]
    pub fn first_warning(&self) -> Option<f64> {
        self.warnings.first().map(|w| w.first as f64 * self.dt)
    }

    /// False alarms per minute of driving; `None` if nothing was driven.
    #[must_use]
    pub fn false_alarms_per_minute(&self) -> Option<f64> {
        (self.driven > 0.0).then(|| self.false_alarms as f64 * 60.0 / self.driven)
    }

    /// Time of the first braking for a warning, seconds since time step 0.
    #[must_use]
    pub fn first_braking(&self) -> Option<f64> {
        self.first_braked.map(|step| step as f64 * self.dt)
    }

    /// Seconds of braking for warnings.
    #[must_use]
    pub fn braking(&self) -> f64 {
        self.braked as f64 * self.dt
    }

    /// Seconds until answers counted: the set latency, else the median of the measured ones.
    #[must_use]
    pub fn latency_in_force(&self) -> Option<f64> {
        self.set_latency.or_else(|| self.latency())
    }

    /// The median latency, seconds, as measured.
    #[must_use]
    pub fn latency(&self) -> Option<f64> {
        let mut all: Vec<f64> = self.answers.iter().map(|answer| answer.latency).collect();
        all.sort_by(f64::total_cmp);
        let upper = *all.get(all.len() / 2)?;
        Some(match all.len() % 2 {
            0 => f64::midpoint(all[all.len() / 2 - 1], upper),
            _ => upper,
        })
    }

    /// Answers without a verdict.
    #[must_use]
    pub fn without_verdict(&self) -> usize {
        let answers = self.answers.iter();
        answers.filter(|answer| answer.dangerous.is_none()).count()
    }
}

/// Steps in a row at which a warning is in force.
fn warnings(steps: impl Iterator<Item = i64>, answers: &[MonitorAnswer]) -> Vec<Warning> {
    let mut warnings: Vec<Warning> = Vec::new();
    for step in steps.filter(|step| in_force(answers, *step)) {
        match warnings.last_mut() {
            Some(warning) if warning.last + 1 == step => warning.last = step,
            _ => warnings.push(Warning {
                first: step,
                last: step,
                meant_until: step,
            }),
        }
    }
    for warning in &mut warnings {
        warning.meant_until = meant_until(warning.last, answers);
    }
    warnings
}

/// The last step before the question that takes back what is in force at the last step of a warning.
fn meant_until(last: i64, answers: &[MonitorAnswer]) -> i64 {
    let mut arrived = answers.iter().rev().filter(|answer| answer.from <= last);
    let decisive = arrived.find(|answer| answer.dangerous.is_some());
    let asked = decisive.map_or(last, |answer| answer.step);
    let mut later = answers.iter().filter(|answer| answer.step > asked);
    let back = later.find(|answer| answer.dangerous == Some(false));
    // One that is never taken back lasts to the end.
    back.map_or(last, |answer| last.min(answer.step - 1))
}

/// Steps of contact or with a risk score of a near miss, in order.
fn dangerous_steps(scene: &Scene, monitor: &Monitor<'_>, contact: Option<i64>) -> Vec<i64> {
    let context = Context::under(scene, &monitor.thresholds);
    let risk = MEASURES.iter().filter(|m| m.id == "risk").collect();
    let series = Series::from_context(&context, risk);
    let is_near = |step: &i64| {
        let lowest = series.most_dangerous_at("risk", *step);
        lowest.is_some_and(|(_, score)| score <= f64::from(NEAR_MISS))
    };
    let steps = series.steps();
    steps
        .filter(|step| Some(*step) == contact || is_near(step))
        .collect()
}

/// Whether no danger follows a warning within the horizon, steps.
fn is_false(warning: &Warning, dangerous: &[i64], horizon: i64) -> bool {
    let until = warning.meant_until.saturating_add(horizon);
    let followed = warning.first..=until;
    !dangerous.iter().any(|step| followed.contains(step))
}

/// Steps from the first warning before the incident that is no false alarm to the incident.
fn lead(
    warnings: &[Warning],
    dangerous: &[i64],
    incident: Option<Incident>,
    horizon: i64,
) -> Option<i64> {
    let at = incident?.step();
    let mut before = warnings.iter().filter(|warning| warning.first <= at);
    let first = before.find(|warning| !is_false(warning, dangerous, horizon))?;
    Some(at - first.first)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(step: i64, dangerous: Option<bool>, from: i64) -> MonitorAnswer {
        MonitorAnswer {
            step,
            dangerous,
            latency: 0.1,
            from,
            run: None,
            stored: false,
            usd: None,
        }
    }

    #[test]
    fn answers_count_once_they_have_arrived_and_the_newest_question_wins() {
        let answers = [
            answer(10, Some(true), 25),
            answer(20, Some(false), 22),
            answer(30, None, 31),
            answer(40, Some(true), 41),
        ];
        let warned = warnings(0..50, &answers);
        // The late answer to the older question does not overrule the newer one.
        assert_eq!(
            warned,
            [Warning {
                first: 41,
                last: 49,
                meant_until: 49,
            }]
        );
        let alone = warnings(0..30, &answers[..1]);
        assert_eq!(alone[0].first, 25);
    }

    #[test]
    fn leads_count_from_true_warnings_and_false_alarms_are_the_others() {
        let warnings = [
            Warning {
                first: 5,
                last: 9,
                meant_until: 9,
            },
            Warning {
                first: 40,
                last: 45,
                meant_until: 45,
            },
        ];
        let dangerous = [60];
        let incident = Some(Incident::Contact(60));
        assert!(is_false(&warnings[0], &dangerous, 20));
        assert!(!is_false(&warnings[1], &dangerous, 20));
        assert_eq!(lead(&warnings, &dangerous, incident, 20), Some(20));
        assert_eq!(lead(&warnings[..1], &dangerous, incident, 20), None);
        assert_eq!(lead(&warnings, &[], None, 20), None);
    }

    /// The same questions and the same drive, with answers that come ever later.
    #[test]
    fn a_slower_monitor_has_no_longer_lead_and_no_fewer_false_alarms() {
        // Critical at 20, taken back at 40; again at 70. Near misses at 61 and 80.
        let said = [(20, true), (40, false), (70, true), (90, false)];
        let (dangerous, incident) = ([61, 80], Some(Incident::NearMiss(61)));
        let mut before = (i64::MAX, 0);
        for latency in 1..30 {
            let answers =
                said.map(|(step, dangerous)| answer(step, Some(dangerous), step + latency));
            let warned = warnings(0..120, &answers);
            assert_eq!(warned[0].meant_until, 39, "{warned:?}");
            let lead = lead(&warned, &dangerous, incident, 20).unwrap_or(0);
            let alarms = warned
                .iter()
                .filter(|w| is_false(w, &dangerous, 20))
                .count();
            assert!(lead <= before.0 && alarms >= before.1, "{latency}");
            before = (lead, alarms);
        }
        // An end of the horizon that moves with the answers would make the first warning true at a latency of 2.
        assert_eq!(before.0, 0);
    }
}

//! Scenarios by their most severe moment, each measured once as long as its files are the same.

use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use serde::Serialize;

use super::scenes::{Read, are_current};
use nearmiss_scene::corpus::worst_moments;
use nearmiss_scene::metrics::{
    Context, CriticalMoment, SEVERITY_NAMES, Thresholds, critical_moments,
};
use nearmiss_scene::scenario::{Scenario, Scene};
use nearmiss_workflow::INDEX_RADIUS;

/// A most severe moment, as clients are told of it.
#[derive(Debug, Clone, Serialize)]
pub struct Worst {
    /// 0 (contact) to 5 (none).
    severity: u8,
    /// The name of that number.
    called: &'static str,
    /// The time step.
    at: i64,
    /// The obstacle that is the ego, where none is recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    ego: Option<i64>,
    obstacle: i64,
    /// The type of the obstacle.
    #[serde(rename = "type")]
    kind: &'static str,
    /// What happens.
    why: String,
    #[serde(skip)]
    moment: CriticalMoment,
}

impl Worst {
    fn new(scenario: &Scenario, ego: Option<i64>, moment: CriticalMoment) -> Self {
        let mut all = scenario.obstacles.iter();
        let obstacle = all.find(|one| one.id == moment.obstacle);
        let severity = moment.grade.number();
        Self {
            severity,
            called: SEVERITY_NAMES[usize::from(severity)],
            at: moment.step,
            ego,
            obstacle: moment.obstacle,
            kind: obstacle.map_or("unknown", |one| one.kind.name()),
            why: moment.hazard.to_string(),
            moment,
        }
    }

    /// The most severe moment with each obstacle, the most severe first; without an ego that of each road user.
    pub fn all(
        scenario: &Arc<Scenario>,
        scene: Option<&Scene>,
        thresholds: &Thresholds,
    ) -> Vec<Self> {
        match scene {
            Some(scene) => { critical_moments(&Context::under(scene, thresholds)).into_iter() }
                .map(|moment| Self::new(scenario, None, moment))
                .collect(),
            None => {
                let egos = scenario.possible_egos();
                { worst_moments(scenario, &egos, INDEX_RADIUS, thresholds).into_iter() }
                    .map(|worst| Self::new(scenario, Some(worst.ego), worst.moment))
                    .collect()
            }
        }
    }
}

/// A scenario of the list.
#[derive(Debug, Clone, Serialize)]
pub struct Ranked {
    /// Its name.
    scenario: String,
    #[serde(flatten)]
    worst: Option<Worst>,
    /// Why it cannot be opened.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

impl Ranked {
    /// A scenario with its most severe moment, or why it cannot be opened.
    pub fn new(scenario: String, worst: Result<Option<Worst>, String>) -> Self {
        let (worst, error) = match worst {
            Ok(worst) => (worst, None),
            Err(why) => (None, Some(why)),
        };
        Self {
            scenario,
            worst,
            error,
        }
    }

    /// Sorts the most severe ones first, and those that cannot be opened last.
    pub fn sort(all: &mut [Self]) {
        let rank = |one: &Self| (one.error.is_some(), one.worst.is_none());
        all.sort_by(|a, b| {
            let by_moment = || {
                Some(
                    a.worst
                        .as_ref()?
                        .moment
                        .compare_across(&b.worst.as_ref()?.moment),
                )
            };
            let by_rank = rank(a).cmp(&rank(b));
            by_rank.then_with(|| by_moment().unwrap_or(std::cmp::Ordering::Equal))
        });
    }
}

/// What was measured so far, by place.
#[derive(Debug, Default)]
pub struct Ranks(Mutex<HashMap<String, Measured>>);

/// What a scenario was read from, and its most severe moment.
type Measured = (Vec<Read>, Option<Worst>);

impl Ranks {
    /// What was measured of a scenario, if its files, with the recording beside it, are still the same.
    pub fn get(&self, place: &str, recorded: Option<&Path>) -> Option<Option<Worst>> {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (files, worst) = all.get(place)?;
        let is_read = |file: &Path| files.iter().any(|(read, _)| read == file);
        (recorded.is_none_or(is_read) && are_current(files)).then(|| worst.clone())
    }

    /// Keeps what was measured.
    pub fn keep(&self, place: String, files: Vec<Read>, worst: Option<Worst>) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.insert(place, (files, worst));
    }
}

//! The moment of a recording that is worst for each road user, by the measure that the index grades windows with.

use std::cmp::Ordering;
use std::sync::Arc;

use rayon::prelude::*;

use crate::metrics::{Context, MEASURES, Measure, Thresholds, UNROUNDED_RISK};
use crate::scenario::{ObstacleRole, Scenario, Scene};

/// The worst moment of a road user.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstMoment {
    /// The road user, as the ego.
    pub ego: i64,
    /// Who endangers it.
    pub other: i64,
    /// The step.
    pub step: i64,
    /// The risk score at it, 0 (collision) to 5 (negligible).
    pub severity: u8,
    /// The same before it is rounded.
    pub risk: f64,
    /// The time to collision at it, seconds; infinite where they would not meet.
    pub ttc: f64,
    /// Whether the other one is ahead of the ego at it.
    other_is_ahead: bool,
}

/// What is slower stands, m/s.
const STANDING: f64 = 0.5;

/// Moments of the same two nearer to each other than this are one, seconds.
const SAME: f64 = 10.0;

/// The worst moment of each of these road users that moves, the most dangerous first; each pair is there once, with the one behind
/// as the ego. Pairs whose centres are farther apart than `radius` metres are not measured.
///
/// Moments without any risk are left out if there are others.
#[must_use]
pub fn worst_moments(
    scenario: &Arc<Scenario>,
    egos: &[i64],
    radius: f64,
    thresholds: &Thresholds,
) -> Vec<WorstMoment> {
    let Some(measures) = Measures::find() else {
        return Vec::new();
    };
    let worst = egos.par_iter().filter_map(|id| {
        let scene = Scene::with_obstacle_as_ego(Arc::clone(scenario), *id).ok()?;
        let mut moving = scene.ego.track.iter();
        if !moving.any(|(_, motion)| motion.velocity.abs() >= STANDING) {
            return None;
        }
        measures.worst_of(&Context::under(&scene, thresholds), radius)
    });
    let mut all: Vec<WorstMoment> = worst.collect();
    if all.iter().any(WorstMoment::is_any_risk) {
        all.retain(WorstMoment::is_any_risk);
    }
    all.sort_by(|a, b| a.compare(b).then(a.ego.cmp(&b.ego)));
    once_each(all, (SAME / scenario.dt()) as i64)
}

/// Each pair once at a time, with the one behind as the ego.
fn once_each(all: Vec<WorstMoment>, near: i64) -> Vec<WorstMoment> {
    let mut taken: Vec<WorstMoment> = Vec::with_capacity(all.len());
    for moment in all {
        let twin = taken.iter_mut().find(|t| {
            (t.ego, t.other) == (moment.other, moment.ego) && (t.step - moment.step).abs() < near
        });
        match twin {
            Some(twin) if moment.other_is_ahead && !twin.other_is_ahead => *twin = moment,
            Some(_) => {}
            None => taken.push(moment),
        }
    }
    taken
}

impl WorstMoment {
    /// The more dangerous one first.
    fn compare(&self, other: &Self) -> Ordering {
        let severity = self.severity.cmp(&other.severity);
        let risk = severity.then(self.risk.total_cmp(&other.risk));
        risk.then(self.ttc.total_cmp(&other.ttc))
    }

    fn is_any_risk(&self) -> bool {
        self.severity < 5 || self.ttc.is_finite()
    }
}

/// What moments are compared by.
struct Measures {
    risk: &'static Measure,
    ttc: &'static Measure,
}

impl Measures {
    fn find() -> Option<Self> {
        let find = |id: &str| MEASURES.iter().find(|measure| measure.id == id);
        Some(Self {
            risk: find("risk")?,
            ttc: find("ttc")?,
        })
    }

    fn worst_of(&self, context: &Context<'_>, radius: f64) -> Option<WorstMoment> {
        let track = &context.scene().ego.track;
        let mut worst: Option<WorstMoment> = None;
        for (place, other) in context.participants().iter().enumerate() {
            let own = track.steps();
            let theirs = match other.obstacle.role {
                ObstacleRole::Static => own.clone(),
                _ => other.obstacle.track().steps(),
            };
            for step in own.start.max(theirs.start)..own.end.min(theirs.end) {
                let (Some(ego), Some(body)) = (track.at(step), other.at(step)) else {
                    continue;
                };
                let apart = body.pose.position - ego.pose.position;
                if apart.norm() > radius {
                    continue;
                }
                let Some(encounter) = context.encounter(place, step) else {
                    continue;
                };
                let Some(risk) = self.risk.of(&encounter).value() else {
                    continue;
                };
                let mut moment = WorstMoment {
                    ego: context.scene().ego.id,
                    other: other.obstacle.id,
                    step,
                    severity: risk as u8,
                    risk: 0.0,
                    ttc: f64::INFINITY,
                    other_is_ahead: apart.dot(&ego.pose.forward()) >= 0.0,
                };
                // Each is computed only where those before it do not tell.
                let known = worst.map(|worst| moment.severity.cmp(&worst.severity));
                if known == Some(Ordering::Greater) {
                    continue;
                }
                moment.risk = UNROUNDED_RISK.of(&encounter).value().unwrap_or(risk);
                let known = worst.map(|worst| {
                    moment.compare(&WorstMoment {
                        ttc: f64::INFINITY,
                        ..worst
                    })
                });
                if known == Some(Ordering::Greater) {
                    continue;
                }
                let ttc = self.ttc.of(&encounter).value();
                moment.ttc = ttc.unwrap_or(f64::INFINITY);
                if worst.is_none_or(|worst| moment.compare(&worst).is_lt()) {
                    worst = Some(moment);
                }
            }
        }
        worst
    }
}

//! Headline numbers that distinguish scenes in a list.

use super::{Contact, Context, CriticalMoment, MEASURES, Series, Thresholds, critical_moments};
use crate::scenario::Scene;

/// A smallest value: how much, when, who.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// In the measure's unit.
    pub value: f64,
    /// When, first.
    pub step: i64,
    /// The obstacle.
    pub obstacle: i64,
}

/// The greatest danger in a scene.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Headline {
    /// The most severe moment with each obstacle, the most severe first.
    pub moments: Vec<CriticalMoment>,
    /// The first contact, at a step or between two.
    pub contact: Option<Contact>,
    /// Smallest distance at a step, metres (MDC).
    pub distance: Option<Nearest>,
    /// Smallest time to collision, seconds.
    pub ttc: Option<Nearest>,
    /// Smallest risk score, where it is nearest.
    pub risk: Option<Nearest>,
}

impl Headline {
    /// The smallest values of a series of this scene with the measures `distance`, `ttc` and `risk`, and the moments that
    /// matter.
    #[must_use]
    pub fn new(context: &Context<'_>, series: &Series) -> Self {
        let obstacles = series.obstacles();
        let contacts = obstacles.iter().filter_map(|&id| series.contact(id));
        Self {
            moments: critical_moments(context),
            contact: contacts.min_by(|a, b| a.time.total_cmp(&b.time)),
            distance: nearest(series, "distance"),
            ttc: nearest(series, "ttc"),
            risk: worst_risk(series),
        }
    }

    /// The same, measured in a scene.
    #[must_use]
    pub fn compute(scene: &Scene, thresholds: &Thresholds) -> Self {
        Self::of(&Context::under(scene, thresholds))
    }

    /// The same of a context.
    #[must_use]
    pub fn of(context: &Context<'_>) -> Self {
        let wanted = ["distance", "ttc", "risk"];
        let measures = MEASURES.iter().filter(|m| wanted.contains(&m.id));
        Self::new(context, &Series::from_context(context, measures.collect()))
    }

    /// The moment that matters: the most severe one (see [`critical_moments`]). The workbench, `--at worst` and figures
    /// all go there.
    #[must_use]
    pub fn worst(&self) -> Option<&CriticalMoment> {
        self.moments.first()
    }

    /// The moment that matters with one obstacle.
    #[must_use]
    pub fn worst_with(&self, obstacle: i64) -> Option<&CriticalMoment> {
        self.moments
            .iter()
            .find(|moment| moment.obstacle == obstacle)
    }

    /// Whether the ego touches an obstacle, at a recorded step or between two.
    #[must_use]
    pub fn collides(&self) -> bool {
        self.contact.is_some()
    }
}

/// The lowest risk score, at its smallest distance.
fn worst_risk(series: &Series) -> Option<Nearest> {
    let lowest = nearest(series, "risk")?;
    let mut worst: Option<(f64, Nearest)> = None;
    for &obstacle in series.obstacles() {
        let row = series.row("risk", obstacle).iter();
        let distances = series.row("distance", obstacle);
        for ((step, risk), distance) in series.steps().zip(row).zip(distances) {
            if risk.value() != Some(lowest.value) {
                continue;
            }
            let distance = distance.value().unwrap_or(f64::INFINITY);
            let nearer = worst
                .is_none_or(|(best, at)| distance < best || (distance == best && step < at.step));
            if nearer {
                let here = Nearest {
                    step,
                    obstacle,
                    ..lowest
                };
                worst = Some((distance, here));
            }
        }
    }
    worst.map(|(_, at)| at).or(Some(lowest))
}

fn nearest(series: &Series, measure: &str) -> Option<Nearest> {
    let mut best: Option<Nearest> = None;
    for &obstacle in series.obstacles() {
        let row = series.row(measure, obstacle);
        for (step, reading) in series.steps().zip(row) {
            let Some(value) = reading.value() else {
                continue;
            };
            // Among equals the earlier step wins, whatever the order in the file.
            let better =
                best.is_none_or(|b| value < b.value || (value == b.value && step < b.step));
            if better {
                best = Some(Nearest {
                    value,
                    step,
                    obstacle,
                });
            }
        }
    }
    best
}

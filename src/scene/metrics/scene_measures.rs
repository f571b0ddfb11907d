//! Measures of the whole scene at one step, and headline numbers that distinguish scenes in a list.

use super::recorded::Starts;
use super::{
    Contact, Context, CriticalMoment, Danger, NoValue, Reading, Series, Thresholds,
    critical_moments, measures,
};
use crate::scenario::Scene;

/// A measure of the ego against all obstacles at one step.
#[derive(Debug)]
pub struct SceneMeasure {
    /// Short name, that of the measure of one obstacle which it sums up.
    pub id: &'static str,
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Which values are dangerous.
    pub danger: Danger,
    /// The source of its definition.
    pub source: &'static str,
    /// Computes it at a step.
    pub compute: fn(&Context<'_>, i64) -> Reading,
}

/// Every measure of whole scenes.
///
/// The times to manoeuvres are not minima over single obstacles: here one manoeuvre avoids all obstacles.
pub const SCENE_MEASURES: &[SceneMeasure] = &[
    SceneMeasure {
        id: "dce",
        name: "distance of the closest encounter",
        unit: "m",
        danger: Danger::Low,
        source: "smallest recorded distance to any obstacle from now on (Eggert 2014)",
        compute: |context, step| {
            least(context, step, |c, other, i| {
                c.closest(other, i).map(|x| x.distance)
            })
        },
    },
    SceneMeasure {
        id: "ttc_star",
        name: "time to the recorded overlap",
        unit: "s",
        danger: Danger::Low,
        source: "recorded time until the ego overlaps any obstacle (TTC* of CriMe)",
        compute: |context, step| {
            let overlap =
                |c: &Context<'_>, other, i| Some(c.time(i, c.closest(other, i)?.contact?));
            match least(context, step, overlap) {
                Reading::None(NoValue::Absent) if context.ego_is_there(step) => {
                    Reading::None(NoValue::NoRecordedOverlap)
                }
                found => found,
            }
        },
    },
    manoeuvre(
        "ttb",
        "time to brake",
        "latest full braking that avoids all obstacles (Hillenbrand 2006)",
        |context, step| time(context, step, Starts::brake),
    ),
    manoeuvre(
        "ttk",
        "time to kick down",
        "latest full acceleration that avoids all obstacles (Tamke 2011)",
        |context, step| time(context, step, Starts::kick_down),
    ),
    manoeuvre(
        "tts",
        "time to steer",
        "latest evasive steering that avoids all obstacles (Hillenbrand 2006)",
        |context, step| time(context, step, Starts::steer),
    ),
    manoeuvre(
        "ttr",
        "time to react",
        "largest of ttb, ttk and tts (Hillenbrand 2006)",
        |context, step| time(context, step, Starts::react),
    ),
];

const fn manoeuvre(
    id: &'static str,
    name: &'static str,
    source: &'static str,
    compute: fn(&Context<'_>, i64) -> Reading,
) -> SceneMeasure {
    SceneMeasure {
        id,
        name,
        unit: "s",
        danger: Danger::Low,
        source,
        compute,
    }
}

fn least(
    context: &Context<'_>,
    step: i64,
    value: impl Fn(&Context<'_>, usize, usize) -> Option<f64>,
) -> Reading {
    let found = context.index(step).and_then(|index| {
        let others = 0..context.participants().len();
        let values = others.filter_map(|other| value(context, other, index));
        values.min_by(f64::total_cmp)
    });
    found.ok_or(NoValue::Absent).into()
}

fn time(
    context: &Context<'_>,
    step: i64,
    until: fn(&Starts, usize) -> Result<usize, NoValue>,
) -> Reading {
    let index = context.index(step).filter(|_| context.ego_is_there(step));
    let time = index
        .ok_or(NoValue::Absent)
        .and_then(|now| Ok(until(context.starts(), now)? as f64 * context.dt()));
    time.into()
}

impl Context<'_> {
    fn ego_is_there(&self, step: i64) -> bool {
        self.index(step)
            .is_some_and(|index| self.ego[index].is_some())
    }
}

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
        Self::from_context(&Context::under(scene, thresholds))
    }

    /// The same of a context.
    #[must_use]
    pub fn from_context(context: &Context<'_>) -> Self {
        let wanted = ["distance", "ttc", "risk"];
        let measures = measures().filter(|m| wanted.contains(&m.id));
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

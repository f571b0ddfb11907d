//! Measures of the whole scene at one step: of the ego against all obstacles together.

use super::recorded::Starts;
use super::{Context, Danger, NoValue, Reading};

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

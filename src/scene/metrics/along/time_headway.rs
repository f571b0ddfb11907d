//! Time headway: the time until the ego's front is where the rear of the one ahead is now, as recorded.
//!
//! THW = min { t ≥ 0 : front_ego(t₀ + t) ≥ rear_other(t₀) } along the route; between two recorded steps it goes evenly.
//! Source: Jansson, Collision Avoidance Theory, 2005.

use super::super::{Context, Danger, Encounter, Measure, Mirrored, NoValue, Reading};

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "thw",
    name: "time headway",
    unit: "s",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: true,
    source: "recorded time until the ego is where the other's rear is now (Jansson 2005)",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    encounter.ask(time).into()
}

fn time(context: &Context<'_>, participant: usize, index: usize) -> Result<f64, NoValue> {
    let rear = context.following(participant, index)?.other.rear;
    let reached = context
        .ego_reaches(rear, index)
        .ok_or(NoValue::NotReached)?;
    // On the way to that step; a gap in the recording before it hides when.
    let front = |index| context.ego_along(index).map(|ego| ego.front);
    let before = reached.checked_sub(1).filter(|before| *before >= index);
    let late = match (before.and_then(|before| front(before).ok()), front(reached)) {
        (Some(before), Ok(front)) if front > before => (front - rear) / (front - before),
        _ => 0.0,
    };
    Ok(context.time(index, reached as f64 - late.clamp(0.0, 1.0)))
}

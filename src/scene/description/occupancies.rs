//! Sentences about obstacles that are given as occupancy sets: how near the regions come, and nothing about motion.

use super::options::Options;
use super::parts::{name, subject};
use super::writer::Writer;
use crate::metrics::Context;
use crate::scenario::Window;

/// A line for every obstacle whose region comes near in the window, at the described steps.
pub(super) fn describe(w: &mut Writer, context: &Context<'_>, window: &Window, options: &Options) {
    let everyone = context.participants().iter().enumerate();
    for (place, other) in everyone.filter(|(_, p)| p.obstacle.is_set_based()) {
        if options.obstacle.is_some_and(|id| id != other.obstacle.id) {
            continue;
        }
        let near = |step: i64| {
            let encounter = context.encounter(place, step)?;
            let is_region = encounter.is_with_occupancy();
            is_region.then(|| (encounter.distance(), step))
        };
        let nearest = options
            .steps(window)
            .into_iter()
            .filter_map(near)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((distance, step)) = nearest.filter(|(d, _)| *d <= options.radius) else {
            continue;
        };
        w.about(subject(other), Some(step)).words("\nThe ");
        name(w, other);
        w.words(
            " is given as a region that it may cover (predicted occupancy), without heading or velocity: the region is nearest at t = ",
        )
        .time(step, context.scene().scenario.dt())
        .words(" s, distance ")
        .number("distance", distance)
        .words(" m.\n");
    }
}

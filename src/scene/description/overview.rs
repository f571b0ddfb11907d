//! The overview of a long window: everyone that comes near at any step, and the nearest moment of each.

use std::collections::{BTreeMap, HashMap};

use super::options::{Moment, Options};
use super::writer::{Subject, Writer};
use crate::metrics::Encounter;
use crate::scenario::{Participant, Scene, Window};

/// The obstacles that are near the ego as descriptions have it at any step of a window, described or not, in the order
/// in which they come near.
pub(super) fn came_near<'a>(
    scene: &'a Scene,
    window: &Window,
    options: &Options,
) -> Vec<Participant<'a>> {
    let mut first: HashMap<i64, i64> = HashMap::new();
    for step in window.steps() {
        for (other, _) in options.near(scene, step) {
            first.entry(other.obstacle.id).or_insert(step);
        }
    }
    let everyone = scene.participants().filter(|p| !p.obstacle.is_set_based());
    let mut found: Vec<_> = everyone
        .filter_map(|p| Some((*first.get(&p.obstacle.id)?, p)))
        .collect();
    found.sort_by_key(|(step, _)| *step);
    found
        .into_iter()
        .map(|(_, participant)| participant)
        .collect()
}

/// The steps at which these obstacles are nearest to the ego in a window, body to body, in order, each with those that
/// are.
pub(super) fn nearest_moments<'a>(
    scene: &'a Scene,
    window: &Window,
    everyone: &[Participant<'a>],
) -> Vec<Moment<'a>> {
    let mut moments: BTreeMap<i64, Vec<_>> = BTreeMap::new();
    for other in everyone {
        let distance = |step: i64| Some((Encounter::at(scene, other, step)?.distance(), step));
        let nearest = window
            .steps()
            .filter_map(distance)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        // The motion outlives the encounter: it is the scene's.
        let motion = nearest.and_then(|(_, step)| Some((step, other.at(step)?)));
        if let Some((step, motion)) = motion {
            moments.entry(step).or_default().push((*other, motion));
        }
    }
    let moment = |(step, near)| Moment {
        step,
        near,
        left_out: false,
    };
    moments.into_iter().map(moment).collect()
}

/// The heading of the nearest moments.
pub(super) fn heading(w: &mut Writer, scene: &Scene, window: &Window) {
    let dt = scene.scenario.dt();
    w.about(Subject::Scene, Some(window.first()))
        .words("\nThe nearest moment of each obstacle from t = ")
        .time(window.first(), dt)
        .words(" s to t = ")
        .about(Subject::Scene, Some(window.last()))
        .time(window.last(), dt)
        .words(" s:\n");
}

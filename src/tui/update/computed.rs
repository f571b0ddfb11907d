//! Requests values of the open scene that the model lacks, and takes them when they arrive.

use super::super::message::{Computed, Effect, Msg};
use super::super::model::Model;
use super::{answers, claims, map, plot, values};

/// Requests what the screen shows and the model lacks.
pub fn request(model: &mut Model) -> Vec<Effect> {
    let mut missing = model.missing_judgements();
    missing.extend(plot::request(model));
    missing.extend(answers::missing_truths(model));
    missing.extend(claims::request(model));
    missing.extend(map::request(model));
    missing.into_iter().map(Effect::Compute).collect()
}

/// Computes at once what these effects request, and what that requests in turn; gives the other effects. For what waits
/// for no keys: pictures of screens, and tests.
pub fn compute_now(model: &mut Model, effects: Vec<Effect>) -> Vec<Effect> {
    let mut others = Vec::new();
    let mut open = effects;
    while let Some(effect) = open.pop() {
        match effect {
            Effect::Compute(computation) => {
                open.extend(super::update(model, Msg::Computed(computation.run())));
            }
            other => others.push(other),
        }
    }
    others.reverse();
    others
}

/// Computes at once what the model lacks, after it was changed outside of `update`.
pub fn compute_missing(model: &mut Model) {
    let missing = request(model);
    compute_now(model, missing);
}

/// Takes a computed value, unless something newer was requested.
pub fn take(model: &mut Model, value: Computed) {
    match value {
        Computed::Measured(id, found) => values::measured(model, id, found),
        Computed::Plotted(id, series) => model.plot.take(id, series),
        Computed::Judged(scene, task, thresholds, found) => {
            answers::judged(model, &scene, task, &thresholds, &found);
        }
        Computed::Paths(request, futures) => map::take_paths(model, &request, futures),
        Computed::MapImage(image) => {
            if let Err(why) = model.map.images.take(image) {
                model.complain(format!("the map is drawn in cells: {why}"));
            }
        }
        Computed::Claims(key, claims) => model.claims.take(key, claims),
    }
}

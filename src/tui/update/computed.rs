//! Requests values of the open scene that the model lacks, and computes them at once where nothing waits for keys.

use super::super::message::Effect;
use super::super::model::Model;
use crate::features::answers::{self, claims};
use crate::features::{map, plot};

/// Requests what the screen shows and the model lacks.
pub fn request(model: &mut Model) -> Vec<Effect> {
    let mut missing: Vec<Effect> = Vec::new();
    missing.extend(model.missing_judgements().into_iter().map(Effect::from));
    missing.extend(plot::request(model).map(Effect::from));
    missing.extend(answers::missing_truths(model).map(Effect::from));
    missing.extend(claims::request(model).into_iter().map(Effect::from));
    missing.extend(map::request(model).into_iter().map(Effect::from));
    missing
}

/// Computes at once what these effects request, and what that requests in turn; gives the other effects. For what waits
/// for no keys: pictures of screens, and tests.
pub fn compute_now(model: &mut Model, effects: Vec<Effect>) -> Vec<Effect> {
    let mut others = Vec::new();
    let mut open = effects;
    while let Some(effect) = open.pop() {
        match effect.at_once() {
            Ok(reply) => open.extend(super::update(model, reply)),
            Err(other) => others.push(other),
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

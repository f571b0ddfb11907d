//! All measures at the current step, and the thresholds they are compared with.

use std::sync::Arc;

use super::super::message::Effect;
use super::super::model::{Model, Values};
use super::super::tasks::scenarios::{Survey, ranking};
use super::super::tasks::thresholds::UseThresholds;
use super::{open_again, planning};
use nearmiss_scene::metrics::Thresholds;

/// Measures everything anew with other thresholds; those that cannot be used change nothing.
pub fn thresholds(model: &mut Model, read: Result<Arc<Thresholds>, String>) -> Vec<Effect> {
    let thresholds = match read {
        Ok(thresholds) => thresholds,
        Err(error) => {
            model.complain(format!("{error}; the thresholds stay as they were"));
            return Vec::new();
        }
    };
    model.tell(match thresholds.file() {
        Some(file) => format!("{} entries of {file}", thresholds.changes().len()),
        None => "there is no thresholds.toml: the shipped thresholds are in use".into(),
    });
    model.thresholds = thresholds.clone();
    model.values = Values::default();
    model.driver.kept.forget();
    model.maker.forget();
    let survey = Survey::All(model.list.entries());
    let mut effects = vec![UseThresholds(thresholds).into(), survey.into()];
    model.list.forget_values();
    effects.extend(ranking(model));
    if let Some(place) = model.list.opened {
        effects.extend(if model.planned().is_some() {
            planning::again(model, place)
        } else {
            open_again(model, place, model.taken)
        });
    }
    effects
}

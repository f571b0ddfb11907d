//! Picks obstacles, and makes one the ego.

use super::super::action::Action;
use super::super::message::Effect;
use super::super::model::Model;
use super::{map, open, open_again, planning};

pub fn pick(model: &mut Model, by: isize) {
    let Some(opened) = &model.opened else { return };
    let order: Vec<i64> = if opened.ranking.is_empty() {
        opened.scenario.obstacles.iter().map(|o| o.id).collect()
    } else {
        opened.ranking.clone()
    };
    if order.is_empty() {
        return model.say("there are no obstacles");
    }
    let now = model
        .picked
        .and_then(|id| order.iter().position(|&o| o == id));
    let by = by.saturating_mul(isize::try_from(model.look.times()).unwrap_or(1));
    let next = match now {
        Some(place) => (place.cast_signed() + by)
            .rem_euclid(order.len().cast_signed())
            .unsigned_abs(),
        None => 0,
    };
    model.picked = Some(order[next]);
    map::picked(model);
    if model.frame.is_of_one_obstacle() {
        model.refresh();
    }
}

pub fn take_as_ego(model: &mut Model) -> Vec<Effect> {
    match model.picked {
        Some(id) => reopen(model, Some(id)),
        None if model.opened.is_none() => {
            model.say("no scenario is open");
            Vec::new()
        }
        None => {
            let key = model.look.key(Action::NextObstacle);
            model.say(format!("pick an obstacle first, with {key} or the mouse"));
            Vec::new()
        }
    }
}

pub fn recorded_ego(model: &mut Model) -> Vec<Effect> {
    if model.taken.is_some() || model.opening.is_some() || model.planned().is_some() {
        planning::take_back(model);
        return reopen(model, None);
    }
    let changed = model.opened.as_ref().is_some_and(|o| o.change.is_some());
    if let Some(place) = model.list.opened.filter(|_| changed) {
        return open(model, place, None);
    }
    model.say("no obstacle is the ego");
    Vec::new()
}

fn reopen(model: &mut Model, ego: Option<i64>) -> Vec<Effect> {
    match model.list.opened {
        Some(place) => open_again(model, place, ego),
        None => Vec::new(),
    }
}

//! The list of jumps: notes the places that jumps leave, and goes back to them.

use super::super::action::Action;
use super::super::message::Effect;
use super::super::model::OpenId;
use super::super::model::{Model, Place};
use super::open;
use crate::features::{map, timeline};

/// A jump is about to leave the present place.
pub fn leave(model: &mut Model) {
    // What is opened while the filter is typed is only passed.
    if model.list.filtering.is_some() {
        return;
    }
    if let Some(place) = here(model) {
        model.jumps.leave(place);
    }
}

/// The present place; none while no scenario is shown.
pub fn here(model: &Model) -> Option<Place> {
    if model.opening.is_some() || model.opened.is_none() {
        return None;
    }
    Some(Place {
        scenario: model.list.opened?,
        taken: model.taken,
        step: model.clock.step(),
        picked: model.picked,
    })
}

/// Goes back to the place before the last jump, or forward again.
pub fn go(model: &mut Model, back: bool) -> Vec<Effect> {
    let mut effects = Vec::new();
    for _ in 0..model.look.times() {
        let now = here(model);
        let Some(place) = model.jumps.turn(back, now) else {
            let key = model.look.key(if back {
                Action::PlaceForward
            } else {
                Action::PlaceBack
            });
            model.say(if back {
                format!("no earlier place; {key} goes forward")
            } else {
                format!("no later place; {key} goes back")
            });
            break;
        };
        effects = reach(model, place);
        if model.opening.is_some() {
            break;
        }
    }
    effects
}

/// Goes to a place, in another scenario as soon as that is open.
pub fn reach(model: &mut Model, place: Place) -> Vec<Effect> {
    let same = model.list.opened == Some(place.scenario) && model.taken == place.taken;
    if same && model.opening.is_none() && model.opened.is_some() {
        arrive(model, &place);
        return Vec::new();
    }
    if place.scenario >= model.list.rows.len() {
        return Vec::new();
    }
    let kept = std::mem::take(&mut model.jumps);
    model.list.show(place.scenario);
    let effects = open(model, place.scenario, place.taken);
    model.jumps = kept;
    model.jumps.arriving = model.opening.map(|(id, _)| (id, place));
    effects
}

/// A scenario was opened: where it is that of a place to go to, the clock and the picked obstacle follow.
pub fn opened(model: &mut Model, id: OpenId) {
    let Some((opening, place)) = model.jumps.arriving.take() else {
        return;
    };
    if opening == id {
        arrive(model, &place);
    }
}

fn arrive(model: &mut Model, place: &Place) {
    model.clock.playing = false;
    let opened = model.opened.as_ref();
    let there = |id: &i64| opened.is_some_and(|o| o.scenario.obstacle(*id).is_some());
    let picked = place.picked.filter(there);
    let picks = model.picked != picked;
    model.picked = picked;
    if picks && picked.is_some() {
        map::picked(model);
    }
    if model.clock.step() != place.step {
        model.clock.go(place.step);
        timeline::stepped(model);
    } else if picks && model.frame.is_of_one_obstacle() {
        model.refresh();
    }
}

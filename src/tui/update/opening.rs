//! Opens a scenario of the list; jumps remember the places they left.

use crate::action::Action;
use crate::features::{map, timeline};
use crate::message::Effect;
use crate::model::{Model, OpenId, Place};
use crate::session::restore;
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::Transform;

/// Opens the selected scenario, if another one is open.
pub fn open_current(model: &mut Model) -> Vec<Effect> {
    match model.list.current() {
        Some(place) if restore::held_back(model, place) => Vec::new(),
        Some(place) if model.list.opened != Some(place) => open(model, place, None),
        _ => Vec::new(),
    }
}

/// Opens a scenario of the list.
pub fn open(model: &mut Model, place: usize, ego: Option<i64>) -> Vec<Effect> {
    open_changed(model, place, ego, None)
}

/// Opens a scenario of the list, after a change of its scene if there is one.
pub fn open_changed(
    model: &mut Model,
    place: usize,
    ego: Option<i64>,
    change: Option<Transform>,
) -> Vec<Effect> {
    if model.list.opened != Some(place) {
        leave_place(model);
    }
    let id = OpenId(model.new_id());
    model.opening = Some((id, ego));
    model.list.opened = Some(place);
    let entry = model.list.rows[place].entry.clone();
    restore::opening(model, &entry);
    let open = Open {
        id,
        entry,
        obstacle: ego,
        change,
    };
    vec![open.into()]
}

/// Opens what is open again, with another ego or other thresholds: a changed scene stays changed.
pub fn open_again(model: &mut Model, place: usize, ego: Option<i64>) -> Vec<Effect> {
    // While something else is being opened, what is open is not what is meant.
    let opened = model.opened.as_ref().filter(|_| model.opening.is_none());
    let change = opened.and_then(|opened| opened.change);
    open_changed(model, place, ego, change)
}

/// Opens a scenario.
#[derive(Debug)]
pub struct Open {
    /// Its number.
    pub id: OpenId,
    /// The scenario.
    pub entry: Entry,
    /// The obstacle that is its ego; `None` for the recorded or chosen one.
    pub obstacle: Option<i64>,
    /// The change of its scene.
    pub change: Option<Transform>,
}

/// A jump is about to leave the present place.
pub fn leave_place(model: &mut Model) {
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

pub fn arrive(model: &mut Model, place: &Place) {
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

//! Opens a scenario of the list.

use super::super::message::Effect;
use super::super::model::{Model, OpenId};
use super::super::session::restore;
use super::jumps;
use super::opened::opened;
use crate::loaded::Opened;
use crate::request::{Replies, Request};
use crate::services::Services;
use nearmiss_formats::{EgoSelection, Entry};
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
        jumps::leave(model);
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

impl Request for Open {
    /// The scenario, or why it is not open.
    type Reply = (OpenId, Result<Box<Opened>, String>);

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let ego = self.obstacle.map(EgoSelection::Obstacle);
        let ego = ego.unwrap_or_else(|| services.ego.clone());
        let thresholds = services.thresholds.clone();
        services.background(replies, move || {
            let opened = Opened::changed(&self.entry, &ego, &thresholds, self.change);
            (self.id, opened.map(Box::new))
        });
    }

    fn reply(model: &mut Model, (id, result): Self::Reply) -> Vec<Effect> {
        model.recall.changed = true;
        opened(model, id, result)
    }
}

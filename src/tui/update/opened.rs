//! A scenario has been opened: what is kept and dropped of the previous one.

use super::super::action::Action;
use super::super::clock::Clock;
use super::super::loaded::Opened;
use super::super::message::Effect;
use super::super::model::{Model, NEIGHBOURHOOD, Notice, OpenId, ShownAnswer, Values};
use super::super::session::restore;
use super::opening::open;
use super::{jumps, reopen};
use crate::features::{answers, generation, planner, timeline};
use nearmiss_base::geometry::Bounds;

pub fn opened(model: &mut Model, id: OpenId, result: Result<Box<Opened>, String>) -> Vec<Effect> {
    let Some((_, ego)) = model.opening.filter(|(opening, _)| *opening == id) else {
        return Vec::new();
    };
    model.opening = None;
    timeline::opened(model, id);
    let opened = match result {
        Ok(opened) => planner::instead(model, id, ego, opened),
        Err(_) if restore::is_wanted(model) && ego.is_some() => {
            // The obstacle that was the ego is no longer in the file.
            let place = model.list.opened;
            return place.map_or_else(Vec::new, |place| open(model, place, None));
        }
        Err(message) if ego.is_some() && model.opened.is_some() => {
            // The open scenario stays open.
            model.complain(message);
            return Vec::new();
        }
        Err(message) => {
            leave(model);
            model.maker.wanted = None;
            model.opened = None;
            model.open_error = Some(message);
            model.refresh();
            return Vec::new();
        }
    };
    let again = model
        .opened
        .as_ref()
        .filter(|o| o.scenario.hash == opened.scenario.hash);
    let step = again.map(|_| model.clock.step());
    let kept = again.map(|before| PreservedView::of(model, before, &opened));
    leave(model);
    model.open_error = None;
    if kept.is_none() {
        model.toasts.retain(|t| t.kind != Notice::Reply);
    }
    let clock = Clock::new(opened.steps(), opened.scenario.dt());
    model.clock = clock.like(&model.clock);
    match step {
        Some(step) => model.clock.go(step),
        None => model.map.second.pinned = None,
    }
    let same_ego = kept.as_ref().is_some_and(|kept| kept.same_ego);
    if !same_ego {
        frame_map(model, &opened);
    }
    let worst = opened.headline.as_ref().and_then(|h| h.worst());
    model.picked = worst.map(|moment| moment.obstacle);
    if let Some(kept) = kept {
        if kept.same_ego {
            model.picked = kept.picked;
        }
        let ego = opened.scene.as_ref().map(|s| s.ego.id);
        model.plot.marked = kept.marked;
        model.plot.marked.retain(|&id| Some(id) != ego);
    }
    model.taken = ego;
    if let (Some(id), false) = (ego, same_ego) {
        let back = model.look.key(Action::RecordedEgo);
        model.say(format!("{id} is the ego now; {back} goes back"));
    }
    model.opened = Some(opened);
    if step.is_none() {
        timeline::to_window(model);
    }
    model.refresh();
    reopen::opened(model, id);
    jumps::opened(model, id);
    restore::opened(model);
    let mut effects: Vec<Effect> = answers::load(model).into_iter().collect();
    effects.extend(generation::opened(model));
    effects
}

/// State kept when the open scenario is opened again.
struct PreservedView {
    /// Whether its ego is the same too, as when thresholds are read again.
    same_ego: bool,
    picked: Option<i64>,
    marked: Vec<i64>,
}

impl PreservedView {
    fn of(model: &Model, before: &Opened, now: &Opened) -> Self {
        let ego = |opened: &Opened| opened.scene.as_ref().map(|s| s.ego.to_string());
        Self {
            same_ego: ego(before) == ego(now),
            picked: model.picked,
            marked: model.plot.marked.clone(),
        }
    }
}

/// Puts away what belongs to the scenario that was open.
fn leave(model: &mut Model) {
    let name = model
        .opened
        .as_ref()
        .map_or(String::new(), |o| o.name.clone());
    answers::leave(model, &name);
    model.answers.reference_ms = None;
    model.answers.show(ShownAnswer::Reference);
    model.taken = None;
    model.picked = None;
    model.plot.marked.clear();
    model.map.tape = None;
    model.values = Values::default();
    model.prompt.scroll = 0;
}

/// Points the map at the ego, or at everything where there is none.
fn frame_map(model: &mut Model, opened: &Opened) {
    if opened.scene.is_some() {
        model.camera.follow = true;
        model.camera.shift = nearmiss_base::geometry::Vector::zeros();
        let (columns, _) = model.drawn.map_size();
        model.camera.show_at_least(NEIGHBOURHOOD, columns);
        return;
    }
    let positions: Vec<_> = opened
        .scenario
        .obstacles
        .iter()
        .flat_map(|o| o.track().iter().map(|(_, m)| m.pose.position))
        .collect();
    let bounds = Bounds::from_points(&positions).or_else(|| opened.scenario.network.bounds());
    if let Some(bounds) = bounds {
        let size = model.drawn.map_size();
        model.camera.fit(&bounds, size);
    }
}

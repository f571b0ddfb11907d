//! Playing, and going to another time step.

use super::super::action::Action;
use super::super::model::Model;
use crate::verdict::Task;

/// Plays, or goes to another step.
pub fn clock(model: &mut Model, action: Action) {
    let before = model.clock.step();
    match action {
        Action::StepForward => model.clock.advance(1),
        Action::StepBack => model.clock.advance(-1),
        Action::JumpForward => model.clock.advance(10),
        Action::JumpBack => model.clock.advance(-10),
        Action::FirstStep => model.clock.go(i64::MIN),
        Action::LastStep => model.clock.go(i64::MAX),
        Action::Play => model.clock.toggle(),
        Action::Faster => model.clock.change_speed(true),
        Action::Slower => model.clock.change_speed(false),
        Action::NearestStep => go_to_nearest(model, |h| h.distance),
        _ => go_to_worst(model),
    }
    if !matches!(action, Action::Play | Action::Faster | Action::Slower) {
        model.clock.playing = false;
    }
    if model.clock.step() != before {
        stepped(model);
    }
}

fn go_to_nearest(
    model: &mut Model,
    which: impl Fn(&crate::metrics::Headline) -> Option<crate::metrics::Nearest>,
) {
    let headline = model.opened.as_ref().and_then(|o| o.headline.as_ref());
    match headline.and_then(which) {
        Some(nearest) => {
            model.clock.go(nearest.step);
            model.picked = Some(nearest.obstacle);
        }
        None if model.scene().is_none() => {
            model.say("this needs an ego: n picks an obstacle, E takes it as the ego")
        }
        None => model.say("there is nobody near at any step"),
    }
}

fn go_to_worst(model: &mut Model) {
    let contact = model
        .opened
        .as_ref()
        .and_then(|o| o.headline.as_ref())
        .is_some_and(|h| h.collides());
    if contact {
        go_to_nearest(model, |h| h.distance);
    } else {
        go_to_nearest(model, |h| h.risk);
    }
}

/// Goes to the end of the usual window of the safety task, unless somebody went to another step.
pub fn to_window(model: &mut Model) {
    let (first, _) = model.clock.range();
    if model.task != Task::Safety || model.clock.step() != first || model.clock.playing {
        return;
    }
    if let Some(last) = model.scene().map(crate::scenario::Scene::last_step) {
        model.clock.go(last - crate::scenario::Window::AFTER_SAFETY);
    }
}

/// The clock moved: what depends on the step is worked out again.
pub fn stepped(model: &mut Model) {
    if model.task == Task::Safety {
        model.refresh();
    }
}

//! Playback and stepping.

use super::super::action::Action;
use super::super::model::Model;
use super::{jumps, timeline};
use nearmiss_scene::verdict::Task;

/// Plays, or goes to another step.
pub fn clock(model: &mut Model, action: Action) {
    let before = model.clock.step();
    let times = model.look.times();
    if leaves(action) {
        jumps::leave(model);
    }
    match action {
        Action::StepForward => model.clock.advance(times),
        Action::StepBack => model.clock.advance(-times),
        Action::JumpForward => model.clock.advance(10 * times),
        Action::JumpBack => model.clock.advance(-10 * times),
        Action::FirstStep => model.clock.go(i64::MIN),
        Action::LastStep => model.clock.go(i64::MAX),
        Action::Play => model.clock.toggle(),
        Action::Faster => model.clock.change_speed(true),
        Action::Slower => model.clock.change_speed(false),
        Action::MinimumStep => timeline::go_to_minimum(model),
        Action::Loop => timeline::turn_round(model),
        Action::ContactStep => go_to_contact(model),
        _ => go_to_worst(model),
    }
    if !matches!(
        action,
        Action::Play | Action::Faster | Action::Slower | Action::Loop
    ) {
        model.clock.playing = false;
    }
    if model.clock.step() != before {
        stepped(model);
    }
}

/// Whether an action jumps away from a place that the list of jumps should have.
fn leaves(action: Action) -> bool {
    use Action::{CollisionStep, ContactStep, FirstStep, LastStep, MinimumStep};
    matches!(
        action,
        CollisionStep | ContactStep | FirstStep | LastStep | MinimumStep
    )
}

fn go_to_contact(model: &mut Model) {
    let headline = model.opened.as_ref().and_then(|o| o.headline.as_ref());
    match headline.map(nearmiss_scene::metrics::Headline::collides) {
        Some(false) => model.say("no contact in this scenario"),
        _ => go_to_worst(model),
    }
}

/// Goes to the moment that matters, picks its obstacle and says why it matters.
fn go_to_worst(model: &mut Model) {
    let headline = model.opened.as_ref().and_then(|o| o.headline.as_ref());
    match headline.and_then(|headline| headline.worst().copied()) {
        Some(moment) => {
            model.clock.go(moment.step);
            model.picked = Some(moment.obstacle);
            model.say(format!("{}: {}", moment.obstacle, moment.hazard));
        }
        None if model.scene().is_none() => {
            let why = model.without_ego();
            model.say(why);
        }
        None => model.say("no obstacle is there with the ego at any step"),
    }
}

/// Moves to the end of the task's default window, unless the user went to another step.
pub fn to_window(model: &mut Model) {
    let (first, _) = model.clock.range();
    let now = model.clock.step();
    let moved = now != first && model.placed != Some(now);
    if moved || model.clock.playing {
        return;
    }
    model.placed = None;
    if model.task.is_about_all_steps() {
        return model.clock.go(first);
    }
    if let Some(last) = model
        .scene()
        .map(nearmiss_scene::scenario::Scene::last_step)
    {
        let back = match model.task {
            Task::Safety => nearmiss_scene::scenario::Window::AFTER_SAFETY,
            _ => 0,
        };
        model.clock.go(last - back);
        model.placed = Some(model.clock.step());
    }
}

/// The clock moved: recomputes what depends on the step.
pub fn stepped(model: &mut Model) {
    model.placed = None;
    // Some tasks are about the whole recording, the others about a window that ends here.
    if !model.task.is_about_all_steps() {
        model.refresh();
    }
}

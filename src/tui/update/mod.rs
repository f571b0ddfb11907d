//! `update`: applies a message to the model and returns effects. No input, no output, no clock.

pub mod actions;
pub mod computed;
pub mod jumps;
pub mod keys;
pub mod look;
pub mod menus;
pub mod opened;
pub mod opening;
pub mod panes;
pub mod pointer;
pub mod reopen;
pub mod screens;
pub mod task;

pub use actions::perform;
pub use computed::{compute_missing, compute_now};
pub use opened::opened;
pub use opening::{Open, open, open_current};
pub use opening::{open_again, open_changed};

use super::features::Screens;
use super::features::answers::Probe;
use super::features::scenarios::request::Find;
use super::features::scenarios::tags::ScenarioTags;
use super::keymap::{Code, Key};
use super::message::{Effect, Msg};
use super::model::Model;
use super::session::restore;

/// Effects at the start of the program.
#[must_use]
pub fn start(model: &mut Model) -> Vec<Effect> {
    let mut effects = vec![
        Find(model.paths.clone()).into(),
        ScenarioTags::Read.into(),
        Probe.into(),
    ];
    effects.extend(super::features::index::start(model));
    super::features::jobs::note_requested(model, &effects);
    effects
}

/// Takes one message.
pub fn update(model: &mut Model, msg: Msg) -> Vec<Effect> {
    restore::note(model, &msg);
    model.settle_camera();
    let mut effects = take(model, msg);
    settle(model);
    effects.extend(request_missing(model));
    super::features::jobs::note_requested(model, &effects);
    effects.extend(restore::remember(model));
    effects
}

/// Makes what is shown true again, whatever the message changed.
fn settle(model: &mut Model) {
    super::features::compare::settle(model);
}

/// Asks for what the model lacks and stops what it needs no longer.
fn request_missing(model: &mut Model) -> Vec<Effect> {
    let mut effects = computed::request(model);
    effects.extend(super::features::planner::request(model));
    effects.extend(super::features::generation::stop_left(model));
    effects.extend(Screens::follow(model));
    effects
}

fn take(model: &mut Model, msg: Msg) -> Vec<Effect> {
    match msg {
        Msg::Key(key) => on_key(model, key),
        Msg::Paste(text) => super::features::prompt::paste(model, &text),
        Msg::Mouse(mouse) => pointer::on_mouse(model, mouse),
        Msg::Resize(columns, rows) => {
            model.size = (columns, rows);
            model.map.second.told = false;
            Vec::new()
        }
        Msg::Passed(elapsed) => passed(model, elapsed),
        Msg::Drawing => super::features::scenarios::drawing(model),
        Msg::Drawn => {
            super::features::map::drawn(model);
            super::features::map::image(model)
                .into_iter()
                .map(Effect::from)
                .collect()
        }
        Msg::Reply(reply) => reply.apply(model),
        Msg::Reloaded(what) => {
            look::reloaded(model, what);
            Vec::new()
        }
        Msg::EditedOutside(sent, result) => match sent.place {
            Some(file) => super::features::experiment::edited(model, &file, result),
            None => {
                super::features::prompt::edited_outside(model, sent, result);
                Vec::new()
            }
        },
        Msg::Complaint(text) => {
            model.complain(text);
            Vec::new()
        }
        Msg::Terminate => actions::quit(model),
        Msg::Stop => vec![Effect::Suspend],
    }
}

fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    // Errors stay until the user could read them, replies until the next question.
    model.read_notices();
    if key
        == (Key {
            ctrl: true,
            ..Key::plain(Code::Char('c'))
        })
    {
        if keys::give_up(model) {
            return Vec::new();
        }
        return actions::interrupt(model);
    }
    let (begun, stopping) = (model.quit_within, model.stop_within);
    let effects = other_key(model, key);
    model.look.repeat = None;
    // Any other key cancels a pending quit.
    if model.quit_within == begun {
        model.quit_within = 0.0;
    }
    if model.stop_within == stopping {
        model.stop_within = 0.0;
    }
    effects
}

fn other_key(model: &mut Model, key: Key) -> Vec<Effect> {
    if !model.screens.is_empty() {
        return screens::on_key(model, key);
    }
    if model.compare.open {
        return super::features::compare::on_key(model, key);
    }
    if model.prompt.editing {
        return super::features::prompt::on_key(model, key);
    }
    if model.list.filtering.is_some() {
        return super::features::scenarios::on_key(model, key);
    }
    keys::on_key(model, key)
}

fn passed(model: &mut Model, elapsed: std::time::Duration) -> Vec<Effect> {
    let seconds = elapsed.as_secs_f64();
    model.quit_within = (model.quit_within - seconds).max(0.0);
    model.stop_within = (model.stop_within - seconds).max(0.0);
    for toast in &mut model.toasts {
        toast.left -= seconds;
        toast.shown += seconds;
    }
    model.toasts.retain(|t| t.left > 0.0);
    super::features::answers::pass(model, seconds);
    if model.clock.pass(elapsed) {
        super::features::timeline::stepped(model);
    }
    let mut effects = super::features::planner::pass(model, seconds);
    effects.extend(super::features::prompt::pass(model, seconds));
    effects.extend(super::features::scenarios::pass(model, seconds));
    effects
}

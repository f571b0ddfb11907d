//! `update`: applies a message to the model and returns effects. No input, no output, no clock.

pub mod actions;
pub mod keys;
pub mod opened;
pub mod opening;
pub mod pointer;

use crate::features::answers::{self, Probe, claims};
use crate::features::scenarios::request::Find;
use crate::features::scenarios::tags::ScenarioTags;
use crate::features::{self, Screens, map, plot};
use crate::keymap::{Code, Key};
use crate::message::{Effect, Msg, Reloaded};
use crate::model::{Glyphs, Model, Notice, Toast};
use crate::session::restore;
use nearmiss_scene::verdict::Task;
use nearmiss_settings::Config;
use nearmiss_study::evaluation::default_frame;

pub use actions::perform;
pub use opened::opened;
pub use opening::{Open, open, open_again, open_current};

/// Effects at the start of the program.
#[must_use]
pub fn start(model: &mut Model) -> Vec<Effect> {
    let mut effects = vec![
        Find(model.paths.clone()).into(),
        ScenarioTags::Read.into(),
        Probe.into(),
    ];
    effects.extend(features::index::start(model));
    features::jobs::note_requested(model, &effects);
    effects
}

/// Takes one message.
pub fn update(model: &mut Model, msg: Msg) -> Vec<Effect> {
    restore::note(model, &msg);
    if matches!(msg, Msg::Key(_) | Msg::Mouse(_) | Msg::Paste(_)) {
        model.list.leads = false;
    }
    model.settle_camera();
    let effects = take(model, msg);
    let mut effects = perform_steps(model, effects);
    settle(model);
    effects.extend(request_missing(model));
    features::jobs::note_requested(model, &effects);
    effects.extend(restore::remember(model));
    effects
}

/// Does what the workbench itself is to do, and what follows of that.
fn perform_steps(model: &mut Model, effects: Vec<Effect>) -> Vec<Effect> {
    if !effects.iter().any(|e| matches!(e, Effect::Step(_))) {
        return effects;
    }
    let mut done = Vec::new();
    for effect in effects {
        match effect {
            Effect::Step(step) => {
                let effects = keys::take(model, None, step);
                done.extend(perform_steps(model, effects));
            }
            effect => done.push(effect),
        }
    }
    done
}

/// Makes what is shown true again, whatever the message changed.
fn settle(model: &mut Model) {
    features::compare::settle(model);
}

/// Asks for what the model lacks and stops what it needs no longer.
fn request_missing(model: &mut Model) -> Vec<Effect> {
    let mut effects = request(model);
    effects.extend(features::planner::request(model));
    effects.extend(features::generation::stop_left(model));
    effects.extend(Screens::follow(model));
    effects
}

fn take(model: &mut Model, msg: Msg) -> Vec<Effect> {
    match msg {
        Msg::Key(key) => on_key(model, key),
        Msg::Paste(text) if model.screens.is_empty() => features::prompt::paste(model, &text),
        Msg::Paste(text) => keys::paste(model, &text),
        Msg::Mouse(mouse) => pointer::on_mouse(model, mouse),
        Msg::Resize(columns, rows) => {
            model.size = (columns, rows);
            model.map.second.warned = false;
            Vec::new()
        }
        Msg::Passed(elapsed) => passed(model, elapsed),
        Msg::Drawing => features::scenarios::drawing(model),
        Msg::Drawn => {
            features::map::drawn(model);
            features::map::image(model)
                .into_iter()
                .map(Effect::from)
                .collect()
        }
        Msg::Reply(reply) => reply.apply(model),
        Msg::Reloaded(what) => {
            reloaded(model, what);
            Vec::new()
        }
        Msg::EditedOutside(sent, result) => match sent.place {
            Some(file) => features::experiment::edited(model, &file, result),
            None => {
                features::prompt::edited_outside(model, sent, result);
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
        if keys::cancel_chord(model) {
            return Vec::new();
        }
        return actions::interrupt(model);
    }
    let (begun, stopping) = (model.quit_within, model.stop_within);
    let windows = |model: &Model| model.screens.iter().count() + usize::from(model.compare.open);
    let open = windows(model);
    let effects = other_key(model, key);
    if windows(model) > open {
        // What was said before may recommend the very window, and its keys need the line.
        let stays = |toast: &Toast| toast.kind == Notice::Error || toast.shown <= 0.0;
        model.toasts.retain(stays);
    }
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
        return keys::on_screen_key(model, key);
    }
    if model.compare.open {
        if model.compare.marking.is_none()
            && let Some(effects) = keys::on_menu_key(model, key)
        {
            return effects;
        }
        return features::compare::on_key(model, key);
    }
    if model.prompt.editing {
        if model.prompt.entry.is_none()
            && let Some(effects) = keys::on_menu_key(model, key)
        {
            return effects;
        }
        return features::prompt::on_key(model, key);
    }
    if model.list.filtering.is_some() {
        return features::scenarios::on_key(model, key);
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
    features::answers::pass(model, seconds);
    if model.clock.pass(elapsed) {
        features::timeline::stepped(model);
    }
    let mut effects = features::planner::pass(model, seconds);
    effects.extend(features::prompt::pass(model, seconds));
    effects.extend(features::scenarios::pass(model, seconds));
    effects
}

/// Requests what the screen shows and the model lacks.
pub fn request(model: &mut Model) -> Vec<Effect> {
    let mut missing: Vec<Effect> = Vec::new();
    missing.extend(model.missing_judgements().into_iter().map(Effect::from));
    missing.extend(plot::request(model).map(Effect::from));
    missing.extend(answers::missing_truths(model).map(Effect::from));
    missing.extend(claims::request(model).into_iter().map(Effect::from));
    missing.extend(map::request(model).into_iter().map(Effect::from));
    missing.extend(features::drivers::request(model));
    missing
}

/// Computes at once what these effects request, and what that requests in turn; gives the other effects. For what waits
/// for no keys: pictures of screens, and tests.
pub fn compute_now(model: &mut Model, effects: Vec<Effect>) -> Vec<Effect> {
    let mut others = Vec::new();
    let mut open = effects;
    while let Some(effect) = open.pop() {
        match effect.at_once() {
            Ok(reply) => open.extend(update(model, reply)),
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

/// The next task that has a template, in the frame that was chosen if it has one for that, else in its usual one.
pub fn next(model: &mut Model) {
    let all = Task::ALL;
    let now = all.iter().position(|t| *t == model.task).unwrap_or(0);
    let after = (1..all.len()).map(|n| all[(now + n) % all.len()]);
    for task in after {
        let has = |frame: &nearmiss_scene::description::Frame| {
            let found = model.library.find(task.name(), frame.name());
            found.is_some()
        };
        let chosen = model.frame_chosen.filter(has);
        let frame = chosen.unwrap_or_else(|| default_frame(&model.library, task));
        if has(&frame) {
            model.task = task;
            model.frame = frame;
            return;
        }
    }
}

/// A file was changed.
pub fn reloaded(model: &mut Model, what: Reloaded) {
    match what {
        Reloaded::Config(Ok(config)) => configured(model, &config),
        Reloaded::Config(Err(error)) => {
            model.complain(format!("{error}; what was set stays"));
        }
        Reloaded::Keymap(Ok(keymap)) => {
            if model.look.keymap != keymap {
                let notes = keymap.notes.clone();
                model.look.keymap = keymap;
                model.look.pending.clear();
                model.look.count = None;
                model.say("the keys of keymap.toml are in use");
                notes.into_iter().for_each(|note| model.tell(note));
            }
        }
        Reloaded::Keymap(Err(error)) => {
            model.complain(format!("{error}; the keys stay as they were"));
        }
        Reloaded::Themes(themes) => {
            model.look.themes = themes;
            if let Err(why) = model.show_theme(&model.look.chosen.clone()) {
                model.complain(format!("{why}; the colours stay as they were"));
            }
        }
    }
}

/// The configuration is read again for the look alone; the rest holds from the next start on.
fn configured(model: &mut Model, config: &Config) {
    model.look.configure_map(config);
    model.look.glyphs = Glyphs::of_config(config.glyphs.as_deref(), model.look.glyphs_here);
    let name = config.theme.clone().unwrap_or_else(|| "auto".into());
    if model.config.theme != config.theme {
        model.config.theme.clone_from(&config.theme);
        match model.look.theme(&name) {
            Ok(theme) => {
                model.look.chosen = name;
                model.theme = theme;
            }
            Err(why) => model.complain(format!("{why}; the colours stay as they were")),
        }
    }
    model.config.glyphs.clone_from(&config.glyphs);
    model.config.map.clone_from(&config.map);
    model.config.map_blocks.clone_from(&config.map_blocks);
    if model.config != *config {
        model.say(
            "config.toml was changed: theme, glyphs and map apply now, the rest at the next start",
        );
    }
}

//! `update`: applies a message to the model and returns effects. No input, no output, no clock.

mod actions;
mod answers;
mod batch;
mod claims;
pub mod clock;
mod compare;
mod computed;
mod editing;
mod experiment;
mod filter;
mod index;
mod jobs;
mod jumps;
mod keys;
mod list;
mod look;
mod making;
mod map;
mod menus;
mod obstacles;
mod opened;
mod opening;
mod panes;
mod picture;
mod planning;
mod plot;
mod pointer;
mod rating;
mod reopen;
mod screens;
mod second;
mod stored_answers;
mod task;
mod timeline;
mod values;
mod views;

pub use actions::perform;
pub use computed::{compute_missing, compute_now};
use opened::opened;
pub use opening::{open, open_current};
use opening::{open_again, open_changed};

use super::keymap::{Code, Key};
use super::message::{Effect, Msg};
use super::model::Model;
use super::screens::{Screens, history, results, source};
use super::session::restore;

/// Effects at the start of the program.
#[must_use]
pub fn start(model: &mut Model) -> Vec<Effect> {
    let mut effects = vec![
        Effect::Find(model.paths.clone()),
        Effect::ReadTags,
        Effect::Probe,
    ];
    effects.extend(index::start(model));
    jobs::note_requested(model, &effects);
    effects
}

/// Takes one message.
pub fn update(model: &mut Model, msg: Msg) -> Vec<Effect> {
    note(model, &msg);
    model.settle_camera();
    let mut effects = take(model, msg);
    settle(model);
    effects.extend(request_missing(model));
    jobs::note_requested(model, &effects);
    effects.extend(restore::remember(model));
    effects
}

/// Writes down what a message tells of tasks and of the session, before it changes anything.
fn note(model: &mut Model, msg: &Msg) {
    jobs::note(model, msg);
    restore::note(model, msg);
}

/// Makes what is shown true again, whatever the message changed.
fn settle(model: &mut Model) {
    compare::settle(model);
}

/// Asks for what the model lacks and stops what it needs no longer.
fn request_missing(model: &mut Model) -> Vec<Effect> {
    let mut effects = computed::request(model);
    effects.extend(planning::request(model));
    effects.extend(making::stop_left(model));
    effects.extend(Screens::follow(model));
    effects
}

fn take(model: &mut Model, msg: Msg) -> Vec<Effect> {
    match msg {
        Msg::Key(key) => on_key(model, key),
        Msg::Paste(text) => editing::paste(model, &text),
        Msg::Mouse(mouse) => pointer::on_mouse(model, mouse),
        Msg::Resize(columns, rows) => {
            model.size = (columns, rows);
            model.map.second.told = false;
            Vec::new()
        }
        Msg::Passed(elapsed) => passed(model, elapsed),
        Msg::Found(found) => list::found(model, found),
        Msg::Listed(entries) => list::listed(model, entries),
        Msg::Searched(ended) => list::searched(model, ended),
        Msg::Tags(tags) => {
            list::tags(model, tags);
            Vec::new()
        }
        Msg::Views(views) => {
            views::read(model, views);
            Vec::new()
        }
        Msg::Drawing => list::drawing(model),
        Msg::Drawn => {
            second::drawn(model);
            map::image(model).map(Effect::Compute).into_iter().collect()
        }
        Msg::Discovered(found) => {
            answers::offer(model, found);
            Vec::new()
        }
        Msg::Surveyed(place, facts) => {
            model.list.survey(place, facts);
            Vec::new()
        }
        Msg::Ranked(measure, place, value) => {
            model.list.rank(measure, place, value);
            Vec::new()
        }
        Msg::Opened(id, result) => opened(model, id, result),
        Msg::Computed(value) => {
            computed::take(model, value);
            Vec::new()
        }
        Msg::Thresholds(read) => values::thresholds(model, read),
        Msg::Stored(of, stored) => {
            if stored_answers::subject(model).as_ref() == Some(&of) {
                let reopened = reopen::before_stored(model);
                stored_answers::show(model, stored);
                if let Some(column) = reopened {
                    reopen::after_stored(model, column);
                }
                timeline::arrived(model);
                compare::arrived(model);
            }
            Vec::new()
        }
        Msg::History(event) => {
            let step = history::on_event(model, event);
            screens::take(model, None, step)
        }
        Msg::Results(event) => {
            let step = results::on_event(model, event);
            screens::take(model, None, step)
        }
        Msg::Job(id, event) => jobs::on_event(model, id, event),
        Msg::DriveSaved(key, result) => {
            planning::saved(model, key, result);
            Vec::new()
        }
        Msg::VariantSaved(made, result) => {
            making::saved(model, &made, result);
            Vec::new()
        }
        Msg::Rated(round, result) => rating::kept(model, round, result),
        Msg::Ratings(result) => {
            rating::read(model, result);
            Vec::new()
        }
        Msg::Unrated(result) => rating::unrated(model, result),
        Msg::Saved(file, result) => editing::saved(model, &file, result),
        Msg::Reread(library) => {
            editing::reread(model, library);
            Vec::new()
        }
        Msg::Reloaded(what) => {
            look::reloaded(model, what);
            Vec::new()
        }
        Msg::EditedOutside(sent, result) => match sent.place {
            Some(file) => experiment::edited(model, &file, result),
            None => {
                editing::edited_outside(model, sent, result);
                Vec::new()
            }
        },
        Msg::ExperimentFiles(folder, found) => {
            experiment::listed(model, folder, found);
            Vec::new()
        }
        Msg::Source(place, read) => {
            source::read(model, place, read);
            Vec::new()
        }
        Msg::Pictured(saved) => {
            picture::saved(model, saved);
            Vec::new()
        }
        Msg::KeepSession => restore::keep(model),
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
        return compare::on_key(model, key);
    }
    if model.prompt.editing {
        return editing::on_key(model, key);
    }
    if model.list.filtering.is_some() {
        return filter::on_key(model, key);
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
    answers::pass(model, seconds);
    if model.clock.pass(elapsed) {
        clock::stepped(model);
    }
    let mut effects = planning::pass(model, seconds);
    effects.extend(editing::pass(model, seconds));
    effects.extend(filter::pass(model, seconds));
    effects
}

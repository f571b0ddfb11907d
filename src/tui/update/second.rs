//! The second map: shown or not, its moment pinned, free and moved.

use ratatui::layout::Margin;

use super::super::action::Action;
use super::super::model::{Halves, Model, Pane};

/// How much farther away the map is seen while there are two, so that both show as much as the one before.
const FARTHER: f64 = 2.0;

/// Does what an action about the second map says.
pub fn perform(model: &mut Model, action: Action) {
    if model.opened.is_none() {
        return model.say("no scenario is open");
    }
    match action {
        Action::SplitMap => split(model),
        Action::CertificateMap => certificate(model),
        Action::PinMoment => pin(model),
        Action::MomentBack => step(model, -model.look.times()),
        _ => step(model, model.look.times()),
    }
}

/// Shows the good driver beside the variant, or its original again.
fn certificate(model: &mut Model) {
    let has = model
        .opened
        .as_deref()
        .is_some_and(|opened| opened.certificate.is_some());
    if !has {
        let shows = model.variant().is_some_and(|shown| shown.changed);
        let saved = model
            .opened
            .as_deref()
            .is_some_and(|opened| opened.saved.is_some());
        return model.say(if shows || saved {
            "no good driver survives this variant, so there is no certificate".into()
        } else {
            let key = model.look.key(Action::Generate);
            format!("only a variant has a certificate; {key} makes the scenario dangerous")
        });
    }
    let shown = model.map.second.on && model.map.second.certificate;
    model.map.second.certificate = !shown;
    if !model.map.second.on {
        turn(model);
    }
    let words = moment_words(model);
    let key = model.look.key(Action::CertificateMap);
    model.say(if shown {
        format!("second map: {words}")
    } else {
        format!("second map: {words}; {key} shows the original again")
    });
}

fn split(model: &mut Model) {
    turn(model);
    model.map.second.certificate = false;
    if !model.map.second.on {
        return model.say("one map");
    }
    let opened = model.opened.as_deref();
    let saved = opened.and_then(|opened| opened.saved.as_deref());
    if let Some(Err(why)) = saved.map(|saved| &saved.original) {
        let why = why.clone();
        return model.say(why);
    }
    let keys = [Action::MomentBack, Action::MomentForward];
    let [back, forward] = keys.map(|action| model.look.key(action));
    let pin = model.look.key(Action::PinMoment);
    let words = moment_words(model);
    model.say(format!(
        "second map: {words}; {back} {forward} move it, {pin} pins it to this step"
    ));
}

/// Splits the map, or makes it whole again.
fn turn(model: &mut Model) {
    let fits = fits(model);
    let second = &mut model.map.second;
    second.on = !second.on;
    second.told = false;
    // Where maps choose their zoom, each does so for itself.
    let widens = second.on && fits && !model.camera.auto;
    if std::mem::replace(&mut second.widened, widens) && !model.camera.auto {
        model.camera.scale(1.0 / FARTHER);
    }
    if widens {
        model.camera.scale(FARTHER);
    }
    if model.drawn.area(Pane::Map).is_none() {
        model.focus = Pane::Map;
    }
}

/// Whether the map has room for two, as it was drawn last.
fn fits(model: &Model) -> bool {
    let fits = |area: ratatui::layout::Rect| {
        Halves::of(area.inner(Margin::new(1, 1)), model.camera.aspect).is_some()
    };
    model.drawn.area(Pane::Map).is_none_or(fits)
}

/// The present step is pinned; where it is already, the second map goes back to the moment that follows from the scene.
fn pin(model: &mut Model) {
    let step = model.clock.step();
    if !model.map.second.on {
        turn(model);
    } else if model.map.second.pinned == Some(step) {
        model.map.second.pinned = None;
        let words = moment_words(model);
        return model.say(format!("second map: {words}"));
    }
    model.map.second.pinned = Some(step);
    let words = moment_words(model);
    let key = model.look.key(Action::PinMoment);
    model.say(format!("second map: {words}; {key} again frees it"));
}

fn step(model: &mut Model, by: i64) {
    let at = model
        .second_moment()
        .map(|then| (then.step, then.opened.steps()));
    let Some((step, steps)) = at else {
        let key = model.look.key(Action::SplitMap);
        return model.say(format!("{key} shows a second map first"));
    };
    let moved = step.saturating_add(by).min(steps.end - 1).max(steps.start);
    model.map.second.pinned = Some(moved);
}

fn moment_words(model: &Model) -> String {
    model
        .second_moment()
        .map_or(String::new(), |then| then.words())
}

/// A frame was drawn: where it had no room for the second map, that is said once.
pub fn drawn(model: &mut Model) {
    if !model.drawn.is_cramped() || std::mem::replace(&mut model.map.second.told, true) {
        return;
    }
    let words = if model.zoomed && model.focus == Pane::Map {
        "the terminal is too small for two maps".into()
    } else {
        let key = model.look.key(Action::Zoom);
        format!("the pane is too small for two maps; {key} on the map gives it the whole screen")
    };
    model.say(words);
}

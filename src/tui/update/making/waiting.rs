//! Keys pressed while something is made, or before the scenario is read.

use super::generate;
use crate::action::Action;
use crate::message::Effect;
use crate::model::{Model, working_words};

/// Whether something is made already; then it is said, with how to stop it.
pub fn still_searching(model: &mut Model) -> bool {
    let Some(search) = &model.maker.under_way else {
        return false;
    };
    let words = working_words(search.at, true);
    let key = model.look.key(Action::Cancel);
    model.say(format!("{words}; {key} {key} cancels"));
    true
}

/// Whether Esc is to be pressed again before what is made ends, as minutes of work end with it; then that is said.
pub fn asks_again(model: &mut Model) -> bool {
    let Some(search) = &model.maker.under_way else {
        return false;
    };
    if model.stop_within > 0.0 {
        return false;
    }
    let words = working_words(search.at, true);
    let key = model.look.key(Action::Cancel);
    model.say(format!("{words}; {key} again cancels"));
    model.stop_within = AGAIN;
    true
}

/// Seconds within which Esc has to be pressed again.
const AGAIN: f64 = 4.0;

/// A scenario was opened: the search starts that was asked for meanwhile.
pub fn opened(model: &mut Model) -> Vec<Effect> {
    match model.maker.wanted.take() {
        Some(place) if model.list.opened == Some(place) => generate(model, None),
        _ => Vec::new(),
    }
}

//! The views: one pane a file. They read the model and draw; they change nothing.

mod compare;
mod filter_terms;
mod footer;
mod header;
mod hint;
mod map;
mod plot;
mod prompt;
mod reasoning;
mod scenarios;
mod timeline;
mod toasts;
mod too_small;
mod verdict;
mod which_key;

use ratatui::Frame;
use ratatui::layout::Rect;

use super::layout;
use super::model::{Glyphs, Model, Pane};
use super::widgets::ascii;

/// Draws everything, in the signs that the terminal has.
pub fn draw(frame: &mut Frame<'_>, model: &Model) {
    everything(frame, model);
    model.theme.paint(frame.buffer_mut());
    if model.look.glyphs == Glyphs::Ascii {
        ascii::only(frame.buffer_mut());
    }
}

fn everything(frame: &mut Frame<'_>, model: &Model) {
    model.drawn.clear();
    let screen = frame.area();
    let Some(mut parts) = layout::split(screen, model) else {
        too_small::draw(frame, model);
        return;
    };
    if model.compare.open {
        compare::draw(frame, &parts, model);
        footer::draw(frame, parts.footer, model);
        screens(frame, screen, model);
        toasts::draw(frame, &parts, model);
        return;
    }
    model.drawn.set_borders(&parts.borders);
    let hint = hint::make_room(&mut parts, model);
    header::draw(frame, parts.header, model);
    for &(pane, area) in &parts.panes {
        match pane {
            Pane::Scenarios => scenarios::draw(frame, area, model),
            Pane::Map => map::draw(frame, area, model),
            Pane::Timeline => timeline::draw(frame, area, model),
            Pane::Prompt => prompt::draw(frame, area, model),
            Pane::Verdict => verdict::draw(frame, area, model),
            Pane::Reasoning => reasoning::draw(frame, area, model),
            Pane::Plot => plot::draw(frame, area, model),
        }
    }
    hint::draw(frame, &parts, hint, model);
    filter_terms::draw(frame, screen, model);
    footer::draw(frame, parts.footer, model);
    screens(frame, screen, model);
    toasts::draw(frame, &parts, model);
}

/// Draws the screens that are open, the top last, and what can follow a prefix.
fn screens(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    for screen in model.screens.iter() {
        screen.draw(frame, area, model);
    }
    which_key::draw(frame, area, model);
}

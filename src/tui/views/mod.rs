//! The views: one pane a file. They read the model and draw; they change nothing.

mod compare;
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

use ratatui::Frame;

use super::layout;
use super::model::{Glyphs, Model, Pane};
use super::overlays;
use super::widgets::ascii;

/// Draws everything, in the signs that the terminal has.
pub fn draw(frame: &mut Frame<'_>, model: &Model) {
    everything(frame, model);
    if model.look.glyphs == Glyphs::Ascii {
        ascii::only(frame.buffer_mut());
    }
}

fn everything(frame: &mut Frame<'_>, model: &Model) {
    model.drawn.clear();
    let screen = frame.area();
    let Some(parts) = layout::split(screen, model) else {
        too_small::draw(frame, model);
        return;
    };
    if model.compare.open {
        compare::draw(frame, &parts, model);
        footer::draw(frame, parts.footer, model);
        overlays::draw(frame, screen, model);
        toasts::draw(frame, &parts, model);
        return;
    }
    model.drawn.set_borders(&parts.borders);
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
    hint::draw(frame, &parts, model);
    footer::draw(frame, parts.footer, model);
    overlays::draw(frame, screen, model);
    toasts::draw(frame, &parts, model);
}

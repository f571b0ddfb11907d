//! The views: one pane a file. They read the model and draw; they change nothing.

mod footer;
mod header;
mod hint;
mod toasts;
mod too_small;
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
        super::features::compare::draw::draw(frame, &parts, model);
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
            Pane::Scenarios => super::features::scenarios::draw::draw(frame, area, model),
            Pane::Map => super::features::map::draw::draw(frame, area, model),
            Pane::Timeline => super::features::timeline::draw::draw(frame, area, model),
            Pane::Prompt => super::features::prompt::draw::draw(frame, area, model),
            Pane::Verdict => super::features::answers::verdict::draw(frame, area, model),
            Pane::Reasoning => super::features::answers::reasoning::draw(frame, area, model),
            Pane::Plot => super::features::plot::draw::draw(frame, area, model),
        }
    }
    hint::draw(frame, &parts, hint, model);
    super::features::scenarios::draw::draw_filter_terms(frame, screen, model);
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

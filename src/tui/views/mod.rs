//! The views: one pane a file. They read the model and draw; they change nothing.

pub mod footer;
pub mod header;
pub mod toasts;

use ratatui::Frame;
use ratatui::layout::{Alignment, Constraint, Flex, Layout, Rect};
use ratatui::text::{Line, Text};
use ratatui::widgets::{Paragraph, Wrap};

use crate::action::Action;
use crate::layout::{self, SMALLEST};
use crate::model::{Glyphs, Model, Pane};
use crate::widgets::{unbroken, words};

/// Draws everything, in the signs that the terminal has.
pub fn draw(frame: &mut Frame<'_>, model: &Model) {
    let screen = super::features::tour::draw(frame, frame.area(), model);
    everything(frame, screen, model);
    unbroken::plain_blanks(frame.buffer_mut());
    model.theme.paint(frame.buffer_mut());
    if model.look.glyphs == Glyphs::Ascii {
        words::only(frame.buffer_mut());
    }
}

fn everything(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
    model.drawn.clear();
    let Some(mut parts) = layout::split(screen, model) else {
        draw_too_small(frame, screen, model);
        return;
    };
    let screen = toasts::make_room_below(&mut parts, screen, model);
    if model.compare.open {
        super::features::compare::draw::draw(frame, &parts, model);
        footer::draw(frame, parts.footer, model);
        screens(frame, screen, model);
        toasts::draw(frame, &parts, model);
        return;
    }
    model.drawn.set_borders(&parts.borders);
    let hint = toasts::make_room(&mut parts, model);
    let map = parts.panes.iter().find(|(pane, _)| *pane == Pane::Map);
    let map = map.map(|(_, area)| super::features::map::draw::begin(frame, *area, model));
    header::draw(frame, parts.header, model);
    for &(pane, area) in &parts.panes {
        match pane {
            Pane::Scenarios => super::features::scenarios::draw::draw(frame, area, model),
            Pane::Map => {}
            Pane::Timeline => super::features::timeline::draw::draw(frame, area, model),
            Pane::Prompt => super::features::prompt::draw::draw(frame, area, model),
            Pane::Verdict => super::features::answers::verdict::draw(frame, area, model),
            Pane::Reasoning => super::features::answers::reasoning::draw(frame, area, model),
            Pane::Plot => super::features::plot::draw::draw(frame, area, model),
        }
    }
    if let Some(map) = map {
        map.end(frame, model);
    }
    toasts::draw_hint(frame, &parts, hint, model);
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
    toasts::draw_keys(frame, area, model);
}

fn draw_too_small(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let (columns, rows) = SMALLEST;
    let text = Text::from(vec![
        Line::from(format!(
            "Terminal too small: this is {}×{}, nearmiss needs {columns}×{rows}",
            area.width, area.height
        )),
        Line::from(format!("{} quits", model.look.key(Action::Quit))),
    ]);
    let [middle] = Layout::vertical([Constraint::Length(4)])
        .flex(Flex::Center)
        .areas(area);
    let words = Paragraph::new(text)
        .alignment(Alignment::Center)
        .wrap(Wrap { trim: true });
    frame.render_widget(words.style(model.theme.base()), middle);
}

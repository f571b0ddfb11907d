//! What lies over the main screen: help, what is in the scenario, values, palette, lists of models and themes, the keys after a prefix.

mod about;
mod batch;
mod cycle;
mod details;
mod help;
mod history;
mod jobs;
mod layers;
mod picker;
mod results;
mod run;
mod source;
mod tags;
mod thresholds;
mod values;
mod variant;
mod which_key;

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::Text;
use ratatui::widgets::{Block, BorderType, Clear, Paragraph, Wrap};

use super::model::{Model, Overlay};

/// Draws what is open, the top last.
pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
    for overlay in &model.overlays {
        match overlay {
            Overlay::Help { scroll, text } => help::draw(frame, screen, model, *scroll, text),
            Overlay::About { scroll } => about::draw(frame, screen, model, *scroll),
            Overlay::Values { scroll } => values::draw(frame, screen, model, *scroll),
            Overlay::History => history::draw(frame, screen, model),
            Overlay::Jobs => jobs::draw(frame, screen, model),
            Overlay::Results => results::draw(frame, screen, model),
            Overlay::Batch => batch::draw(frame, screen, model),
            Overlay::Themes(typed) => picker::themes(frame, screen, model, typed),
            Overlay::Details(scroll) => details::draw(frame, screen, model, *scroll),
            Overlay::Cycle(scroll) => cycle::draw(frame, screen, model, *scroll),
            Overlay::Variant(scroll) => variant::draw(frame, screen, model, *scroll),
            Overlay::Layers(selected) => layers::draw(frame, screen, model, *selected),
            Overlay::Source { scroll } => source::draw(frame, screen, model, *scroll),
            Overlay::Templates { picker: typed } => picker::templates(frame, screen, model, typed),
            Overlay::Palette(typed) => picker::palette(frame, screen, model, typed),
            Overlay::Tags {
                picker: typed,
                scenario,
            } => tags::draw(frame, screen, model, (typed, scenario)),
            Overlay::Models { picker: typed, ask } => {
                picker::models(frame, screen, model, typed, *ask);
            }
            Overlay::Pictures(typed) => picker::pictures(frame, screen, model, typed),
            Overlay::Measures {
                picker: typed,
                sort,
            } => picker::measures(frame, screen, model, typed, *sort),
        }
    }
    which_key::draw(frame, screen, model);
}

/// Columns of the window at the right beside which the rest stays in sight, if one is on top.
#[must_use]
pub fn beside(screen: Rect, model: &Model) -> Option<u16> {
    match model.overlays.last()? {
        Overlay::Cycle(_) | Overlay::Variant(_) => Some(cycle::width(screen)),
        Overlay::Details(_) => Some(details::width(screen)),
        _ => None,
    }
}

/// Columns of a window at most, its borders included.
const COLUMNS: u16 = 92;

/// Columns of text in a window of text.
fn text_width(screen: Rect) -> usize {
    width_in(screen, COLUMNS)
}

/// Columns of text in a window of so many columns, its borders included.
fn width_in(screen: Rect, columns: u16) -> usize {
    usize::from(
        columns
            .min(screen.width.saturating_sub(4))
            .saturating_sub(2),
    )
}

/// A window of text, no further scrolled than to its end.
fn scrolled(
    frame: &mut Frame<'_>,
    screen: Rect,
    model: &Model,
    what: &str,
    text: Text<'static>,
    scroll: usize,
) {
    let title = format!("{what} · ↑↓ scroll · any other key closes");
    scrolled_in(frame, screen, model, &title, text, (COLUMNS, scroll));
}

/// The same, with a title and a width of its own.
fn scrolled_in(
    frame: &mut Frame<'_>,
    screen: Rect,
    model: &Model,
    title: &str,
    text: Text<'static>,
    (columns, scroll): (u16, usize),
) {
    let inner = window(frame, screen, model, title, (columns, 60));
    text_in(frame, inner, text, scroll);
}

/// Text in a window, no further scrolled than to its end.
fn text_in(frame: &mut Frame<'_>, inner: Rect, text: Text<'static>, scroll: usize) {
    let paragraph = Paragraph::new(text).wrap(Wrap { trim: false });
    let last = paragraph
        .line_count(inner.width)
        .saturating_sub(usize::from(inner.height));
    let scroll = u16::try_from(scroll.min(last)).unwrap_or(u16::MAX);
    frame.render_widget(paragraph.scroll((scroll, 0)), inner);
}

/// A window in the middle; gives the area inside.
fn window(
    frame: &mut Frame<'_>,
    screen: Rect,
    model: &Model,
    title: &str,
    size: (u16, u16),
) -> Rect {
    let width = size.0.min(screen.width.saturating_sub(4));
    let height = size.1.min(screen.height.saturating_sub(2));
    let area = Rect {
        x: screen.x + (screen.width - width) / 2,
        y: screen.y + (screen.height - height) / 3,
        width,
        height,
    };
    window_at(frame, area, model, title)
}

/// A window somewhere; gives the area inside.
fn window_at(frame: &mut Frame<'_>, area: Rect, model: &Model, title: &str) -> Rect {
    let block = Block::bordered()
        .border_type(BorderType::Thick)
        .border_style(Style::new().fg(model.theme.border_focused))
        .title(format!(" {title} "))
        .style(model.theme.base());
    let inner = block.inner(area);
    frame.render_widget(Clear, area);
    frame.render_widget(block, area);
    inner
}

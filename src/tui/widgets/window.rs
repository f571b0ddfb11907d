//! Windows over the main screen: centred or at the right, with scrollable text.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::Text;
use ratatui::widgets::{Block, BorderType, Clear, Paragraph, Wrap};

use super::hints;
use crate::tui::model::Model;

/// Columns of a window at most, its borders included.
pub const COLUMNS: u16 = 92;

/// Columns of text in a window of text.
pub fn text_width(screen: Rect) -> usize {
    width_in(screen, COLUMNS)
}

/// Columns of text in a window of so many columns, its borders included.
pub fn width_in(screen: Rect, columns: u16) -> usize {
    usize::from(
        columns
            .min(screen.width.saturating_sub(4))
            .saturating_sub(2),
    )
}

/// Empties the screen above the footer for a window that fills it, and gives its area.
pub fn whole(frame: &mut Frame<'_>, screen: Rect, model: &Model) -> Rect {
    let body = Rect {
        height: screen.height.saturating_sub(1),
        ..screen
    };
    frame.render_widget(Clear, body);
    frame.render_widget(Block::new().style(model.theme.base()), body);
    body
}

/// A window of text, no further scrolled than to its end.
pub fn scrolled(
    frame: &mut Frame<'_>,
    screen: Rect,
    model: &Model,
    what: &str,
    text: Text<'static>,
    scroll: usize,
) {
    let (keys, _) = hints::scroll(model);
    let (close, _) = hints::close(model);
    let title = format!("{what} · {keys} scroll · {close} closes");
    scrolled_in(frame, screen, model, &title, text, (COLUMNS, scroll));
}

/// The same, with its own title and width.
pub fn scrolled_in(
    frame: &mut Frame<'_>,
    screen: Rect,
    model: &Model,
    title: &str,
    text: Text<'static>,
    (columns, scroll): (u16, usize),
) {
    let inner = window(frame, screen, model, title, (columns, 60));
    text_in(frame, inner, model, text, scroll);
}

/// Text in a window, no further scrolled than to its end.
pub fn text_in(
    frame: &mut Frame<'_>,
    inner: Rect,
    model: &Model,
    text: Text<'static>,
    scroll: usize,
) {
    let paragraph = Paragraph::new(text).wrap(Wrap { trim: false });
    let last = paragraph
        .line_count(inner.width)
        .saturating_sub(usize::from(inner.height));
    model.drawn.set_window_end(last);
    let scroll = u16::try_from(scroll.min(last)).unwrap_or(u16::MAX);
    frame.render_widget(paragraph.scroll((scroll, 0)), inner);
}

/// Text in a window at the right, below the header and no higher than the text; the map stays in sight beside it.
pub fn at_right(
    frame: &mut Frame<'_>,
    screen: Rect,
    model: &Model,
    title: &str,
    text: Text<'static>,
    (columns, scroll): (u16, usize),
) {
    let lines = u16::try_from(text.lines.len()).unwrap_or(u16::MAX);
    let height = screen.height.saturating_sub(2);
    let area = Rect {
        x: screen.right() - columns,
        y: screen.y + 1.min(screen.height),
        width: columns,
        height: height.min(lines.saturating_add(2).max(6)),
    };
    let inner = window_at(frame, area, model, title);
    text_in(frame, inner, model, text, scroll);
}

/// A window in the middle; gives the area inside.
pub fn window(
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
pub fn window_at(frame: &mut Frame<'_>, area: Rect, model: &Model, title: &str) -> Rect {
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

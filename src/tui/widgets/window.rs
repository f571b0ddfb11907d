//! Windows over the main screen: centred or at the right, with scrollable text.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Span, Text};
use ratatui::widgets::{Block, BorderType, Clear, Paragraph, Wrap};

use super::words::thousands;
use crate::model::Model;

/// Columns of a window at most, its borders included.
pub const COLUMNS: u16 = 92;

/// Columns of text in a window of text.
pub fn text_width(screen: Rect) -> usize {
    width_in(screen, COLUMNS)
}

/// Columns of text in a window of so many columns, its borders included.
pub fn width_in(screen: Rect, columns: u16) -> usize {
    usize::from(outer_width(screen, columns).saturating_sub(2))
}

/// Columns of the screen below which windows take its whole width: what is left beside them would say nothing.
const NARROW: u16 = 100;

/// Columns beside a window below which they are emptied, too: they would only show ends of words.
const SLIVER: u16 = 20;

/// Columns of a window that wants so many, its borders included.
fn outer_width(screen: Rect, columns: u16) -> u16 {
    match screen.width {
        width @ ..NARROW => width,
        width => columns.min(width.saturating_sub(4)),
    }
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
    scrolled_in(frame, screen, model, what, text, COLUMNS, scroll);
}

/// The same, with its own title and width.
pub fn scrolled_in(
    frame: &mut Frame<'_>,
    screen: Rect,
    model: &Model,
    title: &str,
    text: Text<'static>,
    columns: u16,
    scroll: usize,
) {
    let inner = window(frame, screen, model, title, (columns, 60));
    text_in(frame, inner, model, text, scroll);
}

/// Text in a window, no further scrolled than to its end; its lower border says how much is below.
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
    let top = scroll.min(last);
    let scroll = u16::try_from(top).unwrap_or(u16::MAX);
    frame.render_widget(paragraph.scroll((scroll, 0)), inner);
    below(frame, inner, model, last - top);
}

/// Writes on a window's lower border how many lines are below.
pub fn below(frame: &mut Frame<'_>, inner: Rect, model: &Model, lines: usize) {
    if lines == 0 {
        return;
    }
    let words = Span::styled(more_lines(lines), Style::new().fg(model.theme.dim));
    let width = u16::try_from(words.width()).unwrap_or(u16::MAX);
    let place = Rect {
        x: inner.right().saturating_sub(width).max(inner.x),
        y: inner.bottom(),
        width: width.min(inner.width),
        height: 1,
    };
    frame.render_widget(words, place.intersection(frame.area()));
}

/// How many lines are below what is seen.
#[must_use]
pub fn more_lines(lines: usize) -> String {
    match lines {
        1 => " 1 more line ".into(),
        n => format!(" {} more lines ", thousands(n as u64)),
    }
}

/// Text in a window at the right, between header and footer; the panes end beside it.
pub fn at_right(
    frame: &mut Frame<'_>,
    screen: Rect,
    model: &Model,
    title: &str,
    text: Text<'static>,
    columns: u16,
    scroll: usize,
) {
    let area = Rect {
        x: screen.right() - columns,
        y: screen.y + 1.min(screen.height),
        width: columns,
        height: screen.height.saturating_sub(2),
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
    let width = outer_width(screen, size.0);
    let height = size.1.min(screen.height.saturating_sub(2));
    let area = Rect {
        x: screen.x + (screen.width - width) / 2,
        // The header stays in sight.
        y: screen.y + ((screen.height - height) / 3).max(1.min(screen.height - height)),
        width,
        height,
    };
    margin(frame, screen, area, model);
    window_at(frame, area, model, title)
}

/// Empties a border around a window, so that no slivers of what it covers are left at its sides; header and footer
/// stay.
pub fn margin(frame: &mut Frame<'_>, screen: Rect, area: Rect, model: &Model) {
    let body = Rect {
        y: screen.y + 1,
        height: screen.height.saturating_sub(2),
        ..screen
    };
    // A window at the right edge leaves the border of the pane beside it.
    let columns = if area.right() == screen.right() { 1 } else { 2 };
    let mut wide = Rect {
        x: area.x.saturating_sub(columns),
        y: area.y.saturating_sub(1),
        width: area.width.saturating_add(2 * columns),
        height: area.height.saturating_add(2),
    }
    .intersection(body);
    let (left, right) = (area.x - screen.x, screen.right() - area.right());
    if left < SLIVER {
        wide.width += wide.x - screen.x;
        wide.x = screen.x;
    }
    if right < SLIVER {
        wide.width = screen.right() - wide.x;
    }
    frame.render_widget(Clear, wide);
    frame.render_widget(Block::new().style(model.theme.base()), wide);
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

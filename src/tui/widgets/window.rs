//! Windows and frames with titles.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Block, BorderType, Clear, Paragraph, Wrap};

use crate::model::{Model, Pane};
use crate::widgets::unbroken;
use crate::widgets::words::{fit, thousands};

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

/// Columns of a window that wants so many, its borders included.
fn outer_width(screen: Rect, columns: u16) -> u16 {
    match screen.width {
        width @ ..NARROW => width,
        width => columns.min(width.saturating_sub(4)),
    }
}

/// Empties the screen above the footer for a window that fills it, and gives its area.
pub fn full_screen(frame: &mut Frame<'_>, screen: Rect, model: &Model) -> Rect {
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
    let paragraph = Paragraph::new(unbroken::text(text)).wrap(Wrap { trim: false });
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
    dim(frame, screen, area, model);
    window_at(frame, area, model, title)
}

/// Dims what is around a window; header and footer stay.
fn dim(frame: &mut Frame<'_>, screen: Rect, area: Rect, model: &Model) {
    let body = Rect {
        y: screen.y + 1,
        height: screen.height.saturating_sub(2),
        ..screen
    };
    let theme = &model.theme;
    let around = body.positions().filter(|at| !area.contains(*at));
    for at in around {
        if let Some(cell) = frame.buffer_mut().cell_mut(at) {
            let front = match cell.fg {
                Color::Reset => theme.text,
                own => own,
            };
            let (front, back) = (theme.dimmed(front), theme.dimmed(cell.bg));
            cell.set_fg(front).set_bg(back);
            cell.modifier.remove(Modifier::BOLD);
            cell.modifier.insert(theme.dimming());
        }
    }
}

/// A window somewhere that has the keys; gives the area inside.
pub fn window_at(frame: &mut Frame<'_>, area: Rect, model: &Model, title: &str) -> Rect {
    let border = Style::new().fg(model.theme.border_focused);
    let block = Block::bordered().border_type(BorderType::Thick);
    framed(frame, area, model, title, block.border_style(border))
}

/// A part of a screen that never has the keys; gives the area inside.
pub fn beside(frame: &mut Frame<'_>, area: Rect, model: &Model, title: &str) -> Rect {
    let border = Style::new().fg(model.theme.border);
    let words = Style::new().fg(model.theme.title);
    let block = Block::bordered().border_style(border).title_style(words);
    framed(frame, area, model, title, block)
}

fn framed(frame: &mut Frame<'_>, area: Rect, model: &Model, title: &str, block: Block<'_>) -> Rect {
    // Inside the corners, with a space on both sides.
    let title = fit(title, usize::from(area.width).saturating_sub(4));
    let block = block.title(format!(" {title} ")).style(model.theme.base());
    let inner = block.inner(area);
    frame.render_widget(Clear, area);
    frame.render_widget(block, area);
    inner
}

/// Draws the frame of a pane and gives the area inside.
pub fn pane(frame: &mut Frame<'_>, area: Rect, model: &Model, pane: Pane, title: Line<'_>) -> Rect {
    let look = look(model, pane);
    let block = Block::bordered()
        .border_type(look.kind)
        .border_style(look.border)
        .title(spaced(title).style(look.title));
    let inner = block.inner(area);
    frame.render_widget(block, area);
    model.drawn.pane(pane, area);
    inner
}

/// Draws a line across a pane, a column or a row inside its frame, and the title of what is behind it.
pub fn divide(
    frame: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    pane: Pane,
    line: Rect,
    title: Line<'_>,
) {
    let look = look(model, pane);
    let thick = matches!(look.kind, BorderType::Thick);
    let upright = line.width < line.height;
    // From border to border.
    let (whole, signs, title_at) = if upright {
        let whole = Rect {
            y: area.y,
            height: area.height,
            ..line
        };
        let signs = if thick {
            ["┯", "│", "┷"]
        } else {
            ["┬", "│", "┴"]
        };
        (whole, signs, (line.x + 1, area.y))
    } else {
        let whole = Rect {
            x: area.x,
            width: area.width,
            ..line
        };
        let signs = if thick {
            ["┠", "─", "┨"]
        } else {
            ["├", "─", "┤"]
        };
        (whole, signs, (area.x + 1, line.y))
    };
    let count = whole.positions().count();
    let buffer = frame.buffer_mut();
    for (place, at) in whole.positions().enumerate() {
        let sign = match place {
            0 => signs[0],
            _ if place + 1 == count => signs[2],
            _ => signs[1],
        };
        buffer[at].set_symbol(sign).set_style(look.border);
    }
    let title = spaced(title).style(look.title);
    let (x, y) = title_at;
    let room = area.right().saturating_sub(x + 1);
    buffer.set_line(x, y, &title, room);
}

/// How the frame of a pane looks.
struct FrameLook {
    title: Style,
    border: Style,
    kind: BorderType,
}

/// A thick border says without colour which pane has the keys.
fn look(model: &Model, pane: Pane) -> FrameLook {
    let theme = &model.theme;
    // Beside answers that are compared, the map only shows.
    if model.focus == pane && model.screens.is_empty() && !model.compare.open {
        FrameLook {
            title: Style::new().fg(theme.accent).add_modifier(Modifier::BOLD),
            border: Style::new().fg(theme.border_focused),
            kind: BorderType::Thick,
        }
    } else {
        FrameLook {
            title: Style::new().fg(theme.title),
            border: Style::new().fg(theme.border),
            kind: BorderType::Plain,
        }
    }
}

fn spaced(title: Line<'_>) -> Line<'_> {
    let mut spaced = Line::from(" ");
    spaced.spans.extend(title.spans);
    spaced.spans.push(" ".into());
    spaced
}

//! Notices: at the right of the bottom line if they fit, else in boxes that cover neither plot nor timeline.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Text};
use ratatui::widgets::{Block, Clear, Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::layout::ScreenAreas;
use crate::model::{Model, Notice, Pane, Toast};
use nearmiss_scene::description::visible;

/// Messages shown at once.
const MOST: usize = 3;
/// Columns of a box at least, where the screen has them.
const NARROWEST: u16 = 50;

/// Columns of the bottom line that keys keep beside a message; where they would have fewer, it has the whole line.
const KEYS: u16 = 24;

/// The message of the bottom line, and how many of its columns it takes.
pub fn message(model: &Model, columns: u16) -> Option<(&Toast, u16)> {
    let room = columns.saturating_sub(2);
    // While an attack is searched for, the line says how far and how to cancel.
    let is_free = model.maker.under_way.is_none();
    let width = |toast: &Toast| u16::try_from(visible(&toast.text).width()).unwrap_or(u16::MAX);
    let in_a_line = |toast: &&Toast| is_free && toast.kind != Notice::Error && width(toast) <= room;
    let mut shown = model.toasts.iter().filter(|toast| told(model, toast));
    let toast = shown.rfind(in_a_line)?;
    let taken = width(toast).saturating_add(2);
    Some(if columns.saturating_sub(taken) < KEYS {
        (toast, columns)
    } else {
        (toast, taken)
    })
}

/// Whether a message may be shown.
fn told(model: &Model, toast: &Toast) -> bool {
    !(model.compare.hides() && names_a_model(model, &toast.text))
}

pub fn draw(frame: &mut Frame<'_>, parts: &ScreenAreas, model: &Model) {
    let line = message(model, parts.footer.width);
    if let Some((toast, columns)) = line {
        let style = Style::new()
            .fg(model.theme.accent)
            .add_modifier(Modifier::BOLD);
        let words = Line::styled(format!(" {}", visible(&toast.text)), style);
        let area = Rect {
            x: parts.footer.right().saturating_sub(columns),
            width: columns,
            ..parts.footer
        };
        frame.render_widget(Clear, area);
        frame.render_widget(Block::new().style(model.theme.base()), area);
        frame.render_widget(words, area);
    }
    let boxed = model
        .toasts
        .iter()
        .rev()
        .filter(|toast| told(model, toast))
        .filter(|toast| line.is_none_or(|(shown, _)| !std::ptr::eq(shown, *toast)));
    boxes(frame, place(parts, model), model, boxed.take(MOST));
}

/// Whether a message would tell whose an answer is.
fn names_a_model(model: &Model, text: &str) -> bool {
    let mut columns = model.answers.columns.iter();
    columns.any(|c| text.contains(&c.model))
}

/// Where boxes stand: over the reasoning and, if they are many, over the verdicts; or over the pane that is shown
/// alone. Beside a window at the right, over what it leaves in sight.
fn place(parts: &ScreenAreas, model: &Model) -> Rect {
    let screen = parts.header.union(parts.footer);
    let top = model.screens.top();
    if let Some(window) = top.and_then(|top| top.columns_at_right(screen)) {
        return Rect {
            y: parts.header.bottom(),
            width: screen.width.saturating_sub(window),
            height: parts.footer.y.saturating_sub(parts.header.bottom()),
            ..screen
        };
    }
    let reasoning = parts.panes.iter().find(|(p, _)| *p == Pane::Reasoning);
    let (_, area) = match (reasoning, parts.panes.first()) {
        (Some(found), _) | (None, Some(found)) => *found,
        (None, None) => (Pane::Reasoning, parts.header),
    };
    let (top, right) = (parts.header.bottom(), parts.header.right());
    let width = area.width.max(NARROWEST).min(parts.header.width);
    // The line that is typed into, with the frame below it, stays in sight.
    let below = if model.prompt.editing { 2 } else { 0 };
    Rect {
        x: right - width,
        y: top,
        width,
        height: area.bottom().saturating_sub(top + below),
    }
}

/// The newest at the bottom.
fn boxes<'a>(
    frame: &mut Frame<'_>,
    place: Rect,
    model: &Model,
    toasts: impl Iterator<Item = &'a Toast>,
) {
    let mut bottom = place.bottom();
    for toast in toasts {
        let (color, title) = match toast.kind {
            Notice::Error => (model.theme.danger, " error "),
            Notice::Reply | Notice::News => (model.theme.accent, ""),
        };
        let text = visible(&toast.text);
        let wanted = u16::try_from(text.width()).unwrap_or(u16::MAX);
        let width = wanted.saturating_add(4).clamp(24, place.width.max(24));
        let words =
            Paragraph::new(Text::styled(text, model.theme.base())).wrap(Wrap { trim: true });
        let lines = words.line_count(width.saturating_sub(4));
        let height = u16::try_from(lines)
            .unwrap_or(u16::MAX)
            .saturating_add(2)
            .min(place.height);
        if bottom < place.y + height {
            break;
        }
        let area = Rect::new(place.right() - width, bottom - height, width, height);
        let block = Block::bordered()
            .border_style(Style::new().fg(color))
            .title(title)
            .padding(ratatui::widgets::Padding::horizontal(1));
        frame.render_widget(Clear, area);
        frame.render_widget(words.block(block), area);
        bottom -= height;
    }
}

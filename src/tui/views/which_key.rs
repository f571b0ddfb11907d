//! Which-key: the keys that can follow a started chord, in a box that leaves the selected line in sight.

use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, BorderType, Clear, Paragraph};
use unicode_width::UnicodeWidthStr;

use crate::action::{Entry, title_of};
use crate::keymap::Chord;
use crate::model::Model;
use crate::widgets::window;
use crate::widgets::words::{fit, pad};

/// Columns between two columns of keys.
const GAP: usize = 3;
/// Columns of the state of a setting at most.
const STATE: usize = 16;
/// Cells in reverse that make a selected line.
const SELECTED: usize = 10;

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
    let (look, theme) = (&model.look, &model.theme);
    if look.pending.is_empty() {
        return;
    }
    // A window beside the scene knows the actions on it.
    let beside = model
        .screens
        .top()
        .and_then(|top| top.columns_at_right(screen));
    let works = |entry: &Entry| {
        beside.is_some() || entry.scope == model.scope() || model.takes(entry.action)
    };
    let following = look.keymap.following(&look.pending, model.scope(), works);
    let rows = following.iter().map(|next| {
        let more = if next.leads_on { " …" } else { "" };
        let state = next
            .action
            .and_then(|action| model.state_of(action))
            .map_or(String::new(), |state| format!(" ({})", fit(state, STATE)));
        (next.key.to_string(), format!("{}{more}{state}", next.words))
    });
    let rows: Vec<(String, String)> = rows.collect();
    let keys = rows.iter().map(|(key, _)| key.width()).max().unwrap_or(0);
    let words = rows.iter().map(|(_, words)| words.width()).max();
    let column = keys + 1 + words.unwrap_or(0);
    let chord = Chord(look.pending.clone());
    let title = match title_of(&look.pending) {
        Some(title) => format!(" {chord} · {title} "),
        None => format!(" {chord} "),
    };
    let (title, room) = (title.as_str(), usize::from(screen.width.saturating_sub(4)));
    // No more columns than rows need: a short list stays one column.
    let fitting = ((room + GAP) / (column + GAP)).max(1);
    let columns = fitting.min(rows.len().div_ceil(LOWEST)).max(1);
    let height = rows.len().div_ceil(columns);
    let width = (columns * (column + GAP) - GAP + 2).max(title.width());
    let size = |cells: usize| u16::try_from(cells + 2).unwrap_or(u16::MAX);
    let (width, height) = (
        size(width).min(screen.width),
        size(height).min(screen.height.saturating_sub(2)),
    );
    let below = Rect {
        x: screen.right() - width,
        y: screen.bottom().saturating_sub(height + 1),
        width,
        height,
    };
    let above = Rect {
        y: screen.y + 1,
        ..below
    };
    let area = if hides_selection(frame.buffer_mut(), below) {
        above
    } else {
        below
    };
    let bold = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
    let block = Block::bordered()
        .border_type(BorderType::Thick)
        .border_style(Style::new().fg(theme.border_focused))
        .title(Span::styled(title.to_string(), bold))
        .style(theme.base());
    let inner = block.inner(area);
    let lines = usize::from(inner.height);
    let room = usize::from(inner.width).saturating_sub(keys + 3);
    let lines = (0..lines).map(|row| {
        let mut line = Line::default();
        for (key, words) in rows.iter().skip(row).step_by(lines) {
            let words = match columns {
                1 => fit(words, room),
                _ => pad(words, column - keys - 2 + GAP),
            };
            line.push_span(Span::styled(format!(" {} ", pad(key, keys)), bold));
            line.push_span(Span::raw(words));
        }
        line
    });
    window::margin(frame, screen, area, model);
    frame.render_widget(Clear, area);
    frame.render_widget(block, area);
    frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()), inner);
}

/// Rows before a second column is begun.
const LOWEST: usize = 5;

/// Whether a selected line, which is drawn in reverse, lies in an area.
fn hides_selection(buffer: &Buffer, area: Rect) -> bool {
    let area = area.intersection(*buffer.area());
    area.rows().any(|row| {
        let reversed = row.columns().filter(|cell| {
            let cell = &buffer[(cell.x, cell.y)];
            cell.modifier.contains(Modifier::REVERSED)
        });
        reversed.count() >= SELECTED
    })
}

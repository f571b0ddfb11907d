//! What lies over the panes: messages at the bottom, errors in boxes, the first hint, and the keys that can follow.

use nearmiss_scene::description::visible;
use nearmiss_scene::judge;
use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Block, BorderType, Clear, Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::action::{Action, Entry, title_of};
use crate::keymap::Chord;
use crate::layout::ScreenAreas;
use crate::model::{Model, Notice, Pane, ShownAnswer, Toast};
use crate::widgets::unbroken::unbroken;
use crate::widgets::words::{fit, pad, two_lines};

/// Errors shown at once.
const MAX_SHOWN: usize = 3;
/// Columns of a box at least, where the screen has them.
const NARROWEST: u16 = 50;

/// Columns of the bottom line that keys keep beside a message; where they would have fewer, it has the whole line.
const KEYS: u16 = 24;
/// The same while an attack is searched for: how far that is, and how to cancel.
const SEARCH: u16 = 72;

/// The message at the bottom of the screen.
pub struct BottomMessage {
    /// One or two lines.
    lines: Vec<String>,
    /// The columns that it takes.
    columns: u16,
    /// Whether it stands above the line of keys, which has no room for it.
    above: bool,
}

impl BottomMessage {
    /// How many columns of the line of keys it takes.
    pub fn columns_of_keys(&self) -> u16 {
        if self.above { 0 } else { self.columns }
    }

    fn rows(&self) -> u16 {
        u16::try_from(self.lines.len()).unwrap_or(1)
    }

    /// How many rows it needs above the line of keys.
    fn rows_above(&self) -> u16 {
        self.rows().saturating_sub(u16::from(!self.above))
    }
}

/// The message at the bottom of a screen of so many columns: the newest that is no error.
pub fn message(model: &Model, columns: u16) -> Option<BottomMessage> {
    let shows = |toast: &&Toast| toast.kind != Notice::Error && may_show(model, toast);
    let toast = model.toasts.iter().rfind(shows)?;
    let room = usize::from(columns.saturating_sub(2));
    let (mut lines, cut) = two_lines(&toast.text, room);
    if let (true, Some(last)) = (cut, lines.last_mut()) {
        let rest = format!(" {} all of it", model.look.key(Action::About));
        *last = format!("{}{rest}", fit(last, room.saturating_sub(rest.width())));
    }
    let widest = lines.iter().map(|line| line.width()).max().unwrap_or(0);
    let wanted = u16::try_from(widest + 2).unwrap_or(u16::MAX);
    let searching = model.generation.under_way.is_some();
    let keys = if searching { SEARCH } else { KEYS };
    let beside = lines.len() == 1 && columns.saturating_sub(wanted) >= keys;
    let above = searching && !beside;
    Some(BottomMessage {
        lines,
        columns: if beside { wanted } else { columns },
        above,
    })
}

/// Takes the rows that the message needs above the line of keys off what is above; gives the rest of the screen.
pub fn make_room_below(parts: &mut ScreenAreas, screen: Rect, model: &Model) -> Rect {
    let rows = message(model, screen.width).map_or(0, |message| message.rows_above());
    let footer = &mut parts.footer;
    let lowest = parts.panes.iter_mut().map(|(_, pane)| pane);
    for pane in lowest.filter(|pane| pane.bottom() == footer.y) {
        pane.height = pane.height.saturating_sub(rows);
    }
    footer.y = footer.y.saturating_sub(rows);
    footer.height += rows;
    Rect {
        height: screen.height.saturating_sub(rows),
        ..screen
    }
}

/// Whether a message may be shown.
fn may_show(model: &Model, toast: &Toast) -> bool {
    !(model.compare.hides() && names_a_model(model, &toast.text))
}

pub fn draw(frame: &mut Frame<'_>, parts: &ScreenAreas, model: &Model) {
    let newest = model.toasts.iter().rev();
    let errors = newest.filter(|toast| toast.kind == Notice::Error && may_show(model, toast));
    boxes(frame, place(parts, model), model, errors.take(MAX_SHOWN));
    let Some(message) = message(model, parts.footer.width) else {
        return;
    };
    let style = Style::new()
        .fg(model.theme.accent)
        .add_modifier(Modifier::BOLD);
    let area = Rect {
        x: parts.footer.right().saturating_sub(message.columns),
        width: message.columns,
        height: message.rows(),
        ..parts.footer
    };
    let words = message.lines.iter();
    let lines = words.map(|line| Line::styled(format!(" {line}"), style));
    frame.render_widget(Clear, area);
    frame.render_widget(Block::new().style(model.theme.base()), area);
    frame.render_widget(Text::from_iter(lines), area);
}

/// Whether a message would tell whose an answer is.
fn names_a_model(model: &Model, text: &str) -> bool {
    let mut columns = model.answers.columns.iter();
    columns.any(|c| text.contains(&c.model))
}

/// Where errors stand: over the reasoning and, if they are many, over the verdicts; or over the pane that is shown
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
        let text = visible(&toast.text);
        let wanted = u16::try_from(text.width()).unwrap_or(u16::MAX);
        let width = wanted.saturating_add(4).clamp(24, place.width.max(24));
        let words = Paragraph::new(Text::styled(unbroken(&text), model.theme.base()))
            .wrap(Wrap { trim: true });
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
            .border_style(Style::new().fg(model.theme.danger))
            .title(" error ")
            .padding(ratatui::widgets::Padding::horizontal(1));
        frame.render_widget(Clear, area);
        frame.render_widget(words.block(block), area);
        bottom -= height;
    }
}

/// Takes the rows of the box off the pane of the reasoning, so that it has a frame of its own.
pub fn make_room(parts: &mut ScreenAreas, model: &Model) -> Option<Rect> {
    let mut panes = parts.panes.iter_mut();
    let (_, pane) = panes.find(|(pane, _)| *pane == Pane::Reasoning)?;
    if !is_shown(model) || pane.height < LOWEST {
        return None;
    }
    pane.height -= HEIGHT;
    Some(Rect {
        y: pane.bottom(),
        height: HEIGHT,
        ..*pane
    })
}

/// An answer the user asked for leaves no room; after making a variant, the first verdict is past.
fn is_shown(model: &Model) -> bool {
    let free = model.answers.shown == ShownAnswer::Reference && model.variant().is_none();
    model.recall.hint && free
}

/// Draws the hint in the area made for it, or in the border of the reasoning.
pub fn draw_hint(frame: &mut Frame<'_>, parts: &ScreenAreas, area: Option<Rect>, model: &Model) {
    let reasoning = parts.panes.iter().find(|(p, _)| *p == Pane::Reasoning);
    let (true, Some((_, pane))) = (is_shown(model), reasoning) else {
        return;
    };
    let run = model.look.key(Action::Run);
    let asks = match model.model.as_str() {
        judge::MODEL => (
            Action::ChooseModel,
            format!("choose a model, {run} asks it"),
            "model",
        ),
        other => (Action::Run, format!("ask {}", visible(other)), "ask"),
    };
    let rows = [
        (Action::Down, "open the next scenario".to_string(), "next"),
        (
            Action::Play,
            "play from 3 s before this moment".into(),
            "play",
        ),
        asks,
    ]
    .map(|(action, words, short)| (model.look.key(action), words, short));
    let Some(area) = area else {
        return in_border(frame, *pane, model, &rows);
    };
    let rows = rows.map(|(key, words, _)| (key, words));
    let keys = rows.iter().map(|(key, _)| key.width()).max().unwrap_or(0);
    let theme = &model.theme;
    let bold = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
    let block = Block::bordered()
        .border_style(Style::new().fg(theme.accent))
        .title(Span::styled(" three keys; more: nearmiss --tour ", bold))
        .style(theme.base());
    let room = usize::from(area.width).saturating_sub(keys + 5);
    let lines = rows.iter().map(|(key, words)| {
        Line::from(vec![
            Span::styled(format!(" {}  ", pad(key, keys)), bold),
            Span::raw(fit(words, room)),
        ])
    });
    let text = Paragraph::new(lines.collect::<Vec<_>>()).block(block);
    frame.render_widget(Clear, area);
    frame.render_widget(text, area);
}

/// Rows of the box: three keys and its frame.
const HEIGHT: u16 = 5;

/// Rows of the pane from which the box leaves enough of its text in sight.
const LOWEST: u16 = 10;

/// The same in the lower border of the pane.
fn in_border(
    frame: &mut Frame<'_>,
    pane: Rect,
    model: &Model,
    rows: &[(String, String, &'static str)],
) {
    let theme = &model.theme;
    let bold = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
    let mut line = Line::default();
    for (key, _, short) in rows {
        line.push_span(Span::styled(format!(" {key}"), bold));
        line.push_span(Span::styled(
            format!(" {short} "),
            Style::new().fg(theme.dim),
        ));
    }
    let area = Rect {
        x: pane.x + 1,
        y: pane.bottom().saturating_sub(1),
        width: pane
            .width
            .saturating_sub(2)
            .min(u16::try_from(line.width()).unwrap_or(u16::MAX)),
        height: 1,
    };
    frame.render_widget(line, area);
}

/// Columns between two columns of keys.
const GAP: usize = 3;
/// Columns of the state of a setting at most.
const STATE: usize = 16;
/// Cells in reverse that make a selected line.
const SELECTED: usize = 10;

pub fn draw_keys(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
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
        (next.key.to_string(), format!("{}{more}{state}", next.label))
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
    let columns = fitting.min(rows.len().div_ceil(LOWEST_KEYS)).max(1);
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
    frame.render_widget(Clear, area);
    frame.render_widget(block, area);
    frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()), inner);
}

/// Rows before a second column is begun.
const LOWEST_KEYS: usize = 5;

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

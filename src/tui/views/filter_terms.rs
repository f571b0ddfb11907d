//! The terms of the filter, in a box at the bottom while it is typed.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::Paragraph;

use crate::model::{Model, Pane, TERMS};
use crate::widgets::window;
use crate::widgets::words::pad;

/// Columns of the box at most, its borders included, and of a term.
const COLUMNS: u16 = 96;
const TERM: usize = 16;

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
    if model.list.filtering.is_none() {
        return;
    }
    let theme = &model.theme;
    let key = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
    let width = COLUMNS.min(screen.width);
    let room = usize::from(width).saturating_sub(TERM + 4);
    let mut text = Text::default();
    for (term, words) in TERMS {
        let mut term = *term;
        for words in textwrap::wrap(words, room) {
            text.push_line(Line::from(vec![
                Span::styled(format!(" {}", pad(term, TERM)), key),
                Span::raw(words.into_owned()),
            ]));
            term = "";
        }
    }
    let height = u16::try_from(text.lines.len() + 2).unwrap_or(u16::MAX);
    let area = Rect {
        x: screen.x,
        y: screen.bottom().saturating_sub(height + 1),
        width,
        height,
    };
    // The list stays in sight: it is narrowed down while one types.
    let list = model.drawn.area(Pane::Scenarios).unwrap_or_default();
    let hidden = list.intersection(area).height;
    if height + 2 > screen.height || hidden * 2 > list.height {
        return;
    }
    let title = "filter: words, and these terms";
    window::margin(frame, screen, area, model);
    let inner = window::window_at(frame, area, model, title);
    frame.render_widget(Paragraph::new(text), inner);
}

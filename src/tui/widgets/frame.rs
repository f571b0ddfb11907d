//! The frame of a pane: border, title and focus indicator.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::Line;
use ratatui::widgets::{Block, BorderType};

use crate::tui::model::{Model, Pane};

/// Draws the frame of a pane and gives the area inside.
pub fn pane(frame: &mut Frame<'_>, area: Rect, model: &Model, pane: Pane, title: Line<'_>) -> Rect {
    let focused = model.focus == pane && model.screens.is_empty();
    let theme = &model.theme;
    let color = if focused {
        theme.border_focused
    } else {
        theme.border
    };
    let mut style = Style::new().fg(theme.title);
    let mut kind = BorderType::Plain;
    if focused {
        // A thick border says it without colour.
        style = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
        kind = BorderType::Thick;
    }
    let mut spaced = Line::from(" ");
    spaced.spans.extend(title.spans);
    spaced.spans.push(" ".into());
    let block = Block::bordered()
        .border_type(kind)
        .border_style(Style::new().fg(color))
        .title(spaced.style(style));
    let inner = block.inner(area);
    frame.render_widget(block, area);
    model.drawn.pane(pane, area);
    inner
}

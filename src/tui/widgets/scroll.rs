//! A wrapped text with a position, and what is above and below it.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::Text;
use ratatui::widgets::{Paragraph, Scrollbar, ScrollbarOrientation, ScrollbarState, Wrap};

use crate::tui::model::{Extent, Model, Pane};

/// Draws `text` from line `top`, or its end for `None`; remembers the extent for the page keys.
pub fn text(
    frame: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    pane: Pane,
    text: Text<'_>,
    top: Option<usize>,
) -> Extent {
    // A column is left for the scroll bar.
    let inner = Rect {
        width: area.width.saturating_sub(1),
        ..area
    };
    let paragraph = Paragraph::new(text).wrap(Wrap { trim: false });
    let lines = paragraph.line_count(inner.width);
    let rows = usize::from(area.height);
    let last = lines.saturating_sub(rows);
    let top = top.unwrap_or(last).min(last);
    let scrolled = u16::try_from(top).unwrap_or(u16::MAX);
    frame.render_widget(paragraph.scroll((scrolled, 0)), inner);
    if last > 0 {
        let mut state = ScrollbarState::new(last + 1)
            .position(top)
            .viewport_content_length(rows);
        let bar = Scrollbar::new(ScrollbarOrientation::VerticalRight)
            .begin_symbol(None)
            .end_symbol(None)
            .track_symbol(Some(" "))
            .thumb_symbol("│")
            .style(Style::new().fg(model.theme.dim));
        frame.render_stateful_widget(bar, area, &mut state);
    }
    let extent = Extent { lines, rows, top };
    model.drawn.text(pane, extent);
    extent
}

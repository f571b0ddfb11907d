//! A wrapped, scrollable text, and how much of it is above and below.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Text};
use ratatui::widgets::{Paragraph, Scrollbar, ScrollbarOrientation, ScrollbarState, Wrap};

use super::long_text::{MarkedClaims, Reading, height};
use crate::model::{Extent, Model, Pane};

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
    let extent = extent(paragraph.line_count(inner.width), area, top);
    let scrolled = u16::try_from(extent.top).unwrap_or(u16::MAX);
    frame.render_widget(paragraph.scroll((scrolled, 0)), inner);
    bar(frame, area, model, pane, extent);
    extent
}

/// A part of a page.
pub enum PageSection<'a> {
    /// A line.
    Line(Line<'static>),
    /// A long text, as it was drawn last and as it is now.
    Text(&'a mut Reading, &'a str, MarkedClaims<'a>),
}

/// Draws parts below each other like [`text`]; of long texts only the visible part is laid out.
pub fn page(
    frame: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    pane: Pane,
    mut parts: Vec<PageSection<'_>>,
    top: Option<usize>,
) -> Extent {
    let theme = &model.theme;
    let inner = Rect {
        width: area.width.saturating_sub(1),
        ..area
    };
    let mut lines = 0;
    let mut starts = Vec::new();
    for part in &mut parts {
        starts.push(lines);
        lines += match part {
            PageSection::Line(line) => height(line.clone(), inner.width),
            PageSection::Text(reading, text, marks) => {
                reading.follow(text, marks, inner.width, theme);
                if !marks.claims.is_empty() {
                    let rows = reading.rows_of_claims(marks.claims.len());
                    model
                        .drawn
                        .set_claims(rows.into_iter().map(|row| row + lines));
                }
                reading.rows()
            }
        };
    }
    starts.push(lines);
    let extent = extent(lines, area, top);
    let (top, end) = (extent.top, extent.top + extent.rows);
    let mut seen = Vec::new();
    let mut above = 0;
    for (part, rows) in parts.into_iter().zip(starts.windows(2)) {
        if rows[1] <= top || rows[0] >= end {
            continue;
        }
        let hidden = top.saturating_sub(rows[0]);
        let (some, cut) = match part {
            PageSection::Line(line) => (vec![line], hidden),
            PageSection::Text(reading, _, marks) => {
                reading.seen(hidden, extent.rows, &marks, theme)
            }
        };
        if seen.is_empty() {
            above = cut;
        }
        seen.extend(some);
    }
    let words = Paragraph::new(Text::from(seen)).wrap(Wrap { trim: false });
    let above = u16::try_from(above).unwrap_or(u16::MAX);
    frame.render_widget(words.scroll((above, 0)), inner);
    bar(frame, area, model, pane, extent);
    extent
}

/// Where a text of so many rows stands.
fn extent(lines: usize, area: Rect, top: Option<usize>) -> Extent {
    let rows = usize::from(area.height);
    let last = lines.saturating_sub(rows);
    let top = top.unwrap_or(last).min(last);
    Extent { lines, rows, top }
}

/// Remembers the extent for the page keys, and draws the scroll bar.
fn bar(frame: &mut Frame<'_>, area: Rect, model: &Model, pane: Pane, extent: Extent) {
    let Extent { lines, rows, top } = extent;
    let last = lines.saturating_sub(rows);
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
    model.drawn.text(pane, extent);
}

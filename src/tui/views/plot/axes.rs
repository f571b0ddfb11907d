//! Plot axes with round numbers, and the area between them.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};
use ratatui::text::Span;
use unicode_width::UnicodeWidthStr;

use crate::render::Ticks;

/// Rows that a plot needs for a line along its lower end.
const ROWS_WITH_LINE: u16 = 8;
/// Columns that a number of the lower axis needs.
const COLUMNS: u16 = 7;

/// Values at the two ends of an axis.
pub type Range = (f64, f64);

/// Most numbers that fit on the vertical axis of a plot of this height.
pub fn most_upwards(area: Rect) -> usize {
    usize::from(rows(area) / 2 + 1).clamp(2, 5)
}

/// Rows of the plot itself.
fn rows(area: Rect) -> u16 {
    area.height.saturating_sub(below(area))
}

/// Rows under the plot: numbers, and a line where there is room.
fn below(area: Rect) -> u16 {
    1 + u16::from(area.height >= ROWS_WITH_LINE)
}

/// Draws the axes, `time` in seconds and `upwards` in `unit`; gives the area between them.
pub fn draw(
    f: &mut Frame<'_>,
    area: Rect,
    time: Range,
    upwards: &Ticks,
    unit: &str,
    color: Color,
) -> Rect {
    let style = Style::new().fg(color);
    let mut labels = upwards.labels();
    if let Some((_, top)) = labels.last_mut().filter(|_| !unit.is_empty()) {
        top.push_str(&format!(" {unit}"));
    }
    let widths = labels.iter().map(|(_, words)| words.width());
    let width = u16::try_from(widths.max().unwrap_or(0)).unwrap_or(0);
    let width = width.min(area.width / 3);
    let plot = Rect {
        x: area.x + width + 1,
        width: area.width.saturating_sub(width + 1),
        height: rows(area),
        ..area
    };
    if plot.width < 2 || plot.height < 2 {
        return Rect { height: 0, ..plot };
    }
    let mut put = |x: u16, y: u16, words: &str| {
        let room = Rect::new(x, y, area.right().saturating_sub(x), 1).intersection(area);
        f.render_widget(Span::styled(words.to_string(), style), room);
    };
    for y in plot.top()..plot.bottom() {
        put(plot.x - 1, y, "│");
    }
    let (low, high) = upwards.bounds();
    for (value, words) in &labels {
        let part = (high - value) / (high - low);
        let y = plot.y + place(part, plot.height);
        let short = u16::try_from(words.width()).unwrap_or(width);
        put(area.x + width.saturating_sub(short), y, words);
        put(plot.x - 1, y, "┤");
    }
    if below(area) > 1 {
        let line = "─".repeat(usize::from(plot.width));
        put(plot.x - 1, plot.bottom(), &format!("└{line}"));
    }
    let ticks = Ticks::within(
        time.0,
        time.1,
        usize::from(plot.width / COLUMNS).clamp(2, 9),
    );
    let ticks = ticks.labels();
    let count = ticks.len();
    for (i, (value, words)) in ticks.into_iter().enumerate() {
        let part = (value - time.0) / (time.1 - time.0);
        let x = plot.x + place(part, plot.width);
        let words = if i + 1 == count { words + " s" } else { words };
        let short = u16::try_from(words.width()).unwrap_or(0);
        // In the middle below its place, and inside at the ends.
        let from = x
            .saturating_sub(short / 2)
            .min(area.right().saturating_sub(short));
        put(from.max(area.x), area.bottom() - 1, &words);
        if below(area) > 1 {
            put(x, plot.bottom(), "┴");
        }
    }
    plot
}

/// The cell at a fraction of this many cells.
fn place(part: f64, cells: u16) -> u16 {
    (part.clamp(0.0, 1.0) * f64::from(cells.saturating_sub(1))).round() as u16
}

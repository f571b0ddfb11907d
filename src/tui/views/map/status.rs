//! Below a map: a round length on the left, and the picked obstacle in words on the right.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::Span;
use unicode_width::UnicodeWidthStr;

use crate::model::{Model, Moment};
use crate::widgets::words::hundredths;

/// The part of the width that the scale may take.
const SHARE: f64 = 0.2;

/// Draws both into a row, and gives what is free between them. `cell` is how many metres a column is wide; without it
/// there is no scale.
pub fn draw(
    f: &mut Frame<'_>,
    row: Rect,
    model: &Model,
    moment: &Moment<'_>,
    cell: Option<f64>,
) -> Rect {
    let mut free = row;
    if let Some(bar) = cell.and_then(|cell| scale_bar(row, cell)) {
        let bar = format!(" {bar} ");
        let width = columns(&bar).min(row.width);
        f.render_widget(Span::styled(bar, Style::new().fg(model.theme.dim)), row);
        free.x += width;
        free.width -= width;
    }
    let words = picked_in_words(model, moment, usize::from(free.width).saturating_sub(2));
    if words.is_empty() {
        return free;
    }
    let words = format!(" {words} ");
    let width = columns(&words).min(free.width);
    free.width -= width;
    let at = Rect {
        x: free.right(),
        width,
        ..row
    };
    f.render_widget(Span::styled(words, Style::new().fg(model.theme.picked)), at);
    free
}

fn columns(words: &str) -> u16 {
    u16::try_from(words.width()).unwrap_or(u16::MAX)
}

fn scale_bar(area: Rect, cell: f64) -> Option<String> {
    let most = f64::from(area.width) * SHARE;
    let lengths = [
        1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0,
    ];
    let length = lengths.into_iter().rev().find(|l| l / cell <= most)?;
    let columns = (length / cell).round().max(2.0) as usize;
    Some(format!(
        "├{}┤ {length:.0} m",
        "─".repeat(columns.saturating_sub(2))
    ))
}

/// As much as there is room for, the most telling first.
fn picked_in_words(model: &Model, moment: &Moment<'_>, room: usize) -> String {
    let Moment { opened, step, .. } = *moment;
    let picked = model.picked.and_then(|id| opened.scenario.obstacle(id));
    let Some(obstacle) = picked else {
        return String::new();
    };
    let value = |measure| {
        let series = opened.series.as_ref()?;
        series.at(measure, obstacle.id, step).value()
    };
    let parts = [
        Some(format!("{} {}", obstacle.kind, obstacle.id)),
        value("distance").map(|d| format!("{} m away", hundredths(d))),
        value("ttc").map(|t| format!("TTC {} s", hundredths(t))),
        obstacle
            .track()
            .at(step)
            .map(|m| format!("{:.1} m/s", m.velocity)),
    ];
    let mut text = String::new();
    for part in parts.into_iter().flatten() {
        let separator = if text.is_empty() { "" } else { " · " };
        if text.width() + separator.width() + part.width() > room {
            break;
        }
        text.push_str(separator);
        text.push_str(&part);
    }
    text
}

//! A picker: an input line with the matching items below.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use super::window;
use super::words::{fit, pad};
use crate::description::visible;
use crate::metrics::Measure;
use crate::tui::model::{Model, Picker};

/// Lines below the list in which a cut row stands whole.
pub const WHOLE: usize = 2;

/// Draws the typed line and the rows below it, each with what stands at its right.
pub fn draw(
    frame: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    picker: &Picker,
    rows: &[(String, String)],
) {
    let theme = &model.theme;
    let width = usize::from(area.width);
    let typed = format!("> {}▏", fit(&picker.text, width.saturating_sub(4)));
    let height = usize::from(area.height).saturating_sub(3 + WHOLE);
    let top = (picker.selected + 1).saturating_sub(height);
    let mut lines = vec![
        Line::styled(typed, Style::new().fg(theme.accent)),
        Line::default(),
    ];
    let mut whole = None;
    for (i, (left, right)) in rows.iter().enumerate().skip(top).take(height) {
        // The left part tells the rows apart, so it is cut last.
        let half = width
            .saturating_sub(left.trim_end().width() + 5)
            .max(width / 3);
        let (full_left, full_right) = (left, right);
        let right = fit(right, half);
        let left = pad(left, width.saturating_sub(right.width() + 4));
        let sign = if i == picker.selected { "▸ " } else { "  " };
        if i == picker.selected && (left.trim_end() != full_left.trim_end() || right != *full_right)
        {
            let words = full_left.split_whitespace().collect::<Vec<_>>().join(" ");
            whole = Some(format!("{words} · {full_right}"));
        }
        let line = Line::from(vec![
            Span::raw(sign),
            Span::raw(left),
            Span::styled(format!(" {right} "), Style::new().fg(theme.dim)),
        ]);
        lines.push(if i == picker.selected {
            theme.select(line)
        } else {
            line
        });
    }
    if rows.is_empty() {
        lines.push(Line::styled(
            "  nothing matches",
            Style::new().fg(theme.dim),
        ));
    }
    frame.render_widget(Paragraph::new(lines), area);
    if let Some(words) = whole {
        let rows = u16::try_from(WHOLE).unwrap_or(0);
        let below = Rect {
            y: area.bottom().saturating_sub(rows),
            height: rows.min(area.height),
            ..area
        };
        let words = Paragraph::new(visible(&words).into_owned()).wrap(Wrap { trim: true });
        frame.render_widget(words.style(Style::new().fg(theme.accent)), below);
    }
}

/// A hint in the last line of a list.
pub fn hint(frame: &mut Frame<'_>, area: Rect, model: &Model, words: &str) {
    let row = Rect {
        y: area.bottom().saturating_sub(1),
        height: 1,
        ..area
    };
    let line = Line::styled(words.to_string(), Style::new().fg(model.theme.dim));
    frame.render_widget(line, row);
}

/// A measure, and at its right where it is from.
pub fn measure_row(measure: &Measure) -> (String, String) {
    let unit = match measure.unit {
        "" => String::new(),
        unit => format!(", {unit}"),
    };
    let left = format!("{} {}{unit}", pad(measure.id, 16), measure.name);
    (left, measure.source.to_string())
}

/// Columns of a list of measures at least, however few match.
const MEASURES_WIDE: usize = 92;

/// A list of measures, as wide as its widest row: nothing is cut where the screen has the room.
pub fn draw_measures(
    frame: &mut Frame<'_>,
    screen: Rect,
    model: &Model,
    title: &str,
    picker: &Picker,
    rows: &[(String, String)],
) {
    let widths = rows
        .iter()
        .map(|(left, right)| left.width() + right.width());
    let widest = widths.max().unwrap_or(0).saturating_add(7);
    let width = u16::try_from(widest.max(MEASURES_WIDE)).unwrap_or(u16::MAX);
    let inner = window::window(frame, screen, model, title, (width, 48));
    draw(frame, inner, model, picker, rows);
}

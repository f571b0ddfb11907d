//! Bars of a model's right answers by technique, with confidence intervals.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use unicode_width::UnicodeWidthStr;

use super::matrix::model_name;
use crate::model::Model;
use crate::widgets::window;
use crate::widgets::words::pad;
use nearmiss_study::evaluation::Results;

/// Columns of a bar at most, and at least where numbers stand beside it.
const BAR: (usize, usize) = (80, 12);

/// The rows of the matrix that differ from the selected one in nothing but techniques.
pub fn rows(model: &Model) -> Vec<usize> {
    let results = &model.results;
    let Some(row) = results.row() else {
        return Vec::new();
    };
    let like = |other: &Results| {
        let (a, b) = (&row.configuration, &other.configuration);
        (a.task, a.frame, &a.model, a.settings) == (b.task, b.frame, &b.model, b.settings)
            && (a.techniques != b.techniques || a.template == b.template)
    };
    let all = results.rows.iter().enumerate();
    all.filter(|(_, other)| like(other))
        .map(|(place, _)| place)
        .collect()
}

/// Draws them; gives where the bars stand, and of which rows they are.
pub fn draw(
    frame: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    rows: &[usize],
) -> (Rect, Vec<usize>) {
    let results = &model.results;
    let title = results.row().map_or(String::new(), |row| {
        let task = row.configuration.task.name();
        let frame = row.configuration.frame.map_or("–", |frame| frame.name());
        let model = model_name(&row.configuration);
        format!("right by techniques, ▓░ 95 % interval · {task} {frame} · {model}")
    });
    let inner = window::window_at(frame, area, model, &title);
    let height = usize::from(inner.height);
    let chosen = rows.iter().position(|row| *row == results.selected);
    let top = (chosen.unwrap_or(0) + 1).saturating_sub(height);
    let shown: Vec<usize> = rows.iter().copied().skip(top).take(height).collect();
    let lines: Vec<Line<'_>> = shown
        .iter()
        .map(|row| bar(model, *row, usize::from(inner.width)))
        .collect();
    frame.render_widget(Paragraph::new(lines), inner);
    (inner, shown)
}

fn bar(model: &Model, place: usize, width: usize) -> Line<'static> {
    let (theme, results) = (&model.theme, &model.results);
    let row = &results.rows[place];
    let (right, asked) = row.right();
    let share = row.right_of_all();
    let number = share.map_or("  – ".into(), |share| format!("{share:.2}"));
    let interval = row.right_interval;
    let ends = interval.map_or("–".into(), |i| format!("{:.2} to {:.2}", i.low, i.high));
    let ends = pad(&ends, 12);
    let whole = format!(" {number}  {ends}  {right} of {asked}");
    let techniques = row
        .configuration
        .techniques
        .map_or("–".into(), |t| t.to_string());
    let room = |tail: &str| width.saturating_sub(2 + 11 + tail.width()).min(BAR.0);
    let tail = if room(&whole) < BAR.1 {
        format!(" {number}")
    } else {
        whole
    };
    let room = room(&tail);
    let cell = |share: f64| (share * room as f64).round() as usize;
    let long = cell(share.unwrap_or(0.0));
    let (low, high) = interval.map_or((long, long), |i| (cell(i.low), cell(i.high)));
    let low = low.min(long);
    let high = high.max(long);
    let chosen = place == results.selected;
    let style = Style::new().fg(if chosen { theme.accent } else { theme.dim });
    Line::from(vec![
        Span::raw(if chosen { "▸ " } else { "  " }),
        Span::raw(pad(&techniques, 11)),
        Span::styled("█".repeat(low), style),
        Span::styled("▓".repeat(long - low), style),
        Span::styled("░".repeat(high - long), style),
        Span::raw(" ".repeat(room - high)),
        Span::raw(tail),
    ])
}

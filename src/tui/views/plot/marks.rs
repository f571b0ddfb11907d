//! What is marked in a plot: the judged window, thresholds with their names, the current step, the contact and the most
//! dangerous value. Lines go behind the curves, and words where nothing else stands.

use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::{Position, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::Line;
use unicode_width::UnicodeWidthStr;

use super::axes::{Axes, Range};
use crate::model::Model;
use crate::widgets::line_placer::LinePlacer;
use crate::widgets::words::{fit, quantity};
use nearmiss_scene::metrics::Threshold;

/// Signs of lines.
const THRESHOLD: char = '┄';
const NOW: char = '│';
const EVENT: char = '╎';

/// A time that something happens at.
pub struct Event {
    /// When.
    pub time: f64,
    /// Its sign.
    pub sign: char,
    /// What it is, where there is room.
    pub words: String,
    /// How it looks.
    pub style: Style,
}

/// Shades the window.
pub fn shade(f: &mut Frame<'_>, axes: &Axes, window: Option<Range>, style: Style) {
    let Some((from, to)) = window else { return };
    let (from, to) = (axes.column(from), axes.column(to));
    let shaded = Rect {
        x: from,
        width: (to + 1).saturating_sub(from),
        ..axes.plot
    };
    f.buffer_mut()
        .set_style(shaded.intersection(axes.plot), style);
}

/// The current step, and events with a line down from their signs: in the row above the plot if it is free.
pub fn events(f: &mut Frame<'_>, axes: &Axes, area: Rect, events: &[Event], now: (f64, Style)) {
    let buffer = f.buffer_mut();
    upright(buffer, axes, axes.column(now.0), NOW, now.1);
    if axes.plot.y > area.y {
        let mut row = LinePlacer::new(usize::from(axes.plot.width));
        let at = |event: &Event| usize::from(axes.column(event.time) - axes.plot.x);
        let placed: Vec<&Event> = events
            .iter()
            .filter(|event| row.sign(at(event), event.sign, event.style))
            .collect();
        for event in placed {
            row.words_beside(at(event), &event.words, event.style);
        }
        let above = Rect {
            y: axes.plot.y - 1,
            height: 1,
            ..axes.plot
        };
        f.render_widget(Line::from_iter(row.spans()), above);
        for event in events {
            let column = axes.column(event.time);
            upright(f.buffer_mut(), axes, column, EVENT, event.style);
        }
        return;
    }
    // The most important one is drawn last.
    for event in events.iter().rev() {
        let column = axes.column(event.time);
        upright(buffer, axes, column, EVENT, event.style);
        if let Some(cell) = buffer.cell_mut(Position::new(column, axes.plot.y)) {
            cell.set_char(event.sign).set_style(event.style);
        }
    }
}

/// Brackets around the window, in the row of the events, or in the highest one of the plot.
pub fn window(f: &mut Frame<'_>, axes: &Axes, area: Rect, window: Option<Range>, style: Style) {
    let Some((from, to)) = window.filter(|_| axes.plot.height > 0) else {
        return;
    };
    let y = if axes.plot.y > area.y {
        axes.plot.y - 1
    } else {
        axes.plot.y
    };
    let buffer = f.buffer_mut();
    for (time, sign) in [(from, '['), (to, ']')] {
        let column = axes.column(time);
        if is_free(buffer, column, y) {
            buffer[(column, y)].set_char(sign).set_style(style);
        }
    }
}

/// A line from top to bottom where nothing is drawn.
fn upright(buffer: &mut Buffer, axes: &Axes, column: u16, sign: char, style: Style) {
    for y in axes.plot.top()..axes.plot.bottom() {
        if is_free(buffer, column, y) {
            buffer[(column, y)].set_char(sign).set_style(style);
        }
    }
}

/// Thresholds as lines with their names, or as arrows with their values where the axis does not reach them. Gives those
/// whose names found no room.
pub fn thresholds<'a>(f: &mut Frame<'_>, axes: &Axes, model: &'a Model) -> Vec<&'a Threshold> {
    let (measure, plot) = (model.plot.measure, axes.plot);
    let style = Style::new().fg(model.theme.dim);
    let all: Vec<&Threshold> = model.thresholds.for_measure(measure.id).collect();
    let buffer = f.buffer_mut();
    let mut unnamed = Vec::new();
    for threshold in &all {
        let Some(y) = axes.row(threshold.value) else {
            continue;
        };
        for x in plot.left()..plot.right() {
            if is_free(buffer, x, y) {
                buffer[(x, y)].set_char(THRESHOLD).set_style(style);
            }
        }
        if !write(buffer, plot, y, &words(threshold, measure.unit), style) {
            unnamed.push(*threshold);
        }
    }
    let (top, bottom) = (plot.top(), plot.bottom().saturating_sub(1));
    for threshold in all.iter().filter(|t| axes.row(t.value).is_none()) {
        let above = threshold.value > axes.values().1;
        let (sign, y) = if above { ("↑", top) } else { ("↓", bottom) };
        let words = format!("{sign} {}", words(threshold, measure.unit));
        if !write(buffer, plot, y, &words, style) {
            unnamed.push(*threshold);
        }
    }
    unnamed
}

/// A threshold with its value.
pub fn words(threshold: &Threshold, unit: &str) -> String {
    let own = if threshold.own { " (yours)" } else { "" };
    format!(
        "{} {}{own}",
        threshold.name,
        quantity(threshold.value, unit)
    )
}

/// Writes words into a row of the plot, on the left if that is free, as scenes end with what matters.
fn write(buffer: &mut Buffer, plot: Rect, y: u16, words: &str, style: Style) -> bool {
    let words = fit(words, usize::from(plot.width));
    let width = u16::try_from(words.width()).unwrap_or(u16::MAX);
    let last = plot.right().saturating_sub(width);
    let place = (plot.left()..=last).find(|&x| {
        let around = x.saturating_sub(1).max(plot.left())..(x + width + 1).min(plot.right());
        around.into_iter().all(|x| is_behind(buffer, x, y))
    });
    let Some(x) = place.filter(|_| width > 0) else {
        return false;
    };
    buffer.set_string(x, y, words, style.remove_modifier(Modifier::BOLD));
    true
}

fn sign_at(buffer: &Buffer, x: u16, y: u16) -> Option<char> {
    buffer.cell(Position::new(x, y))?.symbol().chars().next()
}

fn is_free(buffer: &Buffer, x: u16, y: u16) -> bool {
    matches!(sign_at(buffer, x, y), Some(' ' | '\u{2800}'))
}

/// Whether words may stand here: nothing is drawn, or a line that goes on beside them.
fn is_behind(buffer: &Buffer, x: u16, y: u16) -> bool {
    let sign = sign_at(buffer, x, y);
    is_free(buffer, x, y) || sign == Some(THRESHOLD)
}

//! A picker: an input line with the matching items below.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::model::{Model, Picker};
use crate::widgets::window;
use crate::widgets::words::{fit, pad, whole_parts};
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::Measure;

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
    let typed = typed(model, picker, rows.len(), width);
    let height = usize::from(area.height).saturating_sub(3 + WHOLE);
    let top = (picker.selected + 1).saturating_sub(height);
    let mut lines = vec![typed, Line::default()];
    let mut whole = None;
    // What stands at the right begins in one column, where all of it has room.
    let room = width.saturating_sub(4);
    let widest = |side: &dyn Fn(&(String, String)) -> usize| rows.iter().map(side).max();
    let names = widest(&|(left, _)| left.trim_end().width()).unwrap_or(0);
    let notes = widest(&|(_, right)| right.width()).unwrap_or(0);
    let column = if names + 2 + notes <= room { notes } else { 0 };
    for (i, (left, right)) in rows.iter().enumerate().skip(top).take(height) {
        let (full_left, full_right) = (left, right);
        let right = side_by_side(left.trim_end(), right, room);
        let right = pad(&right, column.max(right.width()));
        let left = pad(left, width.saturating_sub(right.width() + 4));
        let sign = if i == picker.selected { "▸ " } else { "  " };
        if i == picker.selected
            && (left.trim_end() != full_left.trim_end()
                || right.trim_end() != full_right.trim_end())
        {
            let sides = [full_left, full_right].map(|side| {
                let words = side.split_whitespace();
                words.collect::<Vec<_>>().join(" ")
            });
            whole = Some(whole_parts(sides.iter().map(String::as_str), usize::MAX));
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
        let words = if picker.text.is_empty() {
            "  none yet"
        } else {
            "  nothing matches"
        };
        lines.push(Line::styled(words, Style::new().fg(theme.dim)));
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

/// Columns that what stands at the right is cut to at least; with fewer it is left out.
const MIN_RIGHT_COLUMNS: usize = 12;

/// What stands at the right of a row: of its parts as many as fit whole beside the left one, which tells rows apart
/// and is cut last.
fn side_by_side(left: &str, right: &str, width: usize) -> String {
    let room = width
        .saturating_sub(left.width() + 1)
        // A word of it always has its place.
        .max(right.width().min(width / 4));
    if room < right.width().min(MIN_RIGHT_COLUMNS) {
        String::new()
    } else {
        whole_parts(right.split(" · "), room)
    }
}

/// A hint at the end of a list, in its last lines.
pub fn hint(frame: &mut Frame<'_>, area: Rect, model: &Model, words: &str) {
    let text = Paragraph::new(words.to_string()).wrap(Wrap { trim: true });
    let rows = text.line_count(area.width).clamp(1, WHOLE);
    let rows = u16::try_from(rows).unwrap_or(1).min(area.height);
    let below = Rect {
        y: area.bottom().saturating_sub(rows),
        height: rows,
        ..area
    };
    frame.render_widget(text.style(Style::new().fg(model.theme.dim)), below);
}

/// The typed line, and at its right the place of the selected row among those that match.
pub fn typed(model: &Model, picker: &Picker, rows: usize, width: usize) -> Line<'static> {
    let place = match rows {
        0 => String::new(),
        n => format!("{}/{n} ", picker.selected.min(n - 1) + 1),
    };
    let room = width.saturating_sub(place.width());
    let typed = format!("> {}▏", fit(&picker.text, room.saturating_sub(4)));
    Line::from(vec![
        Span::styled(pad(&typed, room), Style::new().fg(model.theme.accent)),
        Span::styled(place, Style::new().fg(model.theme.dim)),
    ])
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_at_the_right_are_whole_or_left_out() {
        assert_eq!(side_by_side("map", "svg", 40), "svg");
        let note = "LAB_KEY not set · $4 in, $20 out";
        assert_eq!(side_by_side("lab/small", note, 50), note);
        assert_eq!(side_by_side("lab/small", note, 30), "LAB_KEY not set");
        assert_eq!(side_by_side("lab/small", note, 24), "LAB_KEY not s…");
        assert_eq!(
            side_by_side("the name of a measure", "where it is from", 26),
            ""
        );
        // What is short stays.
        assert_eq!(
            side_by_side("a name that is cut because it is long", "svg", 30),
            "svg"
        );
    }
}

//! The ruler below the strips: seconds, cursor, and marks for events.

use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};

use super::LABEL;
use crate::tui::clock::PlayRange;
use crate::tui::loaded::Opened;
use crate::tui::model::Model;

/// A sign at a column.
type Mark = (usize, &'static str, Style);

/// The window, what is looped, the extreme of the plotted measure and answers that differ, the most important last.
pub fn marks(model: &Model, column: &dyn Fn(i64) -> usize) -> Vec<Mark> {
    let theme = &model.theme;
    let bold = |color| Style::new().fg(color).add_modifier(Modifier::BOLD);
    let mut marks = Vec::new();
    if let Some(window) = model.window() {
        marks.push((column(window.first()), "[", bold(theme.title)));
        marks.push((column(window.last()), "]", bold(theme.title)));
    }
    if let PlayRange::Part(first, last) = model.clock.lap() {
        marks.push((column(first), "(", bold(theme.accent)));
        marks.push((column(last), ")", bold(theme.accent)));
    }
    let measure = model.plot.measure.id;
    let series = model.plot.series.as_deref();
    if let Some((step, _)) = series.and_then(|series| series.most_dangerous(measure)) {
        marks.push((column(step), "m", bold(theme.picked)));
    }
    let differing = model.disagreements().into_iter();
    marks.extend(differing.map(|d| (column(d.step), "≠", bold(theme.disagree))));
    marks
}

/// A separate row for the marks, with a line along the window.
pub fn marks_row(model: &Model, width: usize, column: &dyn Fn(i64) -> usize) -> Line<'static> {
    let dim = Style::new().fg(model.theme.dim);
    let mut cells = vec![Span::styled(" ", dim); width];
    if let Some(window) = model.window() {
        let within = column(window.first())..=column(window.last());
        for at in within {
            if let Some(cell) = cells.get_mut(at) {
                *cell = Span::styled("─", dim);
            }
        }
    }
    for (at, sign, style) in marks(model, column) {
        if let Some(cell) = cells.get_mut(at) {
            *cell = Span::styled(sign, style);
        }
    }
    let mut line = Line::from(Span::styled(
        format!("{:<width$}", "marks", width = usize::from(LABEL)),
        dim,
    ));
    line.spans.extend(cells);
    line
}

/// Columns that a label and the gap behind it take.
const ROOM: f64 = 7.0;

/// Round seconds from `from` to `to`, no more of them than there is room for in `width` columns.
fn ticks(from: f64, to: f64, width: usize) -> impl Iterator<Item = f64> {
    let least = (to - from) * ROOM / width.max(1) as f64;
    let usual = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0];
    let every = usual.into_iter().find(|every| *every >= least);
    let every = every.unwrap_or_else(|| 200.0 * 10_f64.powf((least / 200.0).log10().ceil()));
    // Counted: a number of seconds that is large enough does not change by adding to it.
    let first = (from / every).ceil();
    let count = ((to + 1e-9) / every - first)
        .floor()
        .clamp(-1.0, width as f64);
    let counted = (0_u32..).map(f64::from).take_while(move |i| *i <= count);
    counted
        .map(move |i| (first + i) * every)
        .filter(|tick| tick.is_finite())
}

/// Seconds, the contact and the cursor; `marks` too, where they have no row of their own.
pub fn ruler(
    model: &Model,
    opened: &Opened,
    width: usize,
    column: &dyn Fn(i64) -> usize,
    marks: &[Mark],
) -> Line<'static> {
    let (first, last) = model.clock.range();
    let dt = opened.scenario.dt();
    let mut cells = vec![' '; width];
    let (from, to) = (first as f64 * dt, last as f64 * dt);
    let contact = opened
        .collision
        .as_ref()
        .and_then(|c| c.decisive_step)
        .map(column);
    let cursor = column(model.clock.step());
    let marked = |place: usize| {
        place == cursor || Some(place) == contact || marks.iter().any(|(at, ..)| *at == place)
    };
    for tick in ticks(from, to, width) {
        let at = column((tick / dt).round() as i64);
        let label = if tick.fract() == 0.0 {
            format!("{tick:.0}s")
        } else {
            format!("{tick:.1}s")
        };
        // Marks come first: a label steps aside, or is left out where it cannot.
        let free = |from: usize| {
            let to = from + label.len();
            // Two labels never touch.
            let before = from.checked_sub(1).and_then(|i| cells.get(i));
            let apart = before.is_none_or(|cell| *cell == ' ');
            to < width && apart && !(from..to).any(|i| marked(i) || cells[i] != ' ')
        };
        let beside = at.saturating_sub(label.len());
        let place = (at..=at + label.len()).find(|&from| free(from));
        if let Some(from) = place.or_else(|| Some(beside).filter(|&from| free(from))) {
            cells.splice(from..from + label.len(), label.chars());
        }
    }
    let mut line = Line::from(Span::raw(" ".repeat(usize::from(LABEL))));
    for (i, cell) in cells.into_iter().enumerate() {
        let dim = Style::new().fg(model.theme.dim);
        let danger = Style::new()
            .fg(model.theme.danger)
            .add_modifier(Modifier::BOLD);
        let span = match (Some(i) == contact, i == cursor) {
            (true, true) => Span::styled("X", danger.add_modifier(Modifier::REVERSED)),
            (true, false) => Span::styled("X", danger),
            (false, true) => Span::styled("▲", Style::new().fg(model.theme.accent)),
            _ => match marks.iter().rev().find(|(at, ..)| *at == i) {
                Some((_, sign, style)) => Span::styled(*sign, *style),
                None => Span::styled(cell.to_string(), dim),
            },
        };
        line.push_span(span);
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_have_room() {
        let of = |from, to, width| ticks(from, to, width).collect::<Vec<_>>();
        assert_eq!(of(0.0, 8.0, 40), [0.0, 2.0, 4.0, 6.0, 8.0]);
        assert_eq!(of(1.2, 3.9, 60), [1.5, 2.0, 2.5, 3.0, 3.5]);
        assert_eq!(of(-4.0, 5.0, 20), [0.0, 5.0]);
        assert_eq!(of(0.0, 0.0, 40), [0.0]);
        assert_eq!(of(0.1, 0.2, 40), [0.0; 0]);
        let long = of(0.0, 5000.0, 40);
        assert_eq!(long, [0.0, 2000.0, 4000.0]);
    }

    #[test]
    fn ticks_end_whatever_the_seconds() {
        for seconds in [
            1e9,
            9e15,
            1e18,
            9.2e27,
            1e308,
            f64::MAX,
            f64::INFINITY,
            f64::NAN,
        ] {
            for from in [-seconds, 0.0, seconds / 2.0, seconds - 1.0, seconds] {
                for width in [0, 1, 40, 500] {
                    let count = ticks(from, seconds, width).count();
                    assert!(
                        count <= width + 1,
                        "{count} from {from} to {seconds} in {width}"
                    );
                }
            }
        }
    }
}

//! The ruler below the strips: seconds, cursor, and marks for events. Nothing stands over anything else.

use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};

use super::LABEL;
use crate::clock::PlayRange;
use crate::loaded::Opened;
use crate::model::Model;
use crate::widgets::line_placer::LinePlacer;
use nearmiss_base::system::pad_end;
use nearmiss_scene::metrics::Danger;

/// A sign at a column, and what it means where there is room for words.
pub struct Mark {
    at: usize,
    sign: char,
    words: String,
    style: Style,
}

/// The contact, answers that differ, the second map's moment, the moment that matters, what is looped and the
/// window: the most important first.
pub fn marks(model: &Model, opened: &Opened, column: &dyn Fn(i64) -> usize) -> Vec<Mark> {
    let theme = &model.theme;
    let bold = |color| Style::new().fg(color).add_modifier(Modifier::BOLD);
    let mark = |step: i64, sign, words: &str, color| Mark {
        at: column(step),
        sign,
        words: words.into(),
        style: bold(color),
    };
    let mut marks = Vec::new();
    let contact = opened.contact();
    marks.extend(contact.map(|contact| mark(contact.step, 'X', contact.name(), theme.danger)));
    let differing = model.disagreements().into_iter();
    marks.extend(differing.map(|d| mark(d.step, '≠', "", theme.disagree)));
    let second = model
        .second_moment()
        .filter(|then| then.step != model.clock.step());
    marks.extend(second.map(|then| mark(then.step, '◆', "second map", theme.accent)));
    let worst = opened.worst_untouched();
    marks.extend(worst.map(|moment| mark(moment.step, '▼', "most severe", theme.text)));
    if let PlayRange::Part(first, last) = model.clock.lap() {
        marks.push(mark(first, '(', "", theme.accent));
        marks.push(mark(last, ')', "", theme.accent));
    }
    if let Some(window) = model.window() {
        marks.push(mark(window.first(), '[', "", theme.title));
        marks.push(mark(window.last(), ']', "", theme.title));
    }
    marks
}

/// The most dangerous value of a measure, in a word.
pub fn extreme(danger: Danger) -> &'static str {
    match danger {
        Danger::High => "highest",
        Danger::Low | Danger::Neutral => "lowest",
    }
}

/// A row of their own for the marks, in words where there is room, with a line along the window.
pub fn marks_row(
    model: &Model,
    marks: &[Mark],
    width: usize,
    column: &dyn Fn(i64) -> usize,
) -> Line<'static> {
    let dim = Style::new().fg(model.theme.dim);
    let mut row = LinePlacer::new(width);
    let placed: Vec<&Mark> = marks
        .iter()
        .filter(|mark| row.sign(mark.at, mark.sign, mark.style))
        .collect();
    for mark in placed {
        row.words_beside(mark.at, &mark.words, mark.style);
    }
    if let Some(window) = model.window() {
        let (first, last) = (column(window.first()), column(window.last()));
        let words = "window";
        // Inside it, or nowhere.
        let most = (last + 1).saturating_sub(first + words.len() + 2);
        row.words((first + 2..).take(most.saturating_sub(1)), words, dim);
        row.fill(first..last + 1, '─', dim);
    }
    let mut line = Line::from(Span::styled(pad_end("marks", usize::from(LABEL)), dim));
    line.spans.extend(row.spans());
    line
}

/// Columns that a label and the gap behind it take.
const ROOM: f64 = 7.0;

/// Round seconds from `from` to `to`, no more of them than there is room for in `width` columns.
fn ticks(from: f64, to: f64, width: usize) -> impl Iterator<Item = f64> {
    let least = (to - from) * ROOM / width.max(1) as f64;
    let usual = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0];
    let every = usual
        .into_iter()
        .find(|every| *every >= least)
        .unwrap_or_else(|| 200.0 * 10_f64.powf((least / 200.0).log10().ceil()));
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

/// Seconds and the cursor; `marks` too, where they have no row of their own.
pub fn ruler(
    model: &Model,
    opened: &Opened,
    width: usize,
    column: &dyn Fn(i64) -> usize,
    marks: &[Mark],
) -> Line<'static> {
    let (first, last) = model.clock.range();
    let dt = opened.scenario.dt();
    let (from, to) = (first as f64 * dt, last as f64 * dt);
    let theme = &model.theme;
    let cursor = column(model.clock.step());
    let mut row = LinePlacer::new(width);
    // The cursor turns the most important mark under it around.
    match marks.iter().find(|mark| mark.at == cursor) {
        Some(mark) => {
            let style = mark.style.add_modifier(Modifier::REVERSED);
            row.sign(cursor, mark.sign, style)
        }
        None => row.sign(cursor, '▲', Style::new().fg(theme.accent)),
    };
    for mark in marks {
        row.sign(mark.at, mark.sign, mark.style);
    }
    for tick in ticks(from, to, width) {
        let label = if tick.fract() == 0.0 {
            format!("{tick:.0}s")
        } else {
            format!("{tick:.1}s")
        };
        let at = column((tick / dt).round() as i64);
        // A label steps aside by its length and a gap, or is left out.
        let behind = at..=at + label.len() + 2;
        let before = at.checked_sub(label.len() + 1);
        row.words(behind.chain(before), &label, Style::new().fg(theme.dim));
    }
    let mut line = Line::from(" ".repeat(usize::from(LABEL)));
    line.spans.extend(row.spans());
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

//! A table row whose cells wrap instead of being cut.

use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::words::pad;
use nearmiss_scene::description::visible;

/// Less room than this makes a note hard to read: it goes below its row instead.
const LEAST: usize = 40;

/// Columns before a note that stands below its row.
const INDENT: usize = 4;

/// A cell: what it says, its columns, its style.
pub type Cell = (String, usize, Style);

/// Lines of cells side by side and a note behind them, which goes below where it has little room there.
#[must_use]
pub fn lines(cells: &[Cell], note: (&str, Style), width: usize) -> Vec<Line<'static>> {
    let used: usize = cells.iter().map(|(_, columns, _)| columns).sum();
    let room = width.saturating_sub(used);
    let words = visible(note.0);
    let beside = wrapped(&words, room);
    let fits = beside.len() <= 1 || room >= LEAST;
    let mut columns: Vec<(Vec<String>, usize, Style)> = cells
        .iter()
        // A column stays free before the next cell.
        .map(|(words, columns, style)| {
            (wrapped(words, columns.saturating_sub(1)), *columns, *style)
        })
        .collect();
    if fits {
        columns.push((beside, room, note.1));
    }
    let rows = columns.iter().map(|(lines, ..)| lines.len()).max();
    let line = |row: usize| {
        let spans = columns.iter().map(|(lines, columns, style)| {
            let words = lines.get(row).map_or("", String::as_str);
            Span::styled(pad(words, *columns), *style)
        });
        Line::from_iter(spans)
    };
    let mut all: Vec<Line<'static>> = (0..rows.unwrap_or(0)).map(line).collect();
    if !fits {
        let below = wrapped(&words, width.saturating_sub(INDENT));
        all.extend(below.into_iter().map(|words| {
            let indent = Span::raw(" ".repeat(INDENT));
            Line::from(vec![indent, Span::styled(words, note.1)])
        }));
    }
    all
}

/// Words on lines of so many columns; an indent stays in front of every line.
fn wrapped(words: &str, width: usize) -> Vec<String> {
    let words = visible(words);
    let indent = &words[..words.len() - words.trim_start().len()];
    let options = textwrap::Options::new(width.max(8))
        .subsequent_indent(indent)
        .break_words(true);
    let lines = textwrap::wrap(&words, options);
    lines.into_iter().map(|line| line.into_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(cells: &[(&str, usize)], note: &str, width: usize) -> Vec<String> {
        let cells: Vec<Cell> = cells
            .iter()
            .map(|(words, columns)| ((*words).to_string(), *columns, Style::new()))
            .collect();
        let lines = lines(&cells, (note, Style::new()), width);
        let text = |line: &Line<'_>| line.to_string().trim_end().to_string();
        lines.iter().map(text).collect()
    }

    #[test]
    fn notes_stand_beside_or_below() {
        let cells = [("  ttc", 10), ("1 s", 6)];
        assert_eq!(
            texts(&cells, "Hayward 1972", 30),
            ["  ttc     1 s   Hayward 1972"]
        );
        assert_eq!(
            texts(&cells, "Hayward 1972, bodies in the plane", 30),
            [
                "  ttc     1 s",
                "    Hayward 1972, bodies in",
                "    the plane"
            ]
        );
        let long = "a note of very many words that is much longer than its column is wide";
        assert_eq!(
            texts(&cells, long, 60),
            [
                "  ttc     1 s   a note of very many words that is much",
                "                longer than its column is wide",
            ]
        );
        assert_eq!(
            texts(&[("! a long name", 10), ("1 s", 6)], "", 40),
            ["! a long  1 s", "name"]
        );
    }
}

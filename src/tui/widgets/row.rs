//! Rows of cells, lines of text, and what of them is in sight.

use nearmiss_scene::description::visible;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Paragraph, Scrollbar, ScrollbarOrientation, ScrollbarState, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::model::{Extent, Model, Pane};
use crate::theme::Theme;
use crate::widgets::long_text::{MarkedClaims, Reading, height};
use crate::widgets::words::pad;
use crate::widgets::{claimed, unbroken};

/// Less room than this makes a note hard to read: it goes below its row instead.
const MIN_NOTE_COLUMNS: usize = 40;

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
    let fits = beside.len() <= 1 || room >= MIN_NOTE_COLUMNS;
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
    unbroken::wrap(&words, options)
}

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
    let paragraph = Paragraph::new(unbroken::text(text)).wrap(Wrap { trim: false });
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
            PageSection::Line(line) => {
                *line = unbroken::line(std::mem::take(line));
                height(line.clone(), inner.width)
            }
            PageSection::Text(reading, text, marks) => {
                reading.follow(text, marks, inner.width, theme);
                if pane == Pane::Reasoning {
                    model.drawn.set_before_text(lines);
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
    claimed::render(frame, inner, seen, above);
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

/// Columns of the window at most, its borders included.
const COLUMNS: u16 = 54;

/// Columns before a value.
const LINE_INDENT: usize = 11;

/// Columns before a number with a bar.
const NUMBERS: usize = 18;

/// Columns of the longest bar.
const BAR: usize = 12;

/// Columns of the window: on a narrow screen the map has the left half.
#[must_use]
pub fn width(screen: Rect) -> u16 {
    COLUMNS.min(screen.width * 48 / 100).min(screen.width)
}

/// Names with values, under titles.
pub struct Lines {
    /// The lines so far.
    pub text: Text<'static>,
    word: Style,
    title: Style,
    /// Columns that they may take.
    pub width: usize,
}

impl Lines {
    /// None yet, in so many columns.
    pub fn new(theme: &Theme, width: usize) -> Self {
        Self {
            text: Text::default(),
            word: Style::new().fg(theme.accent),
            title: Style::new().fg(theme.ego).add_modifier(Modifier::BOLD),
            width,
        }
    }

    /// A title, with an empty line before it.
    pub fn title(&mut self, words: &str) {
        if !self.text.lines.is_empty() {
            self.text.push_line("");
        }
        self.text
            .push_line(Line::styled(words.to_string(), self.title));
    }

    /// Adds a name with its value.
    pub fn say(&mut self, name: &str, said: &str) {
        self.say_in(name, said, Style::new());
    }

    /// The same in a style.
    pub fn say_in(&mut self, name: &str, said: &str, style: Style) {
        // A long name has a blank after it, too.
        let indent = LINE_INDENT.max(name.width() + 1);
        let room = self.width.saturating_sub(indent).max(8);
        let mut lines = unbroken::wrap(said, room).into_iter();
        self.text.push_line(Line::from(vec![
            Span::styled(pad(name, indent), self.word),
            Span::styled(lines.next().unwrap_or_default(), style),
        ]));
        for more in lines {
            let line = format!("{}{more}", pad("", indent));
            self.text.push_line(Line::styled(line, style));
        }
    }

    /// A number, and a bar for its share of the largest one.
    pub fn bar(&mut self, name: &str, number: &str, share: f64) {
        let cells = (share * BAR as f64).round().clamp(0.0, BAR as f64) as usize;
        let room = self.width.saturating_sub(NUMBERS + 9);
        let bar = "━".repeat(cells.min(room));
        self.text.push_line(Line::from(vec![
            Span::styled(pad(&format!("  {name}"), NUMBERS), self.word),
            Span::raw(format!("{number:>8} ")),
            Span::styled(bar, self.word),
        ]));
    }

    /// Words without a name.
    pub fn plain(&mut self, words: &str) {
        let wrapped = unbroken::wrap(words, self.width.max(8));
        self.text.lines.extend(wrapped.into_iter().map(Line::raw));
    }
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

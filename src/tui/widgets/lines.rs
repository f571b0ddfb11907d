//! Lines of a side window: names with values, under titles.

use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};

use unicode_width::UnicodeWidthStr;

use super::words::pad;
use crate::theme::Theme;

/// Columns of the window at most, its borders included.
const COLUMNS: u16 = 54;

/// Columns before a value.
const INDENT: usize = 11;

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
        let indent = INDENT.max(name.width() + 1);
        let room = self.width.saturating_sub(indent).max(8);
        let mut lines = textwrap::wrap(said, room).into_iter();
        self.text.push_line(Line::from(vec![
            Span::styled(pad(name, indent), self.word),
            Span::styled(lines.next().unwrap_or_default().into_owned(), style),
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
        let wrapped = textwrap::wrap(words, self.width.max(8));
        let lines = wrapped.into_iter().map(|l| Line::raw(l.into_owned()));
        self.text.lines.extend(lines);
    }
}

//! Everything about the picked obstacle at the cursor, at the right, so that the map stays in sight.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};

use crate::text::visible;
use crate::tui::model::{Detail, Model};
use crate::tui::widgets::words::pad;

/// Columns of the window at most, its borders included.
const COLUMNS: u16 = 62;

/// Columns before what is said about a word.
const INDENT: usize = 17;
/// The same in a narrow window.
const NARROW: usize = 13;

/// Columns of the window: on a narrow screen the map has the left half.
pub fn width(screen: Rect) -> u16 {
    COLUMNS.min(screen.width * 46 / 100).min(screen.width)
}

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model, scroll: usize) {
    let width = width(screen);
    let area = Rect {
        x: screen.right() - width,
        y: screen.y + 1.min(screen.height),
        width,
        height: screen.height.saturating_sub(2),
    };
    let inner = super::window_at(frame, area, model, "details · y copies");
    let text = text(model, usize::from(inner.width));
    super::text_in(frame, inner, text, scroll);
}

fn text(model: &Model, width: usize) -> Text<'static> {
    let theme = &model.theme;
    let Some(details) = model.details() else {
        let words = "nobody is picked: click an obstacle";
        return Text::styled(words, Style::new().fg(theme.dim));
    };
    let title = Style::new().fg(theme.picked).add_modifier(Modifier::BOLD);
    let word = Style::new().fg(theme.accent);
    // The longest word keeps a blank behind it.
    let indent = if width < 50 { NARROW } else { INDENT };
    let mut text = Text::default();
    for detail in details {
        match detail {
            Detail::Title(words) => {
                if !text.lines.is_empty() {
                    text.push_line("");
                }
                text.push_line(Line::styled(visible(&words).into_owned(), title));
            }
            Detail::Said(name, said) => {
                let said = visible(&said).into_owned();
                let room = width.saturating_sub(indent).max(10);
                let mut lines = textwrap::wrap(&said, room).into_iter();
                text.push_line(Line::from(vec![
                    Span::styled(pad(name, indent), word),
                    Span::raw(lines.next().unwrap_or_default().into_owned()),
                ]));
                for more in lines {
                    text.push_line(format!("{:indent$}{more}", ""));
                }
            }
        }
    }
    text
}

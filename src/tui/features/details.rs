//! Details of the picked obstacle at the cursor, in a panel at the right that keeps the map in view.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};

use crate::action::Action;
use crate::features::{Screen, Step, moves_scene};
use crate::message::Effect;
use crate::model::{Detail, Model, as_text};
use crate::widgets::hints::{self, Hint};
use crate::widgets::words::pad;
use crate::widgets::{unbroken, window};
use nearmiss_scene::description::visible;

/// Columns of the window at most, its borders included.
const COLUMNS: u16 = 62;

/// Columns before a value.
const INDENT: usize = 17;
/// The same in a narrow window.
const NARROW: usize = 13;

/// Details of the picked obstacle.
#[derive(Debug, Default)]
pub struct DetailsScreen {
    scroll: usize,
}

/// Opens the window, where an obstacle is picked.
pub fn open(model: &mut Model) {
    if model.picked.is_none() {
        return model.say("pick an obstacle first");
    }
    model.screens.open(DetailsScreen::default());
}

impl Screen for DetailsScreen {
    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        match action {
            Action::Copy => {
                let Some(details) = model.details() else {
                    return Step::stay();
                };
                let text = as_text(&details);
                model.say(format!("{} characters copied", text.chars().count()));
                Step::Stay(vec![Effect::Copy(text)])
            }
            Action::Details => Step::close(),
            Action::Play | Action::NextPaths | Action::TakeTape => Step::Perform(action),
            _ if moves_scene(action) => Step::Perform(action),
            _ => Step::Ignored,
        }
    }

    fn scroll_mut(&mut self) -> Option<&mut usize> {
        Some(&mut self.scroll)
    }

    // On a narrow screen the map has the left half.
    fn columns_at_right(&self, screen: Rect) -> Option<u16> {
        Some(COLUMNS.min(screen.width * 46 / 100).min(screen.width))
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let width = self.columns_at_right(screen).unwrap_or(screen.width);
        let text = text(model, usize::from(width.saturating_sub(2)));
        window::at_right(frame, screen, model, "details", text, width, self.scroll);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        let mut hints = vec![hints::steps(model, "step"), hints::scroll(model)];
        hints.extend(hints::hint_of(model, Action::Copy));
        hints.push(hints::close(model));
        hints.extend(hints::hint_of(model, Action::Play));
        hints.push(hints::page(model));
        hints
    }
}

fn text(model: &Model, width: usize) -> Text<'static> {
    let theme = &model.theme;
    let Some(details) = model.details() else {
        let words = "no obstacle is picked: click one";
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
                let mut lines = unbroken::wrap(&said, room).into_iter();
                text.push_line(Line::from(vec![
                    Span::styled(pad(name, indent), word),
                    Span::raw(lines.next().unwrap_or_default()),
                ]));
                for more in lines {
                    text.push_line(format!("{}{more}", pad("", indent)));
                }
            }
        }
    }
    text
}

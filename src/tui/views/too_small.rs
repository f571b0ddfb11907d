//! Shown when the terminal is too small.

use ratatui::Frame;
use ratatui::layout::{Alignment, Constraint, Flex, Layout};
use ratatui::text::{Line, Text};
use ratatui::widgets::{Paragraph, Wrap};

use crate::action::Action;
use crate::layout::SMALLEST;
use crate::model::Model;

pub fn draw(frame: &mut Frame<'_>, model: &Model) {
    let area = frame.area();
    let (columns, rows) = SMALLEST;
    let text = Text::from(vec![
        Line::from(format!(
            "Terminal too small: this is {}×{}, nearmiss needs {columns}×{rows}",
            area.width, area.height
        )),
        Line::from(format!("{} quits", model.look.key(Action::Quit))),
    ]);
    let [middle] = Layout::vertical([Constraint::Length(4)])
        .flex(Flex::Center)
        .areas(area);
    let words = Paragraph::new(text)
        .alignment(Alignment::Center)
        .wrap(Wrap { trim: true });
    frame.render_widget(words.style(model.theme.base()), middle);
}

//! The layers of the map, to be switched while the map is seen beside them.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Text};
use ratatui::widgets::Paragraph;

use crate::tui::model::{Layers, Model};
use crate::tui::widgets::words::pad;

/// Columns of the window, its borders included.
const COLUMNS: u16 = 46;

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model, selected: usize) {
    let width = COLUMNS.min(screen.width);
    let height = (Layers::COUNT as u16 + 2).min(screen.height);
    let area = Rect {
        x: screen.right() - width,
        y: screen.y + 1.min(screen.height - height),
        width,
        height,
    };
    let inner = super::window_at(frame, area, model, "layers of the map");
    let columns = usize::from(inner.width);
    let rows = model.map.layers.rows();
    let rows = rows.iter().enumerate().map(|(row, (name, state))| {
        let style = if row == selected {
            model.theme.selected()
        } else {
            Style::new()
        };
        // A sign says it without words, too.
        let sign = if *state == "off" { "[ ]" } else { "[x]" };
        let more = if matches!(*state, "on" | "off") {
            String::new()
        } else {
            format!(": {state}")
        };
        Line::styled(pad(&format!("{sign} {name}{more}"), columns), style)
    });
    frame.render_widget(Paragraph::new(Text::from_iter(rows)), inner);
}

//! Toggles for the map layers, beside the map.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Text};
use ratatui::widgets::Paragraph;

use super::{Screen, Step};
use crate::action::{Action, Scope};
use crate::model::{Layers, Model};
use crate::widgets::hints::{self, Hint};
use crate::widgets::window;
use crate::widgets::words::pad;

/// Columns of the window, its borders included.
const COLUMNS: u16 = 46;

/// The layers of the map.
#[derive(Debug, Default)]
pub struct LayersScreen {
    selected: usize,
}

impl Screen for LayersScreen {
    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        match action {
            Action::Up => self.selected = self.selected.saturating_sub(1),
            Action::Down => self.selected = (self.selected + 1).min(Layers::COUNT - 1),
            Action::Accept => model.map.layers.switch(self.selected),
            _ => return Step::Ignored,
        }
        Step::stay()
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let width = COLUMNS.min(screen.width);
        let height = (Layers::COUNT as u16 + 2).min(screen.height);
        let area = Rect {
            x: screen.right() - width,
            y: screen.y + 1.min(screen.height - height),
            width,
            height,
        };
        window::margin(frame, screen, area, model);
        let inner = window::window_at(frame, area, model, "layers of the map");
        let columns = usize::from(inner.width);
        let layers = model.map.layers.rows();
        let rows = layers.iter().enumerate().map(|(row, (name, state))| {
            let style = if row == self.selected {
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

    fn hints(&self, model: &Model) -> Vec<Hint> {
        let keys = [Action::Up, Action::Down];
        let select = hints::pair(model, Scope::Window, keys, "select");
        let accept = (model.look.key(Action::Accept), "switch".to_string());
        vec![select, accept, hints::close(model)]
    }
}

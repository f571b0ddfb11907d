//! The time at the cursor, in words.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::Text;

use crate::features::Screen;
use crate::model::Model;
use crate::widgets::hints::{self, Hint};
use crate::widgets::window;

/// The time at the cursor.
#[derive(Debug, Default)]
pub struct ClockScreen {
    scroll: usize,
}

impl Screen for ClockScreen {
    fn scroll_mut(&mut self) -> Option<&mut usize> {
        Some(&mut self.scroll)
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let text = Text::raw(format!("step {}", model.clock.step()));
        window::scrolled(frame, screen, model, "clock", text, self.scroll);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        vec![hints::scroll(model), hints::close(model)]
    }
}

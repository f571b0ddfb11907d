//! The time at the cursor, in words.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::Text;

use super::Screen;
use crate::tui::model::Model;
use crate::tui::widgets::hints::{self, Hint};
use crate::tui::widgets::window;

/// The time at the cursor.
#[derive(Debug, Default)]
pub struct MomentScreen {
    scroll: usize,
}

impl Screen for MomentScreen {
    fn scroll_mut(&mut self) -> Option<&mut usize> {
        Some(&mut self.scroll)
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let text = Text::raw(format!("step {}", model.clock.step()));
        window::scrolled(frame, screen, model, "moment", text, self.scroll);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        vec![hints::scroll(model)]
    }
}

//! What lies over the main screen: help, palette, list of models.

mod help;
mod picker;

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::widgets::{Block, BorderType, Clear};

use super::model::{Model, Overlay};

/// Draws what is open, the top last.
pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
    for overlay in &model.overlays {
        match overlay {
            Overlay::Help { scroll } => help::draw(frame, screen, model, *scroll),
            Overlay::Palette(typed) => picker::palette(frame, screen, model, typed),
            Overlay::Models { picker: typed, ask } => {
                picker::models(frame, screen, model, typed, *ask);
            }
        }
    }
}

/// A window in the middle; gives the area inside.
fn window(
    frame: &mut Frame<'_>,
    screen: Rect,
    model: &Model,
    title: &str,
    size: (u16, u16),
) -> Rect {
    let width = size.0.min(screen.width.saturating_sub(4));
    let height = size.1.min(screen.height.saturating_sub(2));
    let area = Rect {
        x: screen.x + (screen.width - width) / 2,
        y: screen.y + (screen.height - height) / 3,
        width,
        height,
    };
    let block = Block::bordered()
        .border_type(BorderType::Thick)
        .border_style(Style::new().fg(model.theme.border_focused))
        .title(format!(" {title} "))
        .style(model.theme.base());
    let inner = block.inner(area);
    frame.render_widget(Clear, area);
    frame.render_widget(block, area);
    inner
}

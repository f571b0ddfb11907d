//! Messages, over the lower right corner.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::Text;
use ratatui::widgets::{Block, Clear, Paragraph, Wrap};

use crate::text::visible;
use crate::tui::model::Model;

/// Messages shown at once.
const MOST: usize = 3;

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
    let mut bottom = screen.bottom().saturating_sub(1);
    for toast in model.toasts.iter().rev().take(MOST) {
        let color = if toast.bad {
            model.theme.danger
        } else {
            model.theme.accent
        };
        let title = if toast.bad {
            " something is wrong "
        } else {
            ""
        };
        let text = visible(&toast.text);
        let wanted = u16::try_from(text.chars().count())
            .unwrap_or(u16::MAX)
            .saturating_add(4);
        let width = wanted.clamp(24, (screen.width * 2 / 3).max(24));
        let words =
            Paragraph::new(Text::styled(text, model.theme.base())).wrap(Wrap { trim: true });
        let lines = words.line_count(width.saturating_sub(4));
        let height = u16::try_from(lines)
            .unwrap_or(u16::MAX)
            .saturating_add(2)
            .min(screen.height / 2);
        if bottom < height + 1 {
            break;
        }
        let area = Rect::new(screen.right() - width - 1, bottom - height, width, height);
        let block = Block::bordered()
            .border_style(Style::new().fg(color))
            .title(title)
            .padding(ratatui::widgets::Padding::horizontal(1));
        frame.render_widget(Clear, area);
        frame.render_widget(words.block(block), area);
        bottom -= height;
    }
}

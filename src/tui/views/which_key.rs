//! Which-key: possible continuations of a started chord, in a box above the footer.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, BorderType, Clear, Paragraph};
use unicode_width::UnicodeWidthStr;

use crate::tui::keymap::Chord;
use crate::tui::model::Model;
use crate::tui::widgets::words::{fit, pad};

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
    let (look, theme) = (&model.look, &model.theme);
    if look.pending.is_empty() {
        return;
    }
    let following = look.keymap.following(&look.pending, model.scope());
    let rows = following.iter().map(|f| {
        let doc = f.doc.unwrap_or("… more keys follow");
        (f.key.to_string(), doc)
    });
    let rows: Vec<(String, &str)> = rows.collect();
    let keys = rows.iter().map(|(key, _)| key.width()).max().unwrap_or(0);
    let docs = rows.iter().map(|(_, doc)| doc.width()).max().unwrap_or(0);
    let title = format!(" {} … ", Chord(look.pending.clone()));
    let width = (keys + docs + 6).max(title.width() + 2);
    let width = u16::try_from(width).unwrap_or(u16::MAX);
    let width = width.min(screen.width.saturating_sub(2));
    let height = u16::try_from(rows.len() + 2).unwrap_or(u16::MAX);
    let height = height.min(screen.height.saturating_sub(2));
    let area = Rect {
        x: screen.right() - width - 1,
        y: screen.bottom().saturating_sub(height + 1),
        width,
        height,
    };
    let bold = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
    let block = Block::bordered()
        .border_type(BorderType::Thick)
        .border_style(Style::new().fg(theme.border_focused))
        .title(Span::styled(title, bold))
        .style(theme.base());
    let inner = block.inner(area);
    let room = usize::from(inner.width).saturating_sub(keys + 4);
    let lines = rows.iter().map(|(key, doc)| {
        Line::from(vec![
            Span::styled(format!(" {}  ", pad(key, keys)), bold),
            Span::raw(fit(doc, room)),
        ])
    });
    frame.render_widget(Clear, area);
    frame.render_widget(block, area);
    frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()), inner);
}

//! First-run hint: three keys to a first verdict, in a box below the reasoning, or in its border where that is low.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Paragraph};
use unicode_width::UnicodeWidthStr;

use crate::description::visible;
use crate::judge;
use crate::tui::action::Action;
use crate::tui::layout::ScreenAreas;
use crate::tui::model::{Model, Pane, ShownAnswer};
use crate::tui::widgets::words::{fit, pad};

pub fn draw(frame: &mut Frame<'_>, parts: &ScreenAreas, model: &Model) {
    let reasoning = parts.panes.iter().find(|(p, _)| *p == Pane::Reasoning);
    // An answer the user asked for is not covered; after making a variant, the first verdict is past.
    let free = model.answers.shown == ShownAnswer::Reference && model.variant().is_none();
    let shown = model.recall.hint && free;
    let (true, Some((_, pane))) = (shown, reasoning) else {
        return;
    };
    let asks = match model.model.as_str() {
        judge::MODEL => "ask the built-in judge".to_string(),
        other => format!("ask {}", visible(other)),
    };
    let rows = [
        (Action::Down, "open the next scenario".to_string(), "next"),
        (
            Action::CollisionStep,
            "go to its worst moment".into(),
            "worst moment",
        ),
        (Action::Run, asks, "ask"),
    ];
    let rows = rows.map(|(action, words, short)| (model.look.key(action), words, short));
    if pane.height < LOWEST {
        return in_border(frame, *pane, model, &rows);
    }
    let rows = rows.map(|(key, words, _)| (key, words));
    let keys = rows.iter().map(|(key, _)| key.width()).max().unwrap_or(0);
    let height = (rows.len() as u16 + 2).min(pane.height);
    let area = Rect {
        y: pane.bottom() - height,
        height,
        ..*pane
    };
    let theme = &model.theme;
    let bold = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
    let block = Block::bordered()
        .border_style(Style::new().fg(theme.accent))
        .title(Span::styled(" three keys to a first verdict ", bold))
        .style(theme.base());
    let room = usize::from(area.width).saturating_sub(keys + 5);
    let lines = rows.iter().map(|(key, words)| {
        Line::from(vec![
            Span::styled(format!(" {}  ", pad(key, keys)), bold),
            Span::raw(fit(words, room)),
        ])
    });
    let text = Paragraph::new(lines.collect::<Vec<_>>()).block(block);
    frame.render_widget(Clear, area);
    frame.render_widget(text, area);
}

/// Rows of the pane from which the box leaves enough of its text in sight.
const LOWEST: u16 = 10;

/// The same in the lower border of the pane.
fn in_border(
    frame: &mut Frame<'_>,
    pane: Rect,
    model: &Model,
    rows: &[(String, String, &'static str)],
) {
    let theme = &model.theme;
    let bold = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
    let mut line = Line::default();
    for (key, _, short) in rows {
        line.push_span(Span::styled(format!(" {key}"), bold));
        line.push_span(Span::styled(
            format!(" {short} "),
            Style::new().fg(theme.dim),
        ));
    }
    let area = Rect {
        x: pane.x + 1,
        y: pane.bottom().saturating_sub(1),
        width: pane
            .width
            .saturating_sub(2)
            .min(u16::try_from(line.width()).unwrap_or(u16::MAX)),
        height: 1,
    };
    frame.render_widget(line, area);
}

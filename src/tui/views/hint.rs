//! First-run hint: three keys to a first verdict, in a box below the reasoning, or in its border where that is low.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Paragraph};
use unicode_width::UnicodeWidthStr;

use crate::action::Action;
use crate::layout::ScreenAreas;
use crate::model::{Model, Pane, ShownAnswer};
use crate::widgets::words::{fit, pad};
use nearmiss_scene::description::visible;
use nearmiss_scene::judge;

/// Takes the rows of the box off the pane of the reasoning, so that it has a frame of its own.
pub fn make_room(parts: &mut ScreenAreas, model: &Model) -> Option<Rect> {
    let mut panes = parts.panes.iter_mut();
    let (_, pane) = panes.find(|(pane, _)| *pane == Pane::Reasoning)?;
    if !is_shown(model) || pane.height < LOWEST {
        return None;
    }
    pane.height -= HEIGHT;
    Some(Rect {
        y: pane.bottom(),
        height: HEIGHT,
        ..*pane
    })
}

/// An answer the user asked for leaves no room; after making a variant, the first verdict is past.
fn is_shown(model: &Model) -> bool {
    let free = model.answers.shown == ShownAnswer::Reference && model.variant().is_none();
    model.recall.hint && free
}

/// Draws the hint in the area made for it, or in the border of the reasoning.
pub fn draw(frame: &mut Frame<'_>, parts: &ScreenAreas, area: Option<Rect>, model: &Model) {
    let reasoning = parts.panes.iter().find(|(p, _)| *p == Pane::Reasoning);
    let (true, Some((_, pane))) = (is_shown(model), reasoning) else {
        return;
    };
    let run = model.look.key(Action::Run);
    let asks = match model.model.as_str() {
        judge::MODEL => (
            Action::ChooseModel,
            format!("choose a model, {run} asks it"),
            "model",
        ),
        other => (Action::Run, format!("ask {}", visible(other)), "ask"),
    };
    let rows = [
        (Action::Down, "open the next scenario".to_string(), "next"),
        (
            Action::CollisionStep,
            "go to its worst moment".into(),
            "worst moment",
        ),
        asks,
    ]
    .map(|(action, words, short)| (model.look.key(action), words, short));
    let Some(area) = area else {
        return in_border(frame, *pane, model, &rows);
    };
    let rows = rows.map(|(key, words, _)| (key, words));
    let keys = rows.iter().map(|(key, _)| key.width()).max().unwrap_or(0);
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

/// Rows of the box: three keys and its frame.
const HEIGHT: u16 = 5;

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

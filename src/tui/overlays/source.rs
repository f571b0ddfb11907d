//! The source of the scenario, read-only: only what is seen is highlighted.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use unicode_width::UnicodeWidthStr;

use crate::text::visible;
use crate::tui::model::Model;
use crate::tui::widgets::highlight::{Language, lines};
use crate::tui::widgets::words::{fit_end, thousands};

/// Rows before the first one that are highlighted too, for what begins there.
const BEFORE: usize = 20;

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model, scroll: usize) {
    let Some((_, source)) = &model.source else {
        return;
    };
    let keys = "↑↓ PgUp PgDn scroll · Esc closes";
    let room = usize::from(screen.width).saturating_sub(keys.width() + 24);
    let file = fit_end(&visible(&source.file), room);
    let title = format!(
        "{file} · {} rows · {keys}",
        thousands(source.row_count() as u64)
    );
    let inner = super::window(frame, screen, model, &title, (screen.width, screen.height));
    let rows = usize::from(inner.height);
    let top = scroll.min(source.row_count().saturating_sub(rows));
    let from = top.saturating_sub(BEFORE);
    let picked = model.picked.and_then(|id| source.row_of(id));
    let seen: Vec<(usize, &str)> = source.rows(from..top + rows).collect();
    let texts = seen.iter().map(|(_, text)| *text);
    let styled = lines(Language::Xml, texts, &model.theme);
    let digits = source.row_count().to_string().len();
    let dim = Style::new().fg(model.theme.dim);
    let numbered = seen.iter().zip(styled).enumerate().skip(top - from);
    let shown = numbered.map(|(row, ((number, _), line))| {
        let here = picked == Some(from + row);
        let sign = if here { "▸" } else { " " };
        let style = match here {
            true => Style::new()
                .fg(model.theme.picked)
                .add_modifier(Modifier::BOLD),
            false => dim,
        };
        let mut whole = Line::from(Span::styled(format!("{sign}{number:>digits$} "), style));
        whole.spans.extend(line.spans);
        whole
    });
    frame.render_widget(Paragraph::new(shown.collect::<Vec<_>>()), inner);
}

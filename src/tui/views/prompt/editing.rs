//! The full-size editor: the template, its status, and the rendered result beside it.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use super::{BROKEN, body, editor, numbers};
use crate::model::{EntryLine, Model, Pane, PromptView};
use crate::widgets::frame;
use crate::widgets::words::{fit, fit_end};
use nearmiss_scene::description::visible;

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let prompt = &model.prompt;
    let wide = prompt.fits_beside(area.width);
    let (left, right) = if wide {
        let half = [Constraint::Fill(1), Constraint::Fill(1)];
        let [left, right] = Layout::horizontal(half).areas(area);
        (Some(left), Some(right))
    } else if prompt.turned {
        (None, Some(area))
    } else {
        (Some(area), None)
    };
    if let Some(right) = right {
        beside(f, right, model);
    }
    if let Some(left) = left {
        template(f, left, model, wide);
    }
}

fn template(f: &mut Frame<'_>, area: Rect, model: &Model, wide: bool) {
    let prompt = &model.prompt;
    let mark = if prompt.is_draft() {
        " · modified"
    } else {
        ""
    };
    let room = usize::from(area.width).saturating_sub(26);
    let file = fit_end(&visible(prompt.file()), room);
    let title = Line::from(format!("template · {file}{mark}"));
    let inner = frame::pane(f, area, model, Pane::Prompt, title);
    let error = prompt.error.as_ref().map(|error| {
        let words = format!("! {error}{BROKEN}");
        let words = Paragraph::new(visible(&words).into_owned()).wrap(Wrap { trim: true });
        words.style(Style::new().fg(model.theme.danger))
    });
    let lines = error.as_ref().map_or(0, |e| e.line_count(inner.width));
    let lines = u16::try_from(lines)
        .unwrap_or(u16::MAX)
        .min(inner.height / 3);
    let [text, wrong, below] = Layout::vertical([
        Constraint::Min(1),
        Constraint::Length(lines),
        Constraint::Length(1),
    ])
    .areas(inner);
    editor::draw(f, text, model, None);
    if let Some(error) = error {
        f.render_widget(error, wrong);
    }
    f.render_widget(status(model, usize::from(below.width), wide), below);
}

/// The line below the text: the input prompt, or the cursor position and the question's cost.
fn status(model: &Model, width: usize, wide: bool) -> Line<'static> {
    let theme = &model.theme;
    let prompt = &model.prompt;
    let accent = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
    let entered = match &prompt.entry {
        Some(EntryLine::Find(find)) => {
            let places = find.places(&prompt.editor);
            let at = places.iter().position(|&at| at == prompt.editor.cursor());
            let count = match at {
                _ if find.text.is_empty() && !prompt.sought.text.is_empty() => {
                    format!("  Enter: {}", prompt.sought.text)
                }
                Some(at) => format!("  {} of {}", at + 1, places.len()),
                None => format!("  {} found", places.len()),
            };
            Some(("find: ", &find.text, count))
        }
        Some(EntryLine::Line(text)) => Some((
            "go to line: ",
            text,
            format!("  of {}", prompt.editor.line_count()),
        )),
        Some(EntryLine::SaveAs(text)) => Some(("save as: ", text, "  .md".into())),
        None => None,
    };
    let dim = Style::new().fg(theme.dim);
    if let Some((label, text, after)) = entered {
        let room = width.saturating_sub(label.width() + after.width() + 1);
        let text = fit_end(&visible(text), room);
        return Line::from(vec![
            Span::styled(label, accent),
            Span::raw(format!("{text}▏")),
            Span::styled(fit(&visible(&after), width / 2), dim),
        ]);
    }
    let (row, col) = prompt.editor.cursor();
    let mut words = format!("{}:{} · {}", row + 1, col + 1, prompt.editor.mode());
    if prompt.is_draft() {
        words.push_str(" · modified");
    }
    if prompt.fill_in.is_some() {
        words.push_str(" · rendering…");
    }
    let mut line = Line::from(Span::styled(words, Style::new().fg(theme.title)));
    if !wide && let Some(numbers) = numbers(model) {
        let room = width.saturating_sub(line.width());
        line.push_span(Span::styled(fit(&format!(" · {numbers}"), room), dim));
    }
    line
}

/// The rendered template and its cost.
fn beside(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let prompt = &model.prompt;
    let theme = &model.theme;
    let mut title = format!(" {}", prompt.beside.name());
    if prompt.error.is_some() && prompt.beside == PromptView::Rendered {
        title.push_str(", last good");
    }
    if let Some(numbers) = numbers(model) {
        title.push_str(&format!(" · {numbers}"));
    }
    let title = fit(&title, usize::from(area.width).saturating_sub(4));
    let style = match prompt.error {
        Some(_) => Style::new().fg(theme.warning),
        None => Style::new().fg(theme.title),
    };
    let block = Block::bordered()
        .border_style(Style::new().fg(theme.border))
        .title(Span::styled(format!("{title} "), style));
    let inner = block.inner(area);
    f.render_widget(block, area);
    model.drawn.pane(Pane::Prompt, area);
    body(f, inner, model, prompt.beside);
}

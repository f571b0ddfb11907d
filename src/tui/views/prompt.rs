//! The prompt: the messages as they would be sent, the template in an editor, or the description.

use edtui::{EditorTheme, EditorView, LineNumbers};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Paragraph, Wrap};

use crate::text::visible;
use crate::tui::model::{Model, Pane, PromptView};
use crate::tui::widgets::highlight::{self, markdown};
use crate::tui::widgets::words::thousands;
use crate::tui::widgets::{frame, scroll};

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let inner = frame::pane(f, area, model, Pane::Prompt, title(model));
    let inner = error(f, inner, model);
    let prompt = &model.prompt;
    let Some(question) = &prompt.question else {
        if prompt.view != PromptView::Template || prompt.file().is_empty() {
            let words = model.without_ego();
            let words = Paragraph::new(visible(&words).into_owned()).wrap(Wrap { trim: true });
            f.render_widget(words.style(Style::new().fg(model.theme.dim)), inner);
            return;
        }
        return template(f, inner, model);
    };
    let text = match prompt.view {
        PromptView::Template => return template(f, inner, model),
        PromptView::Description => markdown(&question.description, &model.theme),
        PromptView::Rendered => {
            let label = |word: &'static str| {
                Line::styled(
                    word,
                    Style::new()
                        .fg(model.theme.picked)
                        .add_modifier(Modifier::BOLD),
                )
            };
            let mut text = Text::from(label("system"));
            text.extend(markdown(&question.prompt.system, &model.theme));
            text.push_line("");
            text.push_line(label("user"));
            text.extend(markdown(&question.prompt.user, &model.theme));
            text
        }
    };
    scroll::text(f, inner, model, Pane::Prompt, text, Some(prompt.scroll));
}

fn title(model: &Model) -> Line<'static> {
    let prompt = &model.prompt;
    let mut line = Line::from("prompt");
    for view in [
        PromptView::Rendered,
        PromptView::Template,
        PromptView::Description,
    ] {
        let style = if view == prompt.view {
            Style::new().add_modifier(Modifier::BOLD | Modifier::UNDERLINED)
        } else {
            Style::new().fg(model.theme.dim)
        };
        line.push_span(Span::raw(" · "));
        line.push_span(Span::styled(view.name(), style));
    }
    if let Some(question) = &prompt.question {
        let tokens = thousands(question.tokens() as u64);
        line.push_span(Span::styled(
            format!(" · ~{tokens} tokens"),
            Style::new().fg(model.theme.dim),
        ));
    }
    if !prompt.file().is_empty() {
        let mark = if prompt.is_draft() { " (draft)" } else { "" };
        line.push_span(Span::raw(format!(" · {}{mark}", prompt.file())));
    }
    line
}

/// What is wrong with the template, in the first lines; gives the rest of the area.
fn error(f: &mut Frame<'_>, area: Rect, model: &Model) -> Rect {
    let Some(error) = &model.prompt.error else {
        return area;
    };
    let words = format!("{error}; the last template that could be filled stays in use");
    let words = Paragraph::new(visible(&words).into_owned())
        .style(Style::new().fg(model.theme.danger))
        .wrap(Wrap { trim: true });
    let lines = u16::try_from(words.line_count(area.width))
        .unwrap_or(1)
        .min(area.height / 2);
    f.render_widget(
        words,
        Rect {
            height: lines,
            ..area
        },
    );
    Rect {
        y: area.y + lines,
        height: area.height - lines,
        ..area
    }
}

fn template(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let theme = &model.theme;
    let mut colors = EditorTheme::default()
        .base(theme.base())
        .selection_style(theme.selected())
        .line_numbers_style(Style::new().fg(theme.dim))
        .cursor_style(Style::new().add_modifier(Modifier::REVERSED))
        .hide_status_line();
    if !model.prompt.editing {
        colors = colors.hide_cursor();
    }
    let mut editor = model.prompt.editor.borrow_mut();
    let view = EditorView::new(&mut editor)
        .theme(colors)
        .wrap(true)
        .line_numbers(LineNumbers::Absolute)
        .syntax_highlighter(highlight::editor(theme));
    f.render_widget(view, area);
}

//! The prompt: rendered messages, template, description, or differences from the shipped template.

mod diff;
mod editing;
mod editor;

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::action::Action;
use crate::model::{Extent, HEAVY, Model, Pane, PromptView, Readings};
use crate::widgets::long_text::{MarkedClaims, Reading};
use crate::widgets::scroll::PageSection;
use crate::widgets::words::thousands;
use crate::widgets::{frame, scroll};
use nearmiss_scene::description::visible;

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    if model.prompt.editing {
        return editing::draw(f, area, model);
    }
    let inner = frame::pane(f, area, model, Pane::Prompt, title(model, area.width));
    let inner = error(f, inner, model);
    body(f, inner, model, model.prompt.view);
}

/// A view of the prompt, or why there is none.
fn body(f: &mut Frame<'_>, area: Rect, model: &Model, view: PromptView) {
    let prompt = &model.prompt;
    let there = !prompt.file().is_empty();
    let mut readings = model.drawn.readings.borrow_mut();
    let Readings { system, user, .. } = &mut *readings;
    let line = |line| vec![PageSection::Line(line)];
    let parts = match (view, &prompt.question) {
        _ if prompt.held => return template(f, area, model),
        (PromptView::Template, _) if there => return template(f, area, model),
        (PromptView::Diff, _) if there => {
            let text = diff::text(model);
            scroll::text(f, area, model, Pane::Prompt, text, Some(prompt.scroll));
            return;
        }
        (PromptView::Description, Some(question)) => {
            vec![PageSection::Text(
                user,
                &question.description,
                MarkedClaims::default(),
            )]
        }
        (PromptView::Rendered, Some(question)) => {
            let label = |word: &'static str| {
                line(Line::styled(
                    word,
                    Style::new()
                        .fg(model.theme.picked)
                        .add_modifier(Modifier::BOLD),
                ))
            };
            let mut parts = label("system");
            parts.extend(message(&question.prompt.system, system, model));
            parts.extend(line(Line::default()));
            parts.extend(label("user"));
            parts.extend(message(&question.prompt.user, user, model));
            parts
        }
        _ => {
            let words = model.without_ego();
            let words = Paragraph::new(visible(&words).into_owned()).wrap(Wrap { trim: true });
            return f.render_widget(words.style(Style::new().fg(model.theme.dim)), area);
        }
    };
    scroll::page(f, area, model, Pane::Prompt, parts, Some(prompt.scroll));
}

/// A message; of a heavy one the beginning, which is plain: all of it would take too long in every frame.
fn message<'a>(text: &'a str, reading: &'a mut Reading, model: &Model) -> Vec<PageSection<'a>> {
    if text.len() <= HEAVY {
        return vec![PageSection::Text(reading, text, MarkedClaims::default())];
    }
    let begin = text
        .lines()
        .take(BEGINNING)
        .map(|line| visible(line).into_owned());
    let mut shown: Vec<_> = begin
        .map(|line| PageSection::Line(Line::from(line)))
        .collect();
    let left = text.lines().count().saturating_sub(BEGINNING);
    if left > 0 {
        let words = format!("… {} more lines", thousands(left as u64));
        let line = Line::styled(words, Style::new().fg(model.theme.dim));
        shown.push(PageSection::Line(line));
    }
    shown
}

/// Lines of a heavy message that are shown.
const BEGINNING: usize = 500;

/// Tokens, how many more than by the shipped template, and the price.
fn numbers(model: &Model) -> Option<String> {
    let prompt = &model.prompt;
    let tokens = prompt.question.as_ref().map(|_| prompt.tokens)?;
    let mut words = format!("~{} tokens", thousands(tokens as u64));
    if let Some(shipped) = prompt.shipped_tokens.filter(|&shipped| shipped != tokens) {
        let sign = if tokens > shipped { '+' } else { '−' };
        let by = thousands(tokens.abs_diff(shipped) as u64);
        words.push_str(&format!(" ({sign}{by} vs shipped)"));
    }
    if prompt
        .question
        .as_ref()
        .is_some_and(|q| q.picture.is_some())
    {
        let key = model.look.key(Action::SavePicture);
        words.push_str(&format!(" with the picture ({key} saves it)"));
    }
    Some(format!("{words} · {}", model.price()))
}

/// The views with the current one marked, and as much of token count and file as fits; with little room, the current
/// view alone.
fn title(model: &Model, width: u16) -> Line<'static> {
    let prompt = &model.prompt;
    let room = usize::from(width).saturating_sub(4);
    let mut line = Line::from("prompt");
    let all: usize = PromptView::ALL.iter().map(|v| v.name().width() + 3).sum();
    let narrow = line.width() + all > room;
    let views = PromptView::ALL.into_iter();
    for view in views.filter(|view| !narrow || *view == prompt.view) {
        let style = if view == prompt.view {
            Style::new().add_modifier(Modifier::BOLD | Modifier::UNDERLINED)
        } else {
            Style::new().fg(model.theme.dim)
        };
        line.push_span(Span::raw(" · "));
        line.push_span(Span::styled(view.name(), style));
    }
    let mut add = |span: Span<'static>| {
        if line.width() + span.width() <= room {
            line.push_span(span);
        }
    };
    if narrow {
        let key = model.look.key(Action::PromptView);
        add(Span::styled(
            format!(" ({key} next)"),
            Style::new().fg(model.theme.dim),
        ));
    }
    if prompt.is_draft() {
        add(Span::raw(" · draft"));
    }
    if prompt.question.is_some() {
        let tokens = thousands(prompt.tokens as u64);
        add(Span::styled(
            format!(" · ~{tokens} tokens"),
            Style::new().fg(model.theme.dim),
        ));
    }
    if !prompt.file().is_empty() {
        add(Span::raw(format!(" · {}", visible(prompt.file()))));
    }
    line
}

/// What follows from an error of the template.
const BROKEN: &str = "; requests disabled until fixed, the last good version is shown";

/// The template's errors in the first lines; returns the remaining area.
fn error(f: &mut Frame<'_>, area: Rect, model: &Model) -> Rect {
    let Some(error) = &model.prompt.error else {
        return area;
    };
    let rest = if model.prompt.held { "" } else { BROKEN };
    let words = format!("! {error}{rest}");
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

/// The template, to be read; it is scrolled line by line.
fn template(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let lines = model.prompt.editor.line_count();
    let top = model.prompt.scroll.min(lines - 1);
    editor::draw(f, area, model, Some(top));
    let extent = Extent {
        lines: lines + usize::from(area.height) - 1,
        rows: usize::from(area.height),
        top,
    };
    model.drawn.text(Pane::Prompt, extent);
}

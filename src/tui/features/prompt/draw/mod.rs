//! The prompt: rendered messages, template, description, or differences from the shipped template.

pub mod answer;
pub mod draw_editor;

use nearmiss_ask::prompts::Prompt;
use nearmiss_scene::description::visible;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Block, Paragraph, Wrap};
use similar::{ChangeTag, DiffOp};
use unicode_width::UnicodeWidthStr;

use crate::action::Action;
use crate::model::{
    EntryLine, Extent, HEAVY, Model, Pane, PromptView, Readings, changed_lines, diff_of,
};
use crate::theme::Theme;
use crate::widgets::long_text::{MarkedClaims, Reading};
use crate::widgets::row::{self, PageSection};
use crate::widgets::window;
use crate::widgets::words::{fit, fit_end, thousands};

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    if model.prompt.editing {
        return draw_full_size(f, area, model);
    }
    let inner = window::pane(f, area, model, Pane::Prompt, title(model, area.width));
    let inner = error(f, inner, model, model.prompt.view);
    body(f, inner, model, model.prompt.view);
}

/// A view of the prompt, or why there is none.
fn body(f: &mut Frame<'_>, area: Rect, model: &Model, view: PromptView) {
    let prompt = &model.prompt;
    let there = !prompt.file().is_empty();
    let mut readings = model.drawn.readings.borrow_mut();
    let Readings {
        system,
        user,
        changes,
        ..
    } = &mut *readings;
    let line = |line| vec![PageSection::Line(line)];
    let parts = match (view, &prompt.question) {
        _ if prompt.held => return template(f, area, model),
        (PromptView::Template, _) if there => return template(f, area, model),
        (PromptView::Diff, _) if there => {
            let text = text(model);
            row::text(f, area, model, Pane::Prompt, text, Some(prompt.scroll));
            return;
        }
        (PromptView::Answer, _) => {
            let text = answer::text(model, changes);
            row::text(f, area, model, Pane::Prompt, text, Some(prompt.scroll));
            return;
        }
        (PromptView::Description, Some(question)) => {
            vec![PageSection::Text(
                user,
                &question.description,
                MarkedClaims::default(),
            )]
        }
        (PromptView::Rendered, Some(question)) if prompt.is_draft() && shipped(model).is_some() => {
            let old = shipped(model).map(both).unwrap_or_default();
            let lines = changes.lines(&old, &both(&question.prompt));
            // Only what is sent.
            let sent = lines.iter().filter(|(tag, _)| *tag != ChangeTag::Delete);
            let lines = sent.map(|(tag, parts)| self::line(*tag, parts, &model.theme));
            let text = Text::from_iter(lines);
            row::text(f, area, model, Pane::Prompt, text, Some(prompt.scroll));
            return;
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
    row::page(f, area, model, Pane::Prompt, parts, Some(prompt.scroll));
}

/// The prompt of the shipped template, where it can be compared in every frame.
fn shipped(model: &Model) -> Option<&Prompt> {
    let light = |prompt: &Prompt| prompt.system.len() + prompt.user.len() <= HEAVY;
    let (_, shipped) = model.prompt.shipped_question.as_ref()?;
    let sent = &model.prompt.question.as_ref()?.prompt;
    (light(shipped) && light(sent)).then_some(shipped)
}

/// Both messages, each below its name.
fn both(prompt: &Prompt) -> String {
    format!("system\n{}\n\nuser\n{}", prompt.system, prompt.user)
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
    let shipped = prompt.shipped_question.as_ref().map(|(tokens, _)| *tokens);
    if let Some(shipped) = shipped.filter(|&shipped| shipped != tokens) {
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

/// What follows from an error of the template, with that view in sight.
fn consequence(view: PromptView) -> &'static str {
    match view {
        PromptView::Rendered => "; requests disabled until fixed, the last good version is shown",
        _ => "; requests disabled until fixed",
    }
}

/// The template's errors in the first lines, above that view; returns the remaining area.
fn error(f: &mut Frame<'_>, area: Rect, model: &Model, view: PromptView) -> Rect {
    let Some(error) = &model.prompt.error else {
        return area;
    };
    let rest = if model.prompt.held {
        ""
    } else {
        consequence(view)
    };
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
    draw_editor::draw(f, area, model, Some(top));
    let extent = Extent {
        lines: lines + usize::from(area.height) - 1,
        rows: usize::from(area.height),
        top,
    };
    model.drawn.text(Pane::Prompt, extent);
}

fn draw_full_size(f: &mut Frame<'_>, area: Rect, model: &Model) {
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
        draw_side_view(f, right, model, left.is_none());
    }
    if let Some(left) = left {
        draw_template(f, left, model, wide);
    }
}

fn draw_template(f: &mut Frame<'_>, area: Rect, model: &Model, wide: bool) {
    let prompt = &model.prompt;
    let mark = if prompt.is_draft() {
        " · modified"
    } else {
        ""
    };
    let room = usize::from(area.width).saturating_sub(26);
    let file = fit_end(&visible(prompt.file()), room);
    let title = Line::from(format!("template · {file}{mark}"));
    let inner = window::pane(f, area, model, Pane::Prompt, title);
    let seen = if wide {
        prompt.beside
    } else {
        PromptView::Template
    };
    let error = prompt.error.as_ref().map(|error| {
        let words = format!("! {error}{}", consequence(seen));
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
    draw_editor::draw(f, text, model, None);
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
        Some(EntryLine::Command(text)) => Some((
            ":",
            text,
            "  w saves, q leaves, x both, a number goes to its line".into(),
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

/// The rendered template and its cost; where the template is not beside it, with its error.
fn draw_side_view(f: &mut Frame<'_>, area: Rect, model: &Model, alone: bool) {
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
    let mut inner = block.inner(area);
    f.render_widget(block, area);
    model.drawn.pane(Pane::Prompt, area);
    if alone {
        inner = error(f, inner, model, prompt.beside);
    }
    body(f, inner, model, prompt.beside);
}

/// Unchanged lines around changes.
const CONTEXT: usize = 3;

fn text(model: &Model) -> Text<'static> {
    let dim = Style::new().fg(model.theme.dim);
    let prompt = &model.prompt;
    let mut text = match (prompt.shipped(), prompt.compared()) {
        (None, _) => Text::from("no shipped template for this task and frame to compare with"),
        (Some((shipped, _)), None) => Text::from(format!("same as the shipped {shipped}")),
        (Some((shipped, _)), Some((old, new))) => {
            Text::from(changed(shipped, (old, &new), &model.theme))
        }
    };
    let overridden: Vec<&str> = model.library.overridden().collect();
    let drafts = prompt.drafted();
    let drafts: Vec<&str> = drafts.iter().map(String::as_str).collect();
    text.push_line("");
    for (what, files) in [("saved overrides", overridden), ("unsaved drafts", drafts)] {
        if !files.is_empty() {
            let words = format!("{what}: {}", files.join(", "));
            text.push_line(Line::styled(visible(&words).into_owned(), dim));
        }
    }
    text
}

/// The changed lines, with the changed words in them.
fn changed(shipped: &str, (old, new): (&str, &str), theme: &Theme) -> Vec<Line<'static>> {
    let diff = diff_of(old, new);
    let count = |tag| diff.iter_all_changes().filter(|c| c.tag() == tag).count();
    let words = format!(
        "+{} −{} lines vs shipped {shipped}",
        count(ChangeTag::Insert),
        count(ChangeTag::Delete)
    );
    let mut lines = vec![Line::styled(words, Style::new().fg(theme.title))];
    for group in diff.grouped_ops(CONTEXT) {
        lines.push(place(&group, theme));
        for op in &group {
            let changed = changed_lines(&diff, op).into_iter();
            lines.extend(changed.map(|(tag, parts)| line(tag, &parts, theme)));
        }
    }
    lines
}

/// Where a group of changes is: first lines and counts, as in a unified diff.
fn place(group: &[DiffOp], theme: &Theme) -> Line<'static> {
    let (mut old, mut new) = ((usize::MAX, 0), (usize::MAX, 0));
    for op in group {
        let (a, b) = (op.old_range(), op.new_range());
        old = (old.0.min(a.start), old.1 + a.len());
        new = (new.0.min(b.start), new.1 + b.len());
    }
    let words = format!("@@ -{},{} +{},{} @@", old.0 + 1, old.1, new.0 + 1, new.1);
    let style = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
    Line::styled(words, style)
}

/// A line with its sign. Where only some of its words changed, these alone are coloured: removed ones are crossed out,
/// added ones underlined, so that they stand out without colours, too.
fn line(tag: ChangeTag, parts: &[(bool, String)], theme: &Theme) -> Line<'static> {
    let (sign, color, mark) = match tag {
        ChangeTag::Equal => (' ', theme.text, Modifier::empty()),
        ChangeTag::Delete => ('-', theme.danger, Modifier::CROSSED_OUT),
        ChangeTag::Insert => ('+', theme.safe, Modifier::UNDERLINED),
    };
    let style = Style::new().fg(color);
    let by_words = parts
        .iter()
        .any(|(changed, part)| !changed && !part.is_empty());
    let mut spans = vec![Span::styled(sign.to_string(), style)];
    for (changed, part) in parts {
        let style = match (by_words, changed) {
            (true, true) => style.add_modifier(mark | Modifier::BOLD),
            (true, false) => theme.base(),
            (false, _) => style,
        };
        spans.push(Span::styled(visible(part).into_owned(), style));
    }
    Line::from(spans)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_paragraph_only_the_changed_words_are_marked() {
        let theme = Theme::default_theme();
        let old = "# Task\n\nDecide whether the ego vehicle collides with an obstacle in the window.\nEnd\n";
        let new =
            "# Task\n\nDecide whether the ego vehicle will touch an obstacle in the window.\nEnd\n";
        let lines = changed("a.md", (old, new), &theme);
        let texts: Vec<String> = lines.iter().map(ToString::to_string).collect();
        assert_eq!(texts[0], "+1 −1 lines vs shipped a.md");
        let with = |sign: char| {
            let mut found = lines.iter().skip(4);
            let found = found.find(|line| line.to_string().starts_with(sign));
            let spans = found.map(|line| line.spans.clone()).unwrap_or_default();
            let marked = spans
                .iter()
                .skip(1)
                .filter(|span| span.style.add_modifier.contains(Modifier::BOLD))
                .map(|span| span.content.trim().to_string());
            (marked.collect::<Vec<_>>().join(" "), spans)
        };
        let (removed, spans) = with('-');
        assert_eq!(removed, "collides with");
        let crossed = |span: &&Span<'_>| span.style.add_modifier.contains(Modifier::CROSSED_OUT);
        assert!(spans.iter().any(|span| crossed(&span)));
        let same = spans.iter().find(|span| span.content.contains("Decide"));
        assert_eq!(same.and_then(|span| span.style.fg), theme.base().fg);
        assert_eq!(with('+').0, "will touch");
        // Where words were only added, none of the old ones is marked.
        let lines = changed("a.md", ("one two three\n", "one two and three\n"), &theme);
        let old = lines
            .iter()
            .find(|line| line.to_string() == "-one two three");
        let plain = |span: &Span<'_>| span.style == theme.base();
        assert!(old.is_some_and(|line| line.spans.iter().skip(1).all(plain)));
        // A line that is new as a whole is coloured as a whole.
        let lines = changed("a.md", ("a\n", "a\nnew words\n"), &theme);
        let added = lines.last().map(|line| line.spans[1].style.fg);
        assert_eq!(added, Some(Some(theme.safe)));
    }
}

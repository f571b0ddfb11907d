//! Differences from the shipped template by words, and the user's other overrides.

use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use similar::{ChangeTag, DiffOp};

use crate::model::{Model, diff_of};
use crate::theme::Theme;
use nearmiss_scene::description::visible;

/// Unchanged lines around changes.
const CONTEXT: usize = 3;

pub fn text(model: &Model) -> Text<'static> {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let prompt = &model.prompt;
    let mut text = Text::default();
    let overridden: Vec<&str> = model.library.overridden().collect();
    let saved = if overridden.is_empty() {
        "no saved overrides".to_string()
    } else {
        format!("saved overrides: {}", overridden.join(", "))
    };
    text.push_line(Line::styled(visible(&saved).into_owned(), dim));
    let drafts = prompt.drafted();
    if !drafts.is_empty() {
        let words = format!("unsaved drafts: {}", drafts.join(", "));
        text.push_line(Line::styled(visible(&words).into_owned(), dim));
    }
    text.push_line("");
    let Some((shipped, _)) = prompt.shipped() else {
        text.push_line("no shipped template for this task and frame to compare with");
        return text;
    };
    let Some((old, new)) = prompt.compared() else {
        text.push_line(format!("same as the shipped {shipped}"));
        return text;
    };
    text.lines.pop();
    text.lines
        .extend(changed(shipped, prompt.file(), (old, &new), theme));
    text
}

/// The changed lines, with the changed words in them.
fn changed(
    shipped: &str,
    file: &str,
    (old, new): (&str, &str),
    theme: &Theme,
) -> Vec<Line<'static>> {
    let diff = diff_of(old, new);
    let dim = Style::new().fg(theme.dim);
    let count = |tag| diff.iter_all_changes().filter(|c| c.tag() == tag).count();
    let words = format!(
        "+{} −{} lines vs shipped {shipped}",
        count(ChangeTag::Insert),
        count(ChangeTag::Delete)
    );
    let mut lines = vec![
        Line::styled(words, Style::new().fg(theme.title)),
        Line::default(),
        Line::styled(format!("--- shipped/{shipped}"), dim),
        Line::styled(visible(&format!("+++ {file}")).into_owned(), dim),
    ];
    for group in diff.grouped_ops(CONTEXT) {
        lines.push(place(&group, theme));
        for op in &group {
            for change in diff.iter_inline_changes(op) {
                let parts: Vec<(bool, String)> = change
                    .iter_strings_lossy()
                    .map(|(changed, part)| {
                        (changed, part.trim_end_matches(['\n', '\r']).to_string())
                    })
                    .collect();
                lines.push(line(change.tag(), &parts, theme));
            }
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
    let by_words = parts.iter().any(|(changed, _)| *changed);
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
        let lines = changed("a.md", "b.md", (old, new), &theme);
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
        // A line that is new as a whole is coloured as a whole.
        let lines = changed("a.md", "b.md", ("a\n", "a\nnew words\n"), &theme);
        let added = lines.last().map(|line| line.spans[1].style.fg);
        assert_eq!(added, Some(Some(theme.safe)));
    }
}

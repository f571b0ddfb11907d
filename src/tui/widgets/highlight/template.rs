//! Highlighting of templates: front matter, Markdown and template syntax.

use ratatui::style::{Modifier, Style};

use super::{Language, lines};
use crate::theme::Theme;

/// A style for every character of the lines, of which the first is number `from` of the file, from 0. Front matter
/// is seen only from the beginning on.
#[must_use]
pub fn template(text: &[&str], from: usize, theme: &Theme) -> Vec<Vec<Style>> {
    let mut fences = text
        .iter()
        .enumerate()
        .filter(|(_, l)| l.trim_end() == "+++")
        .map(|(at, _)| at);
    let front = match (from, fences.next(), fences.next()) {
        (0, Some(0), Some(end)) => end + 1,
        _ => 0,
    };
    let mut styles: Vec<Vec<Style>> = text[..front].iter().map(|l| toml(l, theme)).collect();
    let body = text[front..].iter().copied();
    for (line, source) in lines(Language::Markdown, body.clone(), theme)
        .into_iter()
        .zip(body)
    {
        let of_span = |span: &ratatui::text::Span<'_>| {
            let style = span.style;
            span.content.chars().map(|_| style).collect::<Vec<_>>()
        };
        let mut line: Vec<Style> = line.spans.iter().flat_map(of_span).collect();
        line.resize(source.chars().count(), theme.base());
        styles.push(line);
    }
    tags(&text[front..], &mut styles[front..], theme);
    styles
}

/// A line of front matter: keys, and what they are set to.
fn toml(line: &str, theme: &Theme) -> Vec<Style> {
    let dim = Style::new().fg(theme.dim);
    let all = line.chars().count();
    let trimmed = line.trim_start();
    if trimmed.starts_with(['#', '[', '+']) {
        return vec![dim; all];
    }
    let key = line.find('=').map_or(0, |at| line[..at].chars().count());
    let key_style = Style::new().fg(theme.ego);
    let value = Style::new().fg(theme.safe);
    (0..all)
        .map(|at| if at < key { key_style } else { value })
        .collect()
}

/// Marks of the template language: where they begin, where they end, and whether they are comments.
const TAGS: [(&str, &str, bool); 3] =
    [("{%", "%}", false), ("{{", "}}", false), ("{#", "#}", true)];

/// Colours tags and comments, which may go over lines.
fn tags(text: &[&str], styles: &mut [Vec<Style>], theme: &Theme) {
    let tag = Style::new().fg(theme.picked).add_modifier(Modifier::BOLD);
    let comment = Style::new().fg(theme.dim).add_modifier(Modifier::ITALIC);
    let mut open: Option<(&str, bool)> = None;
    for (line, styles) in text.iter().zip(styles) {
        let chars: Vec<char> = line.chars().collect();
        let is = |at: usize, mark: &str| mark.chars().eq(chars.iter().skip(at).take(2).copied());
        let mut at = 0;
        while at < chars.len() {
            let mut taken = 1;
            // One that begins in another shows that the other was not closed.
            if !matches!(open, Some((_, true)))
                && let Some((_, end, comment)) = TAGS.iter().find(|(begin, ..)| is(at, begin))
            {
                open = Some((end, *comment));
                taken = 2;
            }
            if let Some((end, is_comment)) = open {
                if taken == 1 && is(at, end) {
                    taken = 2;
                    open = None;
                }
                let style = if is_comment { comment } else { tag };
                let last = (at + taken).min(styles.len());
                styles[at.min(last)..last].fill(style);
            }
            at += taken;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_character_has_a_style_and_tags_stand_out() {
        let theme = Theme::default_theme();
        super::super::load();
        let text = "+++\nname = \"ä\"\n+++\n# Title {{ x }} b\n{# a\nb #} `c`\u{1b}";
        let lines: Vec<&str> = text.lines().collect();
        let styles = template(&lines, 0, &theme);
        for (line, styles) in lines.iter().zip(&styles) {
            assert_eq!(line.chars().count(), styles.len(), "{line}");
        }
        let color = |line: usize, at: usize| styles[line][at].fg;
        assert_eq!(color(1, 0), Some(theme.ego));
        assert_eq!(color(1, 8), Some(theme.safe));
        assert_eq!(color(3, 8), Some(theme.picked));
        assert_eq!(color(3, 14), Some(theme.picked));
        assert_eq!(color(3, 16), Some(theme.accent));
        assert_eq!(
            (color(4, 3), color(5, 0)),
            (Some(theme.dim), Some(theme.dim))
        );
        assert_ne!(color(5, 6), Some(theme.dim));
    }
}

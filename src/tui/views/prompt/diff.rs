//! Differences from the shipped template, and the user's other overrides.

use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Text};

use crate::description::visible;
use crate::tui::model::Model;

pub fn text(model: &Model) -> Text<'static> {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let prompt = &model.prompt;
    let mut text = Text::default();
    let overridden: Vec<&str> = model.library.overridden().collect();
    let yours = match overridden.is_empty() {
        true => "no shipped file is overridden by one of yours".to_string(),
        false => format!(
            "yours in the place of shipped ones: {}",
            overridden.join(", ")
        ),
    };
    text.push_line(Line::styled(visible(&yours).into_owned(), dim));
    let drafts = prompt.drafted();
    if !drafts.is_empty() {
        let words = format!("drafts, not saved: {}", drafts.join(", "));
        text.push_line(Line::styled(visible(&words).into_owned(), dim));
    }
    let Some((shipped, _)) = prompt.shipped() else {
        text.push_line("");
        text.push_line(
            "no shipped template is for this task and frame: there is nothing to compare with",
        );
        return text;
    };
    let Some(difference) = prompt.difference() else {
        text.push_line("");
        text.push_line(format!("the template is the shipped {shipped}"));
        return text;
    };
    let count = |sign: char| {
        let lines = difference.lines().skip(2);
        lines.filter(|l| l.starts_with(sign)).count()
    };
    let words = format!(
        "+{} −{} lines to the shipped {shipped}",
        count('+'),
        count('-')
    );
    text.push_line(Line::styled(words, Style::new().fg(theme.title)));
    text.push_line("");
    for line in difference.lines() {
        let style = match line.chars().next() {
            _ if line.starts_with("---") || line.starts_with("+++ ") => dim,
            Some('+') => Style::new().fg(theme.safe),
            Some('-') => Style::new().fg(theme.danger),
            Some('@') => Style::new().fg(theme.accent).add_modifier(Modifier::BOLD),
            _ => theme.base(),
        };
        text.push_line(Line::styled(visible(line).into_owned(), style));
    }
    text
}

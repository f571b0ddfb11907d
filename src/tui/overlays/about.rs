//! What is in the opened scenario, and what reading it had to assume or skip.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};

use crate::scenario::Severity;
use crate::text::visible;
use crate::tui::loaded::Opened;
use crate::tui::model::Model;
use crate::tui::widgets::words::pad;

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model, scroll: usize) {
    let text = match &model.opened {
        Some(opened) => about(model, opened),
        None => Text::raw("no scenario is open"),
    };
    super::scrolled(frame, screen, model, "scenario", text, scroll);
}

fn about(model: &Model, opened: &Opened) -> Text<'static> {
    let theme = &model.theme;
    let title = Style::new().fg(theme.picked).add_modifier(Modifier::BOLD);
    let word = Style::new().fg(theme.accent);
    let scenario = &opened.scenario;
    let mut text = Text::from(Line::styled(visible(&opened.name).into_owned(), title));
    let mut line = |name: &str, said: &str| {
        text.push_line(Line::from(vec![
            Span::styled(format!("  {}", pad(name, 12)), word),
            Span::raw(visible(said).into_owned()),
        ]));
    };
    line("file", &opened.file);
    line("hash", &scenario.hash.to_string());
    for (name, said) in scenario.summary() {
        line(name, &said);
    }
    match (&opened.scene, &opened.no_ego) {
        (Some(scene), _) => line("ego", &scene.ego.to_string()),
        (None, why) => line("ego", why.as_deref().unwrap_or("none")),
    }
    text.push_line("");
    text.push_line(Line::styled("what reading it had to assume or skip", title));
    if scenario.diagnostics.is_empty() {
        text.push_line("  nothing");
    }
    for diagnostic in &scenario.diagnostics {
        let color = match diagnostic.severity {
            Severity::Warning => theme.warning,
            Severity::Note => theme.dim,
        };
        let words = visible(&diagnostic.to_string()).into_owned();
        text.push_line(Line::styled(format!("  {words}"), Style::new().fg(color)));
    }
    text
}

//! All keys, from the table of actions.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};

use crate::tui::action::{ACTIONS, Scope};
use crate::tui::keymap;
use crate::tui::model::Model;
use crate::tui::widgets::words::pad;

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model, scroll: usize) {
    super::scrolled(frame, screen, model, "keys", text(model), scroll);
}

fn text(model: &Model) -> Text<'static> {
    let theme = &model.theme;
    let title = Style::new().fg(theme.picked).add_modifier(Modifier::BOLD);
    let key = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
    let mut text = Text::default();
    let places = [
        (Scope::Global, "everywhere"),
        (Scope::Scenarios, "in the list of scenarios"),
        (Scope::Map, "on the map"),
        (Scope::Text, "in prompt, verdict and reasoning"),
        (Scope::Compare, "on the screen of answers side by side"),
    ];
    for (scope, name) in places {
        text.push_line(Line::styled(name, title));
        for entry in ACTIONS
            .iter()
            .filter(|e| e.scope == scope && !e.keys.is_empty())
        {
            let keys: Vec<String> = keymap::keys(entry).map(|k| k.to_string()).collect();
            text.push_line(Line::from(vec![
                Span::styled(format!("  {}", pad(&keys.join("  "), 16)), key),
                Span::raw(entry.doc),
            ]));
        }
        text.push_line("");
    }
    text.push_line(Line::styled("signs", title));
    let signs = [
        (
            "0 to 5",
            "risk score: 0 collision, 1 extreme, 2 high, 3 medium, 4 low, 5 negligible",
        ),
        (
            "0X 3 - ·",
            "in the list: the lowest risk score, X with a contact, - without an ego, · not yet known",
        ),
        ("X", "contact: in the list, on the map and on the timeline"),
        (
            "!",
            "on the map: risk 1 or lower; in the list: the file cannot be read",
        ),
        (
            "= ≠",
            "an answer agrees with the built-in judge, or differs from it",
        ),
    ];
    for (sign, meaning) in signs {
        text.push_line(Line::from(vec![
            Span::styled(format!("  {}", pad(sign, 16)), key),
            Span::raw(meaning),
        ]));
    }
    text
}

//! The line at the bottom: the keys that work here and now, from the table of actions.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};

use crate::tui::action::{ACTIONS, Action};
use crate::tui::keymap;
use crate::tui::model::{Model, Overlay};

pub fn draw(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let mut left = usize::from(area.width);
    let mut line = Line::default();
    for (keys, words) in hints(model) {
        let width = keys.chars().count() + words.chars().count() + 3;
        if width > left {
            break;
        }
        left -= width;
        let key = Style::new()
            .fg(model.theme.accent)
            .add_modifier(Modifier::BOLD);
        line.push_span(Span::styled(format!(" {keys}"), key));
        line.push_span(Span::styled(
            format!(" {words} "),
            Style::new().fg(model.theme.dim),
        ));
    }
    frame.render_widget(line, area);
}

/// The key of an action, and what it does.
fn hint_of(action: Action) -> Option<(String, String)> {
    let entry = ACTIONS.iter().find(|e| e.action == action)?;
    let key = keymap::keys(entry).next()?;
    Some((key.to_string(), entry.short.to_string()))
}

fn hints(model: &Model) -> Vec<(String, String)> {
    let fixed = |pairs: &[(&str, &str)]| {
        pairs
            .iter()
            .map(|(k, w)| ((*k).to_string(), (*w).to_string()))
            .collect()
    };
    match model.overlays.last() {
        Some(Overlay::Help { .. } | Overlay::About { .. }) => {
            return fixed(&[
                ("↑↓", "scroll"),
                ("PgUp PgDn", "a page"),
                ("Esc", "or another key closes"),
            ]);
        }
        Some(Overlay::Values { .. }) => {
            return fixed(&[
                ("←→", "step"),
                ("n", "obstacle"),
                ("↑↓", "scroll"),
                ("Esc", "close"),
                ("PgUp PgDn", "a page"),
                ("x", "worst"),
            ]);
        }
        Some(
            Overlay::Palette(_)
            | Overlay::Models { .. }
            | Overlay::Pictures(_)
            | Overlay::Measures { .. },
        ) => {
            return fixed(&[
                ("type", "to search"),
                ("↑↓", "select"),
                ("Enter", "choose"),
                ("Esc", "close"),
            ]);
        }
        None => {}
    }
    if model.prompt.editing {
        return fixed(&[
            ("Esc", "done"),
            ("Ctrl-s", "save as yours"),
            ("Ctrl-c", "done"),
        ]);
    }
    if model.list.filtering {
        return fixed(&[
            ("type", "to filter"),
            ("↑↓", "select"),
            ("Enter", "keep"),
            ("Esc", "clear"),
        ]);
    }
    let mut shown: Vec<_> = ACTIONS.iter().filter(|e| e.footer > 0).collect();
    shown.sort_by_key(|e| e.footer);
    let mut hints: Vec<(String, String)> = Vec::new();
    if model.answers.is_running() {
        hints.push(("Esc".into(), "cancel request".into()));
    }
    if model.taken.is_some() {
        // The way back is needed only here.
        hints.extend(hint_of(Action::RecordedEgo));
    }
    for entry in shown {
        let Some(key) = keymap::keys(entry).next() else {
            continue;
        };
        let words = match entry.action {
            Action::Play if model.clock.playing => "pause",
            _ => entry.short,
        };
        match hints.last_mut().filter(|(_, w)| w == words) {
            Some((keys, _)) => keys.push_str(&key.to_string()),
            None => hints.push((key.to_string(), words.to_string())),
        }
    }
    hints
}

//! The line at the bottom: the keys that work here and now, from the table of actions.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use unicode_width::UnicodeWidthStr;

use crate::settings::Keys;
use crate::tui::action::{ACTIONS, Action, Entry, Scope};
use crate::tui::keymap::Chord;
use crate::tui::model::{EntryLine, Model, Overlay};

pub fn draw(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let mut left = usize::from(area.width);
    let mut line = Line::default();
    for (keys, words) in hints(model) {
        let width = keys.width() + words.width() + 3;
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
fn hint_of(model: &Model, action: Action) -> Option<(String, String)> {
    let entry = ACTIONS.iter().find(|e| e.action == action)?;
    let key = model.look.keymap.keys(entry).next()?;
    Some((key.to_string(), entry.short.to_string()))
}

/// The keys of a screen of its own, and those that leave it.
fn own(model: &Model, scope: Scope) -> Vec<(String, String)> {
    let mut entries: Vec<_> = ACTIONS
        .iter()
        .filter(|e| e.scope == scope && e.footer > 0)
        .collect();
    entries.sort_by_key(|e| e.footer);
    let key = |entry: &&crate::tui::action::Entry| {
        let key = model.look.keymap.keys(entry).next()?;
        Some((key.to_string(), entry.short.to_string()))
    };
    let mut hints: Vec<_> = entries.iter().filter_map(key).collect();
    hints.extend(hint_of(model, Action::Help));
    hints.push(("Esc".into(), "close".into()));
    hints
}

/// The keys of the editor, or of the line below it.
fn editing(model: &Model) -> Vec<(String, String)> {
    let fixed = |pairs: &[(&str, &str)]| {
        let owned = pairs.iter().map(|(k, w)| (k.to_string(), w.to_string()));
        owned.collect()
    };
    match &model.prompt.entry {
        Some(EntryLine::Find(_)) => {
            return fixed(&[
                ("type", "to find"),
                ("↓ Ctrl-f", "next"),
                ("↑", "the one before"),
                ("Enter", "stay there"),
                ("Esc", "go back"),
            ]);
        }
        Some(EntryLine::Line(_) | EntryLine::SaveAs(_)) => {
            let words = match &model.prompt.entry {
                Some(EntryLine::SaveAs(_)) => "save",
                _ => "go there",
            };
            return fixed(&[("Enter", words), ("Esc", "leave it")]);
        }
        None => {}
    }
    let mut shown: Vec<_> = ACTIONS
        .iter()
        .filter(|e| e.scope == Scope::Editor && e.footer > 0)
        .collect();
    shown.sort_by_key(|e| e.footer);
    let emacs = model.prompt.editor.keys() == Keys::Emacs;
    let hint = |entry: &&Entry| {
        let mut keys = model.look.keymap.keys(entry);
        // Its own keys are not taken away from Emacs.
        let key = if emacs { keys.last() } else { keys.next() };
        Some((key?.to_string(), entry.short.to_string()))
    };
    together(shown.iter().filter_map(hint))
}

/// Keys that follow each other and do the same in both directions share their words.
fn together(hints: impl Iterator<Item = (String, String)>) -> Vec<(String, String)> {
    let mut joined: Vec<(String, String)> = Vec::new();
    for (key, words) in hints {
        match joined.last_mut().filter(|(_, last)| *last == words) {
            Some((keys, _)) => {
                // `Alt-↑` and `Alt-↓` are `Alt-↑↓`.
                let modifier = key.rfind('-').filter(|&at| at + 1 < key.len());
                let same = modifier.filter(|&at| keys.starts_with(&key[..=at]));
                let more = same.map_or(key.as_str(), |at| &key[at + 1..]);
                // Letters and digits stand apart, so that they are not read as one word.
                if more.starts_with(char::is_alphanumeric) {
                    keys.push(' ');
                }
                keys.push_str(more);
            }
            None => joined.push((key, words)),
        }
    }
    joined
}

fn hints(model: &Model) -> Vec<(String, String)> {
    let fixed = |pairs: &[(&str, &str)]| -> Vec<(String, String)> {
        pairs
            .iter()
            .map(|(k, w)| ((*k).to_string(), (*w).to_string()))
            .collect()
    };
    match model.overlays.last() {
        Some(Overlay::Help { .. }) => {
            return fixed(&[
                ("type", "to search"),
                ("↑↓", "scroll"),
                ("PgUp PgDn", "a page"),
                ("Esc", "close"),
            ]);
        }
        Some(Overlay::About { .. }) => {
            return fixed(&[
                ("↑↓", "scroll"),
                ("PgUp PgDn", "a page"),
                ("Esc", "or another key closes"),
            ]);
        }
        Some(Overlay::Values { .. }) => {
            let (back, on) = (Action::StepBack, Action::StepForward);
            let steps = model.look.key(back) + &model.look.key(on);
            let mut hints = vec![(steps, "step".to_string())];
            hints.extend(hint_of(model, Action::NextObstacle));
            hints.extend(fixed(&[("↑↓", "scroll"), ("Esc", "close")]));
            hints.extend(fixed(&[("PgUp PgDn", "a page")]));
            hints.extend(hint_of(model, Action::CollisionStep));
            hints.extend(hint_of(model, Action::MinimumStep));
            return hints;
        }
        Some(Overlay::Themes(_)) => {
            return fixed(&[
                ("type", "to search"),
                ("↑↓", "look"),
                ("Enter", "choose"),
                ("Esc", "back to what it was"),
            ]);
        }
        Some(Overlay::History) if model.history.typing.is_some() => {
            return fixed(&[
                ("type", "words and filters, or what is asked for"),
                ("Enter", "done"),
                ("Esc", "leave"),
            ]);
        }
        Some(Overlay::History) => return own(model, Scope::History),
        Some(Overlay::Jobs) => return own(model, Scope::Jobs),
        Some(Overlay::Results) => return own(model, Scope::Results),
        Some(Overlay::Batch) => return fixed(&[("Enter", "ask"), ("Esc", "do not")]),
        Some(Overlay::Tags { .. }) => {
            return fixed(&[("type", "tags"), ("Enter", "keep"), ("Esc", "as before")]);
        }
        Some(Overlay::Details(_)) => {
            return fixed(&[
                ("←→", "step"),
                ("↑↓", "scroll"),
                ("y", "copy"),
                ("Esc", "close"),
                ("space", "play"),
                ("PgUp PgDn", "a page"),
            ]);
        }
        Some(Overlay::Cycle(_)) => {
            let mut hints = fixed(&[("←→", "cycle"), ("↑↓", "scroll"), ("Esc", "close")]);
            hints.extend(hint_of(model, Action::NextForecast));
            hints.extend(hint_of(model, Action::PlotDrives));
            return hints;
        }
        Some(Overlay::Variant(_)) => {
            let mut hints = fixed(&[("←→", "step"), ("↑↓", "scroll"), ("Esc", "close")]);
            hints.extend(hint_of(model, Action::SwitchVariant));
            hints.extend(hint_of(model, Action::PlotDrives));
            return hints;
        }
        Some(Overlay::Layers(_)) => {
            return fixed(&[("↑↓", "select"), ("Enter", "switch"), ("Esc", "close")]);
        }
        Some(Overlay::Source { .. }) => {
            let next = hint_of(model, Action::NextObstacle);
            let keys = [
                ("↑↓", "scroll"),
                ("PgUp PgDn", "a page"),
                ("g G", "begin, end"),
            ];
            return [
                fixed(&keys),
                next.into_iter().collect(),
                fixed(&[("Esc", "close")]),
            ]
            .concat();
        }
        Some(
            Overlay::Palette(_)
            | Overlay::Models { .. }
            | Overlay::Measures { .. }
            | Overlay::Pictures(_)
            | Overlay::Templates { .. },
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
    if model.compare.open && model.compare.ratings.is_some() {
        return fixed(&[("any key", "closes")]);
    }
    if model.compare.open && model.compare.marking.is_some() {
        return fixed(&[
            ("↑↓", "select"),
            ("type", "words of your own"),
            ("Enter", "mark"),
            ("Esc", "leave it"),
        ]);
    }
    if model.prompt.editing {
        return editing(model);
    }
    if model.list.filtering {
        return fixed(&[
            ("type", "to filter"),
            ("↑↓", "select"),
            ("Enter", "keep"),
            ("Esc", "clear"),
        ]);
    }
    if !model.look.pending.is_empty() {
        let keys = Chord(model.look.pending.clone()).to_string();
        return vec![(keys, "…".into()), ("Esc".into(), "give up".into())];
    }
    let here = if model.compare.open {
        Scope::Compare
    } else {
        Scope::Global
    };
    let mut shown: Vec<_> = ACTIONS
        .iter()
        .filter(|e| e.footer > 0 && e.scope == here)
        .collect();
    shown.sort_by_key(|e| e.footer);
    let mut hints: Vec<(String, String)> = Vec::new();
    if model.answers.is_running() {
        hints.push(("Esc".into(), "cancel request".into()));
    }
    if model.taken.is_some() && !model.compare.open {
        // The way back is needed only here.
        hints.extend(hint_of(model, Action::RecordedEgo));
    }
    let compare = &model.compare;
    let works = |entry: &Entry| match (entry.scope, entry.action) {
        (Scope::Compare, Action::BestSecond) => compare.shown.len() > 1,
        (Scope::Compare, Action::BestThird) => compare.shown.len() > 2,
        (Scope::Compare, Action::BestFourth) => compare.shown.len() > 3,
        (Scope::Compare, Action::NextRound) => compare.blind.is_some(),
        _ => true,
    };
    let hint = |entry: &Entry| {
        if !works(entry) {
            return None;
        }
        let key = model.look.keymap.keys(entry).next()?;
        let words = match entry.action {
            Action::Play if model.clock.playing => "pause",
            _ => entry.short,
        };
        Some((key.to_string(), words.to_string()))
    };
    hints.extend(together(shown.into_iter().filter_map(hint)));
    hints
}

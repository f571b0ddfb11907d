//! The footer: keys that work in the current context, from the action table.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use unicode_width::UnicodeWidthStr;

use crate::settings::Keys;
use crate::tui::action::{Action, Entry, Scope};
use crate::tui::keymap::Chord;
use crate::tui::model::{EntryLine, Model};
use crate::tui::widgets::hints::{Hint, entries, fixed, hint_of, together};

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

/// The keys of the editor, or of the line below it.
fn editing(model: &Model) -> Vec<Hint> {
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
    let emacs = model.prompt.editor.keys() == Keys::Emacs;
    let hint = |entry: &&Entry| {
        let mut keys = model.look.keymap.keys(entry);
        // Its own keys are not taken away from Emacs.
        let key = if emacs { keys.last() } else { keys.next() };
        Some((key?.to_string(), entry.short.to_string()))
    };
    together(entries(Scope::Editor).iter().filter_map(hint))
}

fn hints(model: &Model) -> Vec<Hint> {
    if !model.look.pending.is_empty() {
        let keys = Chord(model.look.pending.clone()).to_string();
        return vec![(keys, "…".into()), ("Esc".into(), "give up".into())];
    }
    if let Some(screen) = model.screens.top() {
        return screen.hints(model);
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
    let here = if model.compare.open {
        Scope::Compare
    } else {
        Scope::Global
    };
    let mut hints: Vec<Hint> = Vec::new();
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
    hints.extend(together(entries(here).into_iter().filter_map(hint)));
    hints
}

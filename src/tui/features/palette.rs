//! The command palette: every action by name or by another word for it, with its sentence and its keys.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::Paragraph;

use crate::action::{Action, Entry};
use crate::features::Step;
use crate::features::picker::Choice;
use crate::model::{Model, Picker, palette_shown};
use crate::widgets::words::pad;
use crate::widgets::{picker, window};

/// Columns and rows of the window at most.
const SIZE: (u16, u16) = (132, 44);
/// Columns of names.
const NAME: usize = 22;
/// Columns of all keys of an action, and of one.
const KEYS: usize = 20;
const KEY: usize = 10;
/// Columns of the window from which all keys are shown.
const WIDE: usize = 100;
/// Columns of the sign before a name, and of the blanks between columns.
const SIGN: usize = 2;
const GAP: usize = 2;

/// Actions by name.
#[derive(Debug)]
pub struct Palette;

impl Choice for Palette {
    fn count(&self, model: &Model, picker: &Picker) -> usize {
        palette_shown(model, picker).len()
    }

    fn choose(&mut self, model: &mut Model, picker: &Picker) -> Step {
        let shown = palette_shown(model, picker);
        let Some(entry) = shown.get(picker.selected) else {
            return Step::close();
        };
        if let (Action::ChooseIndex, Some(folder)) = (entry.action, argument(&picker.text)) {
            model.index.typed = Some(folder.to_string());
        }
        Step::Perform(entry.action)
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker) {
        let inner = window::window(frame, screen, model, "actions", SIZE);
        let theme = &model.theme;
        let width = usize::from(inner.width);
        let shown = palette_shown(model, picker);
        let typed = picker::typed(model, picker, shown.len(), width);
        let mut text = Text::from(vec![typed, Line::default()]);
        let rows: Vec<Vec<Line<'static>>> = {
            let row = |(i, entry): (usize, &&Entry)| row(model, entry, i == picker.selected, width);
            shown.iter().enumerate().map(row).collect()
        };
        let room = usize::from(inner.height).saturating_sub(text.lines.len());
        for row in &rows[first(&rows, picker.selected, room)..] {
            text.extend(row.iter().cloned());
        }
        if rows.is_empty() {
            let none = "  no action matches";
            text.push_line(Line::styled(none, Style::new().fg(theme.dim)));
        }
        frame.render_widget(Paragraph::new(text), inner);
    }
}

/// What is typed behind the name of the action that takes a folder.
fn argument(text: &str) -> Option<&str> {
    let folder = text.trim_start().strip_prefix("index ")?.trim();
    (!folder.is_empty()).then_some(folder)
}

/// The first row that is shown, so that the selected one is in sight as a whole.
fn first(rows: &[Vec<Line<'_>>], selected: usize, room: usize) -> usize {
    let mut used = 0;
    let before = rows.iter().take(selected + 1).enumerate().rev();
    let mut fitting = before.take_while(|(_, lines)| {
        used += lines.len();
        used <= room
    });
    let first = fitting.by_ref().last();
    first.map_or(0, |(place, _)| place)
}

/// The lines of an action: its name, its sentence over as many lines as that takes, its keys.
fn row(model: &Model, entry: &Entry, selected: bool, width: usize) -> Vec<Line<'static>> {
    let (most, columns) = match width {
        ..WIDE => (1, KEY),
        _ => (usize::MAX, KEYS),
    };
    let keys = model
        .look
        .keymap
        .keys(entry)
        .take(most)
        .map(ToString::to_string)
        .collect::<Vec<_>>()
        .join("  ");
    let room = width
        .saturating_sub(SIGN + NAME + GAP + columns + GAP)
        .max(16);
    let sign = if selected { "▸ " } else { "  " };
    let key = Style::new()
        .fg(model.theme.accent)
        .add_modifier(Modifier::BOLD);
    let mut lines = Vec::new();
    let doc = match entry.elsewhere(model.place()) {
        Some(other) => format!("{} Only {}.", entry.doc, other.words()),
        None => entry.doc.to_string(),
    };
    for (i, words) in textwrap::wrap(&doc, room).into_iter().enumerate() {
        let (name, keys) = match i {
            0 => (format!("{sign}{}", pad(entry.id, NAME)), keys.as_str()),
            _ => (" ".repeat(SIGN + NAME), ""),
        };
        let line = Line::from(vec![
            Span::raw(format!("{name}{}", " ".repeat(GAP))),
            Span::raw(pad(&words, room)),
            Span::styled(format!("{}{}", " ".repeat(GAP), pad(keys, columns)), key),
        ]);
        lines.push(if selected {
            model.theme.select(line)
        } else {
            line
        });
    }
    lines
}

//! The command palette: every action by name.

use ratatui::Frame;
use ratatui::layout::Rect;

use super::Step;
use super::picker::Choice;
use crate::tui::model::{Model, Picker, palette_shown};
use crate::tui::widgets::words::pad;
use crate::tui::widgets::{picker, window};

/// Actions by name.
#[derive(Debug)]
pub struct Palette;

impl Choice for Palette {
    fn count(&self, _model: &Model, picker: &Picker) -> usize {
        palette_shown(picker).len()
    }

    fn choose(&mut self, _model: &mut Model, picker: &Picker) -> Step {
        let shown = palette_shown(picker);
        let entry = shown.get(picker.selected);
        entry.map_or(Step::close(), |entry| Step::Perform(entry.action))
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker) {
        let inner = window::window(frame, screen, model, "actions", (84, 22));
        let rows = palette_shown(picker).into_iter().map(|entry| {
            let keys = model.look.keymap.keys(entry);
            let keys: Vec<String> = keys.map(ToString::to_string).collect();
            let left = format!("{} {}", pad(entry.id, 18), entry.doc);
            (left, keys.join("  "))
        });
        picker::draw(frame, inner, model, picker, &rows.collect::<Vec<_>>());
    }
}

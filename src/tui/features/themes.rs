//! Picker for themes, with live preview.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::widgets::{Paragraph, Wrap};

use crate::features::Step;
use crate::features::picker::{Choice, PickerScreen};
use crate::model::{Model, Picker, themes_shown};
use crate::widgets::hints::{Hint, fixed};
use crate::widgets::{picker, window};
use nearmiss_settings::ThemeFile;

/// Rows that say how a theme is kept.
const HINT: u16 = 2;

/// Themes by name.
#[derive(Debug)]
pub struct Themes;

/// Opens the list at the theme that is chosen.
pub fn open(model: &mut Model) {
    let mut picker = Picker::default();
    let shown = themes_shown(model, &picker);
    let now = shown.iter().position(|name| *name == model.look.chosen);
    picker.selected = now.unwrap_or(0);
    let choice = Themes;
    model.screens.open(PickerScreen { picker, choice });
}

fn selected(model: &Model, picker: &Picker) -> Option<String> {
    themes_shown(model, picker).into_iter().nth(picker.selected)
}

impl Choice for Themes {
    fn count(&self, model: &Model, picker: &Picker) -> usize {
        themes_shown(model, picker).len()
    }

    fn choose(&mut self, model: &mut Model, picker: &Picker) -> Step {
        let Some(name) = selected(model, picker) else {
            return Step::close();
        };
        match model.look.theme(&name) {
            Ok(theme) => {
                model.theme = theme;
                model.look.chosen.clone_from(&name);
                let how_long = if model.recall.on {
                    "for this session"
                } else {
                    "until you quit"
                };
                model.say(format!(
                    "theme {name} {how_long}; to keep it, set `theme = {name:?}` in {}",
                    model.look.config_file
                ));
            }
            Err(why) => {
                model.complain(format!("the theme has not changed: {why}"));
                self.leave(model);
            }
        }
        Step::close()
    }

    fn preview(&self, model: &mut Model, picker: &Picker) {
        let name = selected(model, picker).unwrap_or_else(|| model.look.chosen.clone());
        // Why it cannot be shown stands in the list.
        let _ = model.show_theme(&name);
    }

    fn leave(&self, model: &mut Model) {
        // It could be shown before.
        let _ = model.show_theme(&model.look.chosen.clone());
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker) {
        // At the side, so that the colours are seen.
        let side = Rect {
            x: screen.x,
            width: screen.width.min(56),
            ..screen
        };
        let rows = themes_shown(model, picker).into_iter().map(|name| {
            let note = note(model, &name);
            (name, note)
        });
        let rows: Vec<_> = rows.collect();
        // The line that is typed, an empty one, the list, the words below it, and the borders.
        let height = model.look.themes.len()
            + ThemeFile::pairs().count()
            + 5
            + picker::WHOLE
            + usize::from(HINT);
        let height = u16::try_from(height).unwrap_or(u16::MAX).min(24);
        let inner = window::window(frame, side, model, "theme", (52, height));
        let [list, hint] =
            Layout::vertical([Constraint::Min(0), Constraint::Length(HINT)]).areas(inner);
        picker::draw(frame, list, model, picker, &rows);
        let name = selected(model, picker).unwrap_or_default();
        let words = format!("keep: `theme = {name:?}` in {}", model.look.config_file);
        let words = Paragraph::new(words).wrap(Wrap { trim: true });
        frame.render_widget(words.style(Style::new().fg(model.theme.dim)), hint);
    }

    fn hints(&self) -> Vec<Hint> {
        fixed(&[
            ("type", "to search"),
            ("↑↓", "preview"),
            ("Enter", "choose"),
            ("Esc", "revert"),
        ])
    }
}

/// The note beside a theme's name.
fn note(model: &Model, name: &str) -> String {
    let named = model.look.themes.iter().find(|named| named.name == name);
    match named.map(|named| (&named.theme, &named.file)) {
        None => "dark or light, follows the terminal".to_string(),
        Some((Err(mistakes), _)) => mistakes.first().cloned().unwrap_or_default(),
        Some((Ok(theme), file)) => {
            let ground = if theme.dark { "dark" } else { "light" };
            let yours = if file.is_some() { ", yours" } else { "" };
            format!("{ground}{yours}")
        }
    }
}

//! The window to choose the index of a corpus: a typed folder, the one in use, the configured one, or none.

use ratatui::Frame;
use ratatui::layout::Rect;

use super::{Screen, Step};
use crate::action::Action;
use crate::keymap::{Code, Key, edit_line, first_line};
use crate::message::Effect;
use crate::model::{IndexChoice, Model, Picker};
use crate::widgets::hints::{Hint, fixed};
use crate::widgets::{picker, window};
use nearmiss_base::system::shown_path;
use nearmiss_scene::description::visible;

/// The window.
#[derive(Debug, Default)]
pub struct IndexScreen {
    picker: Picker,
}

/// A line: the folder as it is given to the action, empty for none, and what choosing it does.
struct Row {
    folder: String,
    words: String,
}

impl Screen for IndexScreen {
    fn on_key(&mut self, model: &mut Model, key: Key) -> Option<Step> {
        match key.code {
            Code::Esc => return Some(Step::close()),
            Code::Enter => {
                let chosen = rows(model, &self.picker)
                    .into_iter()
                    .nth(self.picker.selected);
                return Some(match chosen {
                    Some(row) => {
                        model.index.typed = Some(row.folder);
                        Step::CloseAndPerform(Action::ChooseIndex)
                    }
                    None => Step::stay(),
                });
            }
            Code::Up => self.picker.selected = self.picker.selected.saturating_sub(1),
            Code::Down | Code::Tab => self.picker.selected += 1,
            _ if edit_line(&mut self.picker.text, key) => self.picker.selected = 0,
            _ => {}
        }
        Some(Step::stay())
    }

    fn paste(&mut self, _model: &mut Model, text: &str) -> Vec<Effect> {
        self.picker.text.push_str(&first_line(text));
        self.picker.selected = 0;
        Vec::new()
    }

    fn follow(&mut self, model: &mut Model) -> Vec<Effect> {
        let last = rows(model, &self.picker).len().saturating_sub(1);
        self.picker.selected = self.picker.selected.min(last);
        Vec::new()
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let inner = window::window(frame, screen, model, "index of a corpus", (92, 12));
        let rows = rows(model, &self.picker)
            .into_iter()
            .map(|row| (visible(&row.words).into_owned(), String::new()));
        picker::draw(frame, inner, model, &self.picker, &rows.collect::<Vec<_>>());
        if self.picker.text.trim().is_empty() {
            let hint =
                "type the folder of an index; `nearmiss corpus index PATH… -o FOLDER` makes one";
            picker::hint(frame, inner, model, hint);
        }
    }

    fn hints(&self, _model: &Model) -> Vec<Hint> {
        fixed(&[
            ("type", "a folder"),
            ("↑↓", "select"),
            ("Enter", "choose"),
            ("Esc", "close"),
        ])
    }
}

fn rows(model: &Model, picker: &Picker) -> Vec<Row> {
    let mut rows = Vec::new();
    let here = &model.recall.here;
    if let Some(folder) = IndexChoice::meant(&picker.text, here) {
        rows.push(Row {
            words: format!("read {}", shown_path(&folder)),
            folder: picker.text.clone(),
        });
    }
    let index = &model.index;
    if let Some(folder) = &index.folder {
        rows.push(Row {
            words: format!("read {} again", shown_path(folder)),
            folder: IndexChoice::text(Some(folder)),
        });
    }
    if let Some(folder) = &index.configured
        && index.folder.as_ref() != Some(folder)
    {
        rows.push(Row {
            words: format!("read {}, from config.toml", shown_path(folder)),
            folder: IndexChoice::text(Some(folder)),
        });
    }
    if index.folder.is_some() {
        rows.push(Row {
            words: "no index".into(),
            folder: String::new(),
        });
    }
    rows
}

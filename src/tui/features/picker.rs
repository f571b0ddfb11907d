//! Shared behaviour of fuzzy pickers.

use std::fmt::Debug;

use ratatui::Frame;
use ratatui::layout::Rect;

use crate::action::Action;
use crate::features::{Screen, Step};
use crate::keymap::{Code, Key, edit_line, first_line};
use crate::message::Effect;
use crate::model::{Model, Picker};
use crate::widgets::hints::{Hint, fixed};

/// Items of a picker, and the effect of choosing one.
pub trait Choice: Debug + Send + 'static {
    /// How many lines match.
    fn count(&self, model: &Model, picker: &Picker) -> usize;

    /// Consequences of choosing the selected line; the list has closed.
    fn choose(&mut self, model: &mut Model, picker: &Picker) -> Step;

    /// Draws the list.
    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker);

    /// The line that is selected when the list opens.
    fn first(&self, _model: &Model) -> usize {
        0
    }

    /// Shows at once what the selected line would do.
    fn preview(&self, _model: &mut Model, _picker: &Picker) {}

    /// Takes the preview back: nothing was chosen.
    fn leave(&self, _model: &mut Model) {}

    /// The keys, for the footer.
    fn hints(&self) -> Vec<Hint> {
        fixed(&[
            ("type", "to search"),
            ("↑↓", "select"),
            ("Enter", "choose"),
            ("Esc", "close"),
        ])
    }
}

/// A list with its typed line.
#[derive(Debug)]
pub struct PickerScreen<C> {
    /// Input line and selection.
    pub picker: Picker,
    /// The items.
    pub choice: C,
}

/// Opens a list with nothing typed.
pub fn open(model: &mut Model, choice: impl Choice) {
    let picker = Picker {
        selected: choice.first(model),
        ..Picker::default()
    };
    model.screens.open(PickerScreen { picker, choice });
}

impl<C: Choice> Screen for PickerScreen<C> {
    fn on_key(&mut self, model: &mut Model, key: Key) -> Option<Step> {
        let picker = &mut self.picker;
        match key.code {
            Code::Esc => return Some(self.on_action(model, Action::Cancel)),
            Code::Enter => {
                return Some(match self.choice.choose(model, &self.picker) {
                    Step::Stay(effects) => Step::Close(effects),
                    Step::Perform(action) => Step::CloseAndPerform(action),
                    other => other,
                });
            }
            Code::Up => picker.selected = picker.selected.saturating_sub(1),
            Code::Down | Code::Tab => picker.selected += 1,
            _ if edit_line(&mut picker.text, key) => picker.selected = 0,
            _ => {}
        }
        Some(Step::stay())
    }

    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        if action != Action::Cancel {
            return Step::Ignored;
        }
        self.choice.leave(model);
        Step::close()
    }

    fn paste(&mut self, _model: &mut Model, text: &str) -> Vec<Effect> {
        self.picker.text.push_str(&first_line(text));
        self.picker.selected = 0;
        Vec::new()
    }

    fn follow(&mut self, model: &mut Model) -> Vec<Effect> {
        // The filter or a reload may leave fewer lines.
        let last = self.choice.count(model, &self.picker).saturating_sub(1);
        self.picker.selected = self.picker.selected.min(last);
        self.choice.preview(model, &self.picker);
        Vec::new()
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        self.choice.draw(frame, screen, model, &self.picker);
    }

    fn hints(&self, _model: &Model) -> Vec<Hint> {
        self.choice.hints()
    }
}

//! Picker for templates of the current task and frame.

use ratatui::Frame;
use ratatui::layout::Rect;

use super::Step;
use super::picker::Choice;
use crate::action::{Action, Scope};
use crate::model::{Model, Picker, templates_shown};
use crate::tasks::templates::{ChangeTemplate, TemplateChange};
use crate::widgets::{picker, window};
use nearmiss_ask::prompts::{Library, Origin};

/// Templates by file.
#[derive(Debug)]
pub struct Templates;

impl Choice for Templates {
    fn count(&self, model: &Model, picker: &Picker) -> usize {
        templates_shown(model, picker).len()
    }

    fn choose(&mut self, model: &mut Model, picker: &Picker) -> Step {
        let shown = templates_shown(model, picker);
        let Some(file) = shown.into_iter().nth(picker.selected) else {
            return Step::close();
        };
        if model.library.in_use(&file) {
            model.say(format!("{file} is in use already"));
            return Step::close();
        }
        Step::Close(vec![ChangeTemplate(file, TemplateChange::Use).into()])
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker) {
        let title = format!("templates · {} · {}", model.task.name(), model.frame.name());
        let inner = window::window(frame, screen, model, &title, (92, 18));
        let drafts = model.prompt.drafted();
        let rows = templates_shown(model, picker).into_iter().map(|file| {
            let sign = if model.library.in_use(&file) {
                "* "
            } else {
                "  "
            };
            let draft = if drafts.contains(&file) {
                ", with a draft"
            } else {
                ""
            };
            let from = match model.library.file(&file) {
                Some((_, Origin::Shipped)) => "shipped",
                _ if Library::shipped(&file).is_some() => "yours, overrides the shipped one",
                _ => "yours",
            };
            (format!("{sign}{file}"), format!("{from}{draft}"))
        });
        picker::draw(frame, inner, model, picker, &rows.collect::<Vec<_>>());
        let key = model
            .look
            .keymap
            .key_in(Action::SaveTemplateAs, Scope::Editor);
        let words = format!("* in use; {key} in the editor makes a new one");
        picker::hint(frame, inner, model, &words);
    }
}

//! Picker for models.

use ratatui::Frame;
use ratatui::layout::Rect;

use super::Step;
use super::picker::Choice;
use crate::judge;
use crate::tui::action::Action;
use crate::tui::model::{Model, Picker, models_shown};
use crate::tui::widgets::{picker, window};

/// Models by id.
#[derive(Debug)]
pub struct Models {
    /// Whether the chosen one is asked at once.
    pub ask: bool,
}

impl Choice for Models {
    fn count(&self, model: &Model, picker: &Picker) -> usize {
        models_shown(model, picker).len()
    }

    fn choose(&mut self, model: &mut Model, picker: &Picker) -> Step {
        let shown = models_shown(model, picker);
        let Some(id) = shown.into_iter().nth(picker.selected) else {
            return Step::close();
        };
        model.model.clone_from(&id);
        if self.ask {
            return Step::Perform(Action::Run);
        }
        let key = model.look.key(Action::Run);
        model.say(format!("{key} asks {id}"));
        Step::close()
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker) {
        let title = match self.ask {
            true => "ask another model",
            false => "model",
        };
        let inner = window::window(frame, screen, model, title, (76, 18));
        let rows = models_shown(model, picker).into_iter().map(|id| {
            let note = note(model, &id);
            (id, note)
        });
        picker::draw(frame, inner, model, picker, &rows.collect::<Vec<_>>());
        let words = "any provider/model can be typed; providers are set in config.toml";
        picker::hint(frame, inner, model, words);
    }
}

/// The note beside a model's id.
fn note(model: &Model, id: &str) -> String {
    let offer = model.offers.iter().find(|o| o.id == id);
    let warning = offer.and_then(|o| o.warning.clone());
    match offer.map(|o| &o.key) {
        _ if id == judge::MODEL => "built in, no network".to_string(),
        Some(Some((name, false))) => format!("{name} is not set"),
        _ if warning.is_some() => warning.unwrap_or_default(),
        Some(Some((name, true))) => format!("key in {name}"),
        Some(None) => "no key needed".to_string(),
        None => "as typed".to_string(),
    }
}

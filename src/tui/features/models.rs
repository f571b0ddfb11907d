//! Picker for models.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};

use crate::action::Action;
use crate::features::Step;
use crate::features::picker::Choice;
use crate::model::{Model, Picker, models_shown};
use crate::widgets::{picker, window};
use nearmiss_scene::judge;
use nearmiss_study::evaluation::is_stored_alone;

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

    /// The model in use, unless another one is to be asked, or the one asked last, or the first that is at hand: the
    /// built-in judge reads no prompt.
    fn first(&self, model: &Model) -> usize {
        let shown = models_shown(model, &Picker::default());
        let reads = |id: &&String| {
            let is_other = !self.ask || **id != model.model;
            is_other && **id != judge::MODEL && !is_stored_alone(id)
        };
        let asked = model.answers.columns.iter().rev().map(|c| &c.model);
        let lacks_key = |id: &str| {
            let offer = model.offers.iter().find(|offer| offer.id == id);
            offer.is_some_and(|offer| matches!(offer.key, Some((_, false))))
        };
        let at_hand = shown.iter().filter(|id| !lacks_key(id));
        let mut all = std::iter::once(&model.model).chain(asked).chain(at_hand);
        let first = all.find(reads);
        let place = first.and_then(|first| shown.iter().position(|id| id == first));
        place.unwrap_or(0)
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
        let price = model.price();
        model.say(format!("{key} asks {id}: {price}"));
        Step::close()
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker) {
        let title = if self.ask {
            "ask another model"
        } else {
            "model"
        };
        let inner = window::window(frame, screen, model, title, (100, 20));
        let shown = models_shown(model, picker);
        let prices = &model.prompt.prices;
        let selected = shown.get(picker.selected);
        let origin = selected.map(|id| match missing_key(model, id) {
            Some(name) => format!("{name} not set; {}", prices.origin(id)),
            None => prices.origin(id),
        });
        let bound = selected
            .and_then(|id| prices.bound(id))
            .map(|bound| format!("at most: {bound}"));
        let rows = shown.into_iter().map(|id| {
            let note = note(model, &id);
            (id, note)
        });
        // Below the list: what the bound counts, and where the price is from.
        let [list, above, below] = Layout::vertical([
            Constraint::Min(0),
            Constraint::Length(1),
            Constraint::Length(1),
        ])
        .areas(inner);
        picker::draw(frame, list, model, picker, &rows.collect::<Vec<_>>());
        let words = "any provider/model can be typed; config.toml sets up providers";
        picker::hint(frame, above, model, &bound.unwrap_or_default());
        picker::hint(frame, below, model, origin.as_deref().unwrap_or(words));
    }
}

/// The variable of the key that a model lacks.
fn missing_key<'m>(model: &'m Model, id: &str) -> Option<&'m str> {
    match &model.offers.iter().find(|o| o.id == id)?.key {
        Some((name, false)) => Some(name),
        _ => None,
    }
}

/// What a model lacks, and its price: of the question as it stands, and per 1M tokens.
fn note(model: &Model, id: &str) -> String {
    if is_stored_alone(id) {
        return "imported answers".into();
    }
    let prices = &model.prompt.prices;
    let offer = model.offers.iter().find(|o| o.id == id);
    let mut parts = Vec::new();
    parts.extend(missing_key(model, id).map(|_| "no key".into()));
    let of_million = prices.per_million(id);
    let question = model.prompt.question.as_ref();
    let once = question
        .map(|_| model.price_of(id))
        .filter(|once| *once != of_million);
    parts.extend(once);
    parts.push(of_million);
    parts.extend(offer.and_then(|o| o.warning.clone()));
    parts.join(" · ")
}

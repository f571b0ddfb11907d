//! Picker for models.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};

use crate::action::Action;
use crate::features::Step;
use crate::features::picker::Choice;
use crate::model::{Model, Picker, models_shown};
use crate::widgets::{picker, window};
use nearmiss_base::system::pad_start;
use nearmiss_scene::judge;
use nearmiss_study::evaluation::is_stored_alone;
use unicode_width::UnicodeWidthStr;

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
        let notes = notes(model, &shown, usize::from(inner.width));
        let hidden = notes.get(picker.selected).map(|(_, hidden)| hidden.clone());
        let parts = hidden
            .into_iter()
            .chain(bound)
            .filter(|part| !part.is_empty());
        let bound = parts.collect::<Vec<_>>().join(" · ");
        let words = "any provider/model can be typed; config.toml sets up providers";
        let origin = origin.unwrap_or_else(|| words.into());
        let lines = |words: &str| {
            let is_long = words.width() > usize::from(inner.width);
            Constraint::Length(1 + u16::from(is_long))
        };
        let rows = shown
            .into_iter()
            .zip(notes)
            .map(|(id, (note, _))| (id, note));
        // Below the list: what the bound counts, and where the price is from.
        let [list, above, below] =
            Layout::vertical([Constraint::Min(0), lines(&bound), lines(&origin)]).areas(inner);
        picker::draw(frame, list, model, picker, &rows.collect::<Vec<_>>());
        picker::hint(frame, above, model, &bound);
        picker::hint(frame, below, model, &origin);
    }
}

/// The variable of the key that a model lacks.
fn missing_key<'m>(model: &'m Model, id: &str) -> Option<&'m str> {
    match &model.offers.iter().find(|o| o.id == id)?.key {
        Some((name, false)) => Some(name),
        _ => None,
    }
}

/// What stands at the right of each model, in columns, and what of it has no room there.
fn notes(model: &Model, ids: &[String], width: usize) -> Vec<(String, String)> {
    let mut rows: Vec<[String; CELLS]> = ids.iter().map(|id| cells(model, id)).collect();
    // The prices of a question and of an answer stand below each other, too.
    let output = |row: &[String; CELLS]| Some(row[PER_MILLION].split_once(", ")?.1.width());
    let widest = rows.iter().filter_map(output).max().unwrap_or(0);
    for row in &mut rows {
        if let Some((input, output)) = row[PER_MILLION].split_once(", ") {
            row[PER_MILLION] = format!("{input}, {}", pad_start(output, widest));
        }
    }
    let widest = |cell: usize| rows.iter().map(|row| row[cell].width()).max().unwrap_or(0);
    let widths: [usize; CELLS] = std::array::from_fn(widest);
    let names = ids.iter().map(|id| id.width()).max().unwrap_or(0);
    let room = width.saturating_sub(names + MARGINS);
    let mut shown: Vec<usize> = (0..CELLS).filter(|cell| widths[*cell] > 0).collect();
    let columns = |shown: &[usize]| shown.iter().map(|cell| widths[*cell] + GAP).sum::<usize>();
    while shown.len() > 1 && columns(&shown) > room + GAP {
        shown.pop();
    }
    let note = |row: &[String; CELLS]| {
        let padded = shown
            .iter()
            .map(|cell| pad_start(&row[*cell], widths[*cell]));
        let hidden = (0..CELLS).filter(|cell| !shown.contains(cell) && !row[*cell].is_empty());
        let hidden: Vec<String> = hidden.map(|cell| row[cell].replace("  ", " ")).collect();
        let gap = " ".repeat(GAP);
        (padded.collect::<Vec<_>>().join(&gap), hidden.join(" · "))
    };
    rows.iter().map(note).collect()
}

/// Columns beside a name and its note: the sign of the selected row, and what is between the two.
const MARGINS: usize = 6;

/// Columns between two cells of a note.
const GAP: usize = 2;

/// Cells of a note, and which of them is the price of 1M tokens.
const CELLS: usize = 4;
const PER_MILLION: usize = 2;

/// What a model lacks, the prices of the question as it stands and of 1M tokens, and a warning.
fn cells(model: &Model, id: &str) -> [String; CELLS] {
    let none = String::new;
    if is_stored_alone(id) {
        return [none(), "imported answers".into(), none(), none()];
    }
    let prices = &model.prompt.prices;
    let offer = model.offers.iter().find(|o| o.id == id);
    let lacks = missing_key(model, id).map_or("", |_| "no key").into();
    let warning = offer.and_then(|o| o.warning.clone()).unwrap_or_default();
    let of_million = prices.per_million(id);
    let question = model.prompt.question.as_ref();
    let once = question.map(|_| model.price_of(id));
    match once.filter(|once| *once != of_million) {
        Some(once) => [lacks, once, of_million, warning],
        // What is free or unknown is so by any measure.
        None if !of_million.contains(", ") => [lacks, of_million, none(), warning],
        None => [lacks, none(), of_million, warning],
    }
}

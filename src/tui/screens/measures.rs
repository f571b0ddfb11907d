//! Picker for the plotted measure.

use ratatui::Frame;
use ratatui::layout::Rect;

use super::Step;
use super::picker::Choice;
use crate::model::{Model, Picker, measures_shown};
use crate::widgets::picker;

/// Measures by id.
#[derive(Debug)]
pub struct Measures;

impl Choice for Measures {
    fn count(&self, _model: &Model, picker: &Picker) -> usize {
        measures_shown(picker).len()
    }

    fn choose(&mut self, model: &mut Model, picker: &Picker) -> Step {
        if let Some(measure) = measures_shown(picker).get(picker.selected) {
            model.plot.measure = measure;
            model.plot.drives = None;
        }
        Step::close()
    }

    fn first(&self, model: &Model) -> usize {
        let all = measures_shown(&Picker::default());
        let place = all.iter().position(|m| m.id == model.plot.measure.id);
        place.unwrap_or(0)
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker) {
        let rows = measures_shown(picker).into_iter().map(picker::measure_row);
        let rows: Vec<_> = rows.collect();
        picker::draw_measures(frame, screen, model, "plot", picker, &rows);
    }
}

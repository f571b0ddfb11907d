//! Picker for the sort order of the scenario list.

use ratatui::Frame;
use ratatui::layout::Rect;

use super::Step;
use super::picker::Choice;
use crate::model::{Model, Order, Picker, orders_shown};
use crate::tasks::scenarios::ranking;
use crate::widgets::picker;
use crate::widgets::words::pad;

/// Orders by id.
#[derive(Debug)]
pub struct Orders;

impl Choice for Orders {
    fn count(&self, _model: &Model, picker: &Picker) -> usize {
        orders_shown(picker).len()
    }

    fn choose(&mut self, model: &mut Model, picker: &Picker) -> Step {
        let shown = orders_shown(picker);
        let Some(order) = shown.get(picker.selected) else {
            return Step::close();
        };
        // By the same again, the other way around.
        model.list.sort_by(*order);
        Step::Close(ranking(model).into_iter().collect())
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker) {
        let row = |order: Order| match order {
            Order::Measure(measure) => picker::measure_row(measure),
            _ => {
                let left = format!("{} {}", pad(order.id(), 16), order.doc());
                (left, String::new())
            }
        };
        let rows: Vec<_> = orders_shown(picker).into_iter().map(row).collect();
        picker::draw_measures(frame, screen, model, "sort scenarios by", picker, &rows);
    }
}

//! The plot: requests its values in the background, chooses its measure, and marks obstacles for it.

pub mod draw;
pub mod state;

use std::sync::Arc;

use nearmiss_scene::metrics::{Measure, Series, Thresholds};
use nearmiss_scene::scenario::Scene;
use ratatui::Frame;
use ratatui::layout::Rect;

use crate::action::Action;
use crate::features::Step;
use crate::features::picker::Choice;
use crate::loaded::plotted;
use crate::model::{Model, Picker, SeriesId, measures_shown};
use crate::request::Computation;
use crate::widgets::picker;

/// Requests the plotted values, where another measure, scene or thresholds are plotted than before.
pub fn request(model: &mut Model) -> Option<PlotMeasure> {
    let scene = model.opened.as_ref().and_then(|o| o.scene.clone());
    let Some(scene) = scene else {
        model.plot.clear();
        return None;
    };
    let thresholds = model.thresholds.clone();
    if model.plot.is_asked(&scene, &thresholds) {
        return None;
    }
    let id = SeriesId(model.new_id());
    model.plot.wait(id, scene.clone(), thresholds.clone());
    Some(PlotMeasure {
        id,
        scene,
        measure: model.plot.measure,
        thresholds,
    })
}

/// Marks the picked obstacle for the plot, or takes the mark away.
pub fn mark(model: &mut Model) {
    match model.picked {
        None => {
            let key = model.look.key(Action::NextObstacle);
            model.say(format!("{key} picks an obstacle first"));
        }
        Some(id) => {
            if !model.plot.toggle(id) {
                let key = model.look.key(Action::Mark);
                model.say(format!(
                    "no room for another line; {key} on a marked obstacle takes its line away"
                ));
            }
        }
    }
}

/// A measure over a scene, for the plot.
#[derive(Debug)]
pub struct PlotMeasure {
    /// Its number.
    pub id: SeriesId,
    /// The scene.
    pub scene: Arc<Scene>,
    /// The measure.
    pub measure: &'static Measure,
    /// The thresholds of risk scores.
    pub thresholds: Arc<Thresholds>,
}

impl Computation for PlotMeasure {
    type Value = (SeriesId, Box<Series>);

    fn compute(self) -> Self::Value {
        let series = plotted(&self.scene, self.measure, &self.thresholds);
        (self.id, Box::new(series))
    }

    fn take(model: &mut Model, (id, series): Self::Value) {
        model.plot.take(id, series);
    }
}

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

//! Choosing what is plotted, and by what the list of scenarios is sorted.

use super::super::action::Action;
use super::super::model::{Model, Overlay, Picker};
use crate::metrics::Measure;

/// Opens the list of measures, to plot one or to sort by it.
pub fn choose(model: &mut Model, sort: bool) {
    model.overlays.push(Overlay::Measures {
        picker: Picker::default(),
        sort,
    });
}

/// Plots a measure.
pub fn plot(model: &mut Model, measure: &'static Measure) {
    model.plot.measure = measure;
    model.plot.drives = None;
    refresh(model);
}

/// Works the plotted values out again, after another scene was opened.
pub fn refresh(model: &mut Model) {
    let scene = model.opened.as_ref().and_then(|o| o.scene.as_deref());
    model.plot.refresh(scene, &model.thresholds);
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

/// The most dangerous value of a scenario is known.
pub fn ranked(model: &mut Model, measure: &str, place: usize, value: Option<f64>) {
    model.list.rank(measure, place, value);
}

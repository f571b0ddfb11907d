//! The plot over time: a measure for all obstacles together and for the selected ones.

use std::sync::Arc;

use crate::model::SeriesId;
use nearmiss_scene::metrics::{MEASURES, Measure, Series, Thresholds, measure};
use nearmiss_scene::scenario::Scene;

/// The measure that is plotted, and whose.
#[derive(Debug)]
pub struct Plot {
    /// Which measure.
    pub measure: &'static Measure,
    /// Obstacles that are plotted beside the picked one, in the order in which they were marked.
    pub marked: Vec<i64>,
    /// The measure's values over the opened scene, once computed.
    pub series: Option<Box<Series>>,
    /// The last request.
    asked: Option<SeriesRequest>,
    /// The comparison plotted instead of the measure, if the ego was planned.
    pub drives: Option<Drives>,
}

/// Values computed or in progress.
#[derive(Debug)]
struct SeriesRequest {
    id: SeriesId,
    measure: &'static str,
    scene: Arc<Scene>,
    thresholds: Arc<Thresholds>,
}

/// Plotted comparison of the planned and the recorded ego.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drives {
    /// The risk scores of a variant's attacker, before and after.
    Risk,
    /// The speeds of both.
    Speed,
    /// The distance between both, centre to centre.
    Distance,
}

/// More lines than this cannot be told apart.
const MOST_MARKED: usize = 5;

impl Default for Plot {
    fn default() -> Self {
        Self {
            measure: measure("risk").unwrap_or(&MEASURES[0]),
            marked: Vec::new(),
            series: None,
            asked: None,
            drives: None,
        }
    }
}

impl Plot {
    /// Whether the values of the measure over this scene are there or on their way.
    #[must_use]
    pub fn is_asked(&self, scene: &Arc<Scene>, thresholds: &Arc<Thresholds>) -> bool {
        self.asked.as_ref().is_some_and(|asked| {
            asked.measure == self.measure.id
                && Arc::ptr_eq(&asked.scene, scene)
                && Arc::ptr_eq(&asked.thresholds, thresholds)
        })
    }

    /// The values of the measure over this scene are on their way under a number.
    pub fn wait(&mut self, id: SeriesId, scene: Arc<Scene>, thresholds: Arc<Thresholds>) {
        self.series = None;
        self.asked = Some(SeriesRequest {
            id,
            measure: self.measure.id,
            scene,
            thresholds,
        });
    }

    /// Takes values, if nothing newer was asked for.
    pub fn take(&mut self, id: SeriesId, series: Box<Series>) {
        if self.asked.as_ref().is_some_and(|asked| asked.id == id) {
            self.series = Some(series);
        }
    }

    /// No data to plot.
    pub fn clear(&mut self) {
        self.series = None;
        self.asked = None;
    }

    /// Marks an obstacle, or takes its mark away; says whether there was room.
    pub fn toggle(&mut self, obstacle: i64) -> bool {
        match self.marked.iter().position(|&id| id == obstacle) {
            Some(place) => {
                self.marked.remove(place);
            }
            None if self.marked.len() >= MOST_MARKED => return false,
            None => self.marked.push(obstacle),
        }
        true
    }
}

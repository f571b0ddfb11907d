//! What is plotted over time: a measure, for everyone together and for the chosen obstacles.

use crate::metrics::{Context, MEASURES, Measure, Series, Thresholds};
use crate::scenario::Scene;

/// The measure that is plotted, and whose.
#[derive(Debug)]
pub struct Plot {
    /// Which measure.
    pub measure: &'static Measure,
    /// Obstacles that are plotted beside the picked one, in the order in which they were marked.
    pub marked: Vec<i64>,
    /// The measure's values over the opened scene.
    pub series: Option<Series>,
    /// What of the planned and the recorded ego is plotted in the measure's place, where the ego was planned.
    pub drives: Option<Drives>,
}

/// What of the planned and the recorded ego is plotted.
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
            measure: measure("risk"),
            marked: Vec::new(),
            series: None,
            drives: None,
        }
    }
}

/// The measure with this id, or the first one.
fn measure(id: &str) -> &'static Measure {
    let found = MEASURES.iter().find(|m| m.id == id);
    found.unwrap_or(&MEASURES[0])
}

impl Plot {
    /// Works the values out for a scene.
    pub fn refresh(&mut self, scene: Option<&Scene>, thresholds: &Thresholds) {
        let series = |scene| Series::of(&Context::under(scene, thresholds), vec![self.measure]);
        self.series = scene.map(series);
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

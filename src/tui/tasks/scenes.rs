//! Opens scenarios and computes values of their scenes: measures, plots, ground truths.

use std::sync::Arc;

use super::Tasks;
use crate::formats::{EgoSelection, Entry};
use crate::metrics::{Measure, Thresholds};
use crate::scenario::{Scene, Transform};
use crate::tui::loaded::{Measured, Opened, judged, plotted};
use crate::tui::message::{MeasureId, Msg, OpenId, SeriesId};
use crate::verdict::Task;

impl Tasks {
    /// Opens a scenario, with an obstacle as the ego if one is taken, after a change of its scene if there is one.
    pub(super) fn open(
        &self,
        id: OpenId,
        entry: Entry,
        obstacle: Option<i64>,
        change: Option<Transform>,
    ) {
        let ego = obstacle.map_or_else(|| self.ego.clone(), EgoSelection::Obstacle);
        let thresholds = self.thresholds.clone();
        self.background(move || {
            let opened = Opened::changed(&entry, &ego, &thresholds, change);
            Msg::Opened(id, opened.map(Box::new))
        });
    }

    /// Every measure of an obstacle, if one is picked, and of the scene.
    pub(super) fn measure(
        &self,
        id: MeasureId,
        scene: Arc<Scene>,
        obstacle: Option<i64>,
        thresholds: Arc<Thresholds>,
    ) {
        self.background(move || {
            let measured = Measured::new(&scene, obstacle, &thresholds);
            Msg::Measured(id, Box::new(measured))
        });
    }

    /// A measure over the scene, to be plotted.
    pub(super) fn plot(
        &self,
        id: SeriesId,
        scene: Arc<Scene>,
        measure: &'static Measure,
        thresholds: Arc<Thresholds>,
    ) {
        self.background(move || {
            let series = plotted(&scene, measure, &thresholds);
            Msg::Plotted(id, Box::new(series))
        });
    }

    /// The built-in judge's verdicts on windows of the scene.
    pub(super) fn judge_windows(
        &self,
        scene: Arc<Scene>,
        task: Task,
        windows: Vec<(i64, i64)>,
        thresholds: Arc<Thresholds>,
    ) {
        self.background(move || {
            let truths = judged(&scene, task, windows, &thresholds);
            Msg::Judged(scene, task, truths)
        });
    }
}

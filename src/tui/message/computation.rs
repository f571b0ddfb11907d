//! Computations on the open scene: the request, the work, and the value that comes back.
//!
//! They run on a thread of their own; where nothing waits for keys (screenshots, tests) they run at once.

use std::sync::Arc;

use crate::loaded::{Measured, plotted};
use crate::model::{Document, Future, PathRequest};
use crate::pixels::{ImageRequest, MapImage};
use nearmiss_scene::judge::{Judgement, judge_under};
use nearmiss_scene::metrics::{Measure, Series, Thresholds};
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::claims::{CheckedClaim, Subject, checked};

/// Numbers the requests for every measure; what an old one gives is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct MeasureId(pub u64);

/// Numbers the requests for what is plotted; what an old one gives is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct SeriesId(pub u64);

/// The first and last step of a window, and the built-in judge's answer about it.
pub type WindowJudgement = ((i64, i64), Judgement);

/// A value to compute.
#[derive(Debug)]
pub enum Computation {
    /// Every measure of an obstacle, if one is picked, and of the scene.
    Measure(MeasureId, Arc<Scene>, Option<i64>, Arc<Thresholds>),
    /// A measure over a scene, for the plot.
    Plot(SeriesId, Arc<Scene>, &'static Measure, Arc<Thresholds>),
    /// The built-in judge on windows of a scene, by their first and last steps.
    Judge(Arc<Scene>, Task, Vec<(i64, i64)>, Arc<Thresholds>),
    /// Predicted paths of obstacles.
    Paths(PathRequest),
    /// The map as an image.
    MapImage(Box<ImageRequest>),
    /// Claims of an answer, checked against the scene.
    Claims(Arc<Document>, Arc<Scene>),
}

/// A computed value, with its request.
#[derive(Debug)]
pub enum Computed {
    /// Every measure.
    Measured(MeasureId, Box<Measured>),
    /// The plotted values.
    Plotted(SeriesId, Box<Series>),
    /// The built-in judge on windows of a scene under thresholds.
    Judged(Arc<Scene>, Task, Arc<Thresholds>, Vec<WindowJudgement>),
    /// Predicted paths.
    Paths(PathRequest, Vec<Future>),
    /// The map as an image, or why there is none.
    MapImage(Result<MapImage, String>),
    /// The claims of a document, by its key.
    Claims(u64, Vec<CheckedClaim>),
}

impl Computation {
    /// Computes it; takes milliseconds, or seconds for every measure of a long recording.
    #[must_use]
    pub fn run(self) -> Computed {
        match self {
            Self::Measure(id, scene, obstacle, thresholds) => {
                let measured = Measured::new(&scene, obstacle, &thresholds);
                Computed::Measured(id, Box::new(measured))
            }
            Self::Plot(id, scene, measure, thresholds) => {
                Computed::Plotted(id, Box::new(plotted(&scene, measure, &thresholds)))
            }
            Self::Judge(scene, task, windows, thresholds) => {
                let judge = |(first, last): (i64, i64)| {
                    let steps = last.saturating_sub(first).saturating_add(1);
                    let steps = usize::try_from(steps).unwrap_or(1);
                    let window = Window::ending_at(&scene, last, steps);
                    (
                        (first, last),
                        judge_under(&scene, task, &window, &thresholds),
                    )
                };
                let found = windows.into_iter().map(judge).collect();
                Computed::Judged(scene, task, thresholds, found)
            }
            Self::Paths(request) => {
                let futures = request.predict();
                Computed::Paths(request, futures)
            }
            Self::MapImage(request) => Computed::MapImage(request.run()),
            Self::Claims(document, scene) => {
                let subject = Subject {
                    scene: &scene,
                    times: document.times,
                    window: document.window,
                };
                Computed::Claims(document.key, checked(&document.text, &subject))
            }
        }
    }
}
